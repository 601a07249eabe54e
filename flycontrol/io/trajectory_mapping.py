"""The mapping that reads a simulated flight back as a recording, or as a trial for a fit."""

from __future__ import annotations

from flycontrol.io.trajectory_columns import VARIABLES
from flycontrol.io.trajectory_files import FILE_NAMES, TrajectoryFormat
from flycontrol.model.flight_experiment import FlightExperiment
from flycontrol.units import deg, ms

_COMPONENTS = {variable.name: variable for variable in VARIABLES}
_HEAD = """\
# What {file} holds, for flycontrol report --recording and flycontrol fit.

name = "simulated flight"
source = "flycontrol"
"""


def trajectory_mapping(experiment: FlightExperiment, frequency: float, form: TrajectoryFormat) -> str:
    """Text of a mapping file for the trajectory of an experiment, as `trajectory_writer` writes it.

    `frequency` is that of the trimmed stroke [1/s].
    """
    head = _HEAD.format(file=FILE_NAMES[form])
    angle = experiment.morphology.stroke_plane_angle
    sections = motion_sections(form, stroke_plane_angle=angle, frequency=frequency)
    return "\n".join([head, *sections, *_perturbation(experiment, frequency)])


def motion_sections(
    form: TrajectoryFormat, *, stroke_plane_angle: float, frequency: float | None, unwrapped: bool = True
) -> list[str]:
    """Tables of a mapping for the variables of `flycontrol.io.trajectory_columns`.

    `frequency` [1/s] is that of the wingbeats, None where unknown; `unwrapped` says that yaw has no jumps.
    """
    table = form == "csv"
    beats = "" if frequency is None else f'wingbeat_frequency = "{frequency!r} Hz"\n'
    angle = stroke_plane_angle / deg
    return [
        f'[file]\nformat = "{form}"\n' + ('channels = "columns"\n' if table else ""),
        f'[clock]\ntime = {{ {_channel("time", table=table)}, unit = "s" }}\n{beats}',
        f'[frames]\nworld_z = "up"\nbody_axes = "forward right down"\nstroke_plane_angle = "{angle!r} deg"\n',
        f'[yaw]\n{_channel("yaw", table=table)}\nunit = "rad"\n' + ("unwrapped = true\n" if unwrapped else ""),
        f'[position]\n{_channels("position_W", table=table)}\nunit = "m"\n',
        f'[quaternion]\n{_channels("q_WB", table=table)}\norder = "scalar first"\nrotation = "body to world"\n',
        f'[velocity]\n{_channels("velocity_S", table=table)}\nunit = "m/s"\nframe = "stroke plane"\n',
        f'[angular_velocity]\n{_channels("angular_velocity_S", table=table)}\nunit = "rad/s"\nframe = "stroke plane"\n',
        *(_wing(side, table=table) for side in ("left", "right")),
    ]


def _perturbation(experiment: FlightExperiment, frequency: float) -> list[str]:
    """The one pulse, if it turns the fly about its yaw axis; several are no trial of the fit's kind."""
    if len(experiment.pulses) > 1:
        return [f"# {len(experiment.pulses)} torque pulses acted, so that none is given here as the [perturbation].\n"]
    if not experiment.pulses or experiment.pulses[0].torque_S[2] == 0:
        return []
    pulse = experiment.pulses[0]
    onset, duration = pulse.onset.at(frequency) / ms, pulse.duration.at(frequency) / ms
    return [f'[perturbation]\nonset = "{onset!r} ms"\nduration = "{duration!r} ms"\n']


def _wing(side: str, *, table: bool) -> str:
    lines = [f"[{side}]"]
    for number, angle in enumerate(_COMPONENTS[side].components):
        place = f'column = "{side}_{angle}"' if table else f'variable = "{side}", column = {number}'
        lines.append(f'{angle} = {{ {place}, unit = "rad" }}')
    return "\n".join(lines) + "\n"


def _channel(name: str, *, table: bool) -> str:
    return f'column = "{name}"' if table else f'variable = "{name}"'


def _channels(name: str, *, table: bool) -> str:
    if not table:
        return f'variable = "{name}"\ncolumns = {list(range(len(_COMPONENTS[name].components)))}'
    quoted = ", ".join(f'"{column}"' for column in _COMPONENTS[name].columns)
    return f"columns = [{quoted}]"

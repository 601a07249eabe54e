"""The mapping that reads a tracked flight back as a recording, or as a trial for a fit."""

from __future__ import annotations

from flycontrol.io.morphology_text import toml_string
from flycontrol.io.trajectory_files import TrajectoryFormat
from flycontrol.io.trajectory_mapping import motion_sections

RECORDING_NAMES: dict[TrajectoryFormat, str] = {
    "netcdf": "recording.nc",
    "hdf5": "recording.h5",
    "csv": "recording.csv",
}
_LONGEST_NAME = 100  #: characters, as a mapping allows
_HEAD = """\
# What {file} holds, for flycontrol report --recording and flycontrol fit: the smoothed motion.
# Add a [perturbation] if the fly was perturbed; flycontrol fit needs to know when.

name = {name}
source = "flycontrol"
"""


def tracked_mapping(
    form: TrajectoryFormat,
    *,
    name: str,
    stroke_plane_angle: float,
    frequency: float | None,
    whole: bool,
    empty: str = "",
) -> str:
    """Text of a mapping file for a tracked flight.

    Parameters
    ----------
    form
        Of the recording.
    name
        Of the flight, as of its films.
    stroke_plane_angle
        v_S = Ry(angle) v_B [rad].
    frequency
        Of the wingbeats [1/s]; None where there are too few to tell.
    whole
        No frame is lost, so that yaw has no gaps across which turns could be miscounted.
    empty
        Why the recording has no smoothed motion, one sentence; reading it is then refused with it.
    """
    head = _HEAD.format(file=RECORDING_NAMES[form], name=toml_string(name[:_LONGEST_NAME] or "tracked flight"))
    if empty:
        head += f"empty = {toml_string(empty)}\n"
    sections = motion_sections(form, stroke_plane_angle=stroke_plane_angle, frequency=frequency, unwrapped=whole)
    return "\n".join([head, *sections])

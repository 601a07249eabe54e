"""The files of a synthetic experiment: one table a trial, the mapping that reads them, and the truth apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from flycontrol.errors import InvalidInputError, OutputError
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg, ms

_HEADER = "time_ms,yaw_deg,d_alpha_deg"
_MAPPING = """\
# What the columns of these tables mean. The recordings are synthetic: `flycontrol example` made them.
name = "flycontrol example"
description = "Synthetic yaw of perturbed flies, not a measurement."

[file]
format = "csv"
channels = "columns"

[clock]
time = {{ column = "time_ms", unit = "ms" }}

[yaw]
column = "yaw_deg"  # wrapped at 180 deg, empty where a frame is missing
unit = "deg"

[trial]
fly = {{ file_name = "(fly[0-9]+)" }}  # recordings of one fly share it

[perturbation]  # a rectangular torque pulse; its strength is estimated
onset = "{onset:g} ms"
duration = "{duration:g} ms"

[paddling]  # once a wingbeat, empty in between
column = "d_alpha_deg"
unit = "deg"
convention = "d_alpha"
"""
_README = """\
SYNTHETIC DATA, made by `flycontrol example`, seed {seed}. Nothing here was measured on an animal.

{count} recordings of {flies} simulated flies, each turned by torque pulses of several strengths: yaw sampled at
{rate:g} 1/s with noise that is partly correlated, a ripple of the wingbeat and missing frames; the wings' paddling
angle once a wingbeat. The flies differ from each other by some percent.

  flycontrol fit {pattern} --mapping {mapping}

estimates gains, delay and damping. What is true stands in truth.toml; look there last.
"""


def example_files(
    trials: Sequence[Trial], flies: Mapping[str, Mapping[str, float]], impulses: Mapping[str, float], seed: int
) -> dict[str, str]:
    """Contents of the files by name.

    Parameters
    ----------
    trials
        With pulses of one onset and duration.
    flies
        True parameters of each fly, in SI units.
    impulses
        True angular impulse of each trial [rad/s].
    seed
        Of the simulation.
    """
    pulse = trials[0].perturbation
    if not isinstance(pulse, Pulse):
        raise InvalidInputError("An example needs trials with a pulse.")
    readme = _README.format(
        seed=seed, count=len(trials), flies=len(flies), rate=trials[0].rate, pattern="*.csv", mapping="mapping.toml"
    )
    return {
        "README.txt": readme,
        "mapping.toml": _MAPPING.format(onset=pulse.onset / ms, duration=pulse.duration / ms),
        "truth.toml": _truth(flies, impulses, seed),
        **{f"{trial.name}.csv": trial_table(trial) for trial in trials},
    }


def trial_table(trial: Trial) -> str:
    """Time [ms], yaw [deg], wrapped, and d_alpha [deg] as a CSV table; missing samples are empty fields."""
    yaw = (trial.yaw / deg + 180) % 360 - 180
    paddling = np.full(len(yaw), np.nan) if trial.paddling is None else trial.paddling / deg
    rows = zip(trial.time / ms, yaw, paddling, strict=True)
    lines = [",".join([f"{t:.6g}", *("" if np.isnan(v) else f"{v:.3f}" for v in values)]) for t, *values in rows]
    return "\n".join([_HEADER, *lines]) + "\n"


def refuse_other_files(folder: Path, files: Mapping[str, str]) -> None:
    """Refuse to overwrite a file that differs, or to mix with tables that the same pattern would match.

    Raises
    ------
    OutputError
        Which file stands there.
    """
    for path in sorted(folder.glob("*")) if folder.is_dir() else ():
        ours = files.get(path.name)
        if ours is None and path.suffix != ".csv":
            continue
        if ours is None or not path.is_file() or path.read_bytes() != ours.encode():
            raise OutputError(f"{path} stands there already and is not of this example; choose another folder.")


def _truth(flies: Mapping[str, Mapping[str, float]], impulses: Mapping[str, float], seed: int) -> str:
    lines = [
        "# The truth behind this synthetic experiment, in SI units and radians.",
        "# kp = K_P/I [1/s^2], kd = K_D/I [1/s], delay [s], damping = beta/I [1/s],",
        "# paddling_gain = gamma/I [1/s^2 per rad]",
        f"seed = {seed}",
    ]
    for fly, values in flies.items():
        lines += ["", f"[flies.{fly}]", *(f"{name} = {value:.10g}" for name, value in values.items())]
    lines += ["", "[angular_impulse]  # [rad/s]", *(f"{name} = {value:.10g}" for name, value in impulses.items())]
    return "\n".join(lines) + "\n"

"""Simulated trials to tables that the shipped mapping `simulated_trials` reads back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.model.trial import Pulse, Trial

MAPPING = "simulated_trials"  #: name of the mapping that reads the tables
_HEADER = "time_s,heading_rad,d_alpha_rad,pulse_onset_s,pulse_duration_s,fly"


def simulated_trial_files(trials: Sequence[Trial]) -> dict[str, str]:
    """Contents of one CSV table for each trial, by file name.

    Raises
    ------
    InvalidInputError
        A trial without a pulse, two of one name, or a name that is none of a file or a fly's in a table.
    """
    files: dict[str, str] = {}
    for trial in trials:
        if not isinstance(trial.perturbation, Pulse):
            raise InvalidInputError(f"{trial.name}: a simulated trial needs a torque pulse.")
        if f"{trial.name}.csv" in files:
            raise InvalidInputError(f"Two simulated trials are named {trial.name!r}; give each its own name.")
        if not _plain(trial.name) or not _plain(trial.fly):
            raise InvalidInputError(
                f"Names of simulated trials and flies take letters, digits, - and _, got {trial.name!r} of "
                f"{trial.fly!r}."
            )
        files[f"{trial.name}.csv"] = _table(trial, trial.perturbation)
    return files


def _plain(name: str) -> bool:
    return bool(name) and name.isascii() and all(letter.isalnum() or letter in "-_" for letter in name)


def _table(trial: Trial, pulse: Pulse) -> str:
    paddling = np.full(len(trial.time), np.nan) if trial.paddling is None else trial.paddling
    ending = f"{pulse.onset:.12g},{pulse.duration:.12g},{trial.fly}"
    rows = zip(trial.time, trial.yaw, paddling, strict=True)
    lines = [
        ",".join([f"{t:.12g}", *("" if np.isnan(v) else f"{v:.9g}" for v in values), ending]) for t, *values in rows
    ]
    return "\n".join([_HEADER, *lines]) + "\n"

"""A recording of body and wings as a trial of the yaw reflex, once it is said what perturbed the fly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.paddling import paddling
from flycontrol.model.recording import Recording
from flycontrol.model.trial import Pulse, TorqueTrace, Trial
from flycontrol.model.wingbeats import segment_wingbeats

FloatArray = NDArray[np.float64]


def trial_of_recording(recording: Recording, perturbation: Pulse | TorqueTrace | None, *, fly: str = "") -> Trial:
    """Yaw frame by frame, and d_alpha at the frame in the middle of each wingbeat where both wings were recorded.

    Parameters
    ----------
    recording
        With yaw.
    perturbation
        On the recording's clock; None: unknown.
    fly
        Whose it is; by default the recording's name.

    Raises
    ------
    InvalidInputError
        If the recording has no yaw, or wings in which no wingbeats are found.
    """
    if recording.yaw is None:
        raise InvalidInputError(f"{recording.name} has no yaw angle, which a trial of the yaw reflex is about; map it.")
    seen = recording.left is not None and recording.right is not None
    return Trial(
        name=recording.name, fly=fly, time=recording.time, yaw=recording.yaw, rate=recording.rate,
        perturbation=perturbation, paddling=_paddling(recording) if seen else None,
        source_sha256=recording.source_sha256, notes=recording.notes,
    )  # fmt: skip


def _paddling(recording: Recording) -> FloatArray:
    beats = segment_wingbeats(recording)
    found = np.full(len(recording.time), np.nan)
    found[np.searchsorted(recording.time, beats.middles)] = paddling(recording, beats).d_alpha
    return found

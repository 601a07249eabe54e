"""Where a fly is expected from where it was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.units import deg, mm
from flycontrol.vision.stance import BASE_MOVE, STEPS, TURN, WING_TURN, Stance, step_between, stepped

FloatArray = NDArray[np.float64]

_WINGS = slice(WING_TURN[0].start, WING_TURN[1].stop)
#: By how much a fly may surprise from one frame to the next, for frames that are bridged (C)
_DRIFT = np.concatenate([np.full(3, 0.02 * mm), np.full(3, 1 * deg), np.full(6, 8 * deg), np.full(6, 0.005 * mm)])
_UNKNOWN = 75 * deg  #: of a wing that may be at the other end of its stroke, about each axis (C)
_FADING = 0.6  #: of a wing's step, from frame to frame without sight (C)


def expectations(
    past: Sequence[Stance], bases_B: FloatArray, *, rolling: bool = True, unseen: bool = False
) -> list[Stance]:
    """x_n + v, and x_n + 2 v - v' of the step v before and v' before that; the wings' bases where the shape has them.

    Parameters
    ----------
    past : the last stances, one to three of them, the newest last
    bases_B : (2, 3) [m]
    rolling : whether the body's turn about its long axis goes on; it is no use where that is known roughly
    unseen : whether the last stances are themselves only expected; wings turn round, and none is thought to beat on
    """
    now = replace(past[-1], bases_B=bases_B)
    if len(past) == 1:
        return [now]
    step = step_between(past[-2], past[-1])
    step[BASE_MOVE[0].start :] = 0.0
    step[TURN.start] *= rolling
    step[_WINGS] *= _FADING if unseen else 1.0
    steady = stepped(now, step)
    if len(past) == 2:
        return [steady]
    before = step_between(past[-3], past[-2])
    faster = step.copy()
    faster[_WINGS] += step[_WINGS] - before[_WINGS]
    return [steady, stepped(now, faster)]


def drifted(covariance: FloatArray) -> FloatArray:
    """The covariance of steps (18, 18) after one more frame without sight [m, rad].

    Each standard deviation grows by a constant, since what was wrong goes on being wrong in the same direction; turns
    by no more than nothing is known of them, correlations stay.
    """
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    grown = size + _DRIFT
    turns = slice(TURN.start, WING_TURN[1].stop)
    grown[turns] = np.maximum(np.minimum(grown[turns], _UNKNOWN), size[turns])
    kept = covariance / np.outer(size, size) * np.outer(grown, grown)
    return np.where(np.eye(STEPS, dtype=np.bool_), grown**2, kept)  # the diagonal: also of what was certain


def unseen_wing(covariance: FloatArray, before: FloatArray, side: int) -> FloatArray:
    """The covariance of steps (18, 18) with a wing known only from what was known of it before, one frame on."""
    grown = drifted(before)
    columns = np.r_[WING_TURN[side], BASE_MOVE[side]]
    found = covariance.copy()
    found[columns, :], found[:, columns] = 0.0, 0.0
    found[np.ix_(columns, columns)] = grown[np.ix_(columns, columns)]
    return found

"""Where a fly is expected from where it was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.units import deg, mm
from flycontrol.vision.stance import BASE_MOVE, MOVE, STEPS, TURN, WING_TURN, Stance, step_between, stepped

FloatArray = NDArray[np.float64]

#: By how much a fly may surprise from one frame to the next, for frames that are bridged (C)
_DRIFT_MOVE, _DRIFT_TURN, _DRIFT_WING, _DRIFT_BASE = 0.02 * mm, 1 * deg, 8 * deg, 0.005 * mm


def expectations(past: Sequence[Stance], bases_B: FloatArray, *, rolling: bool = True) -> list[Stance]:
    """x_n + v, and x_n + 2 v - v' of the step v before and v' before that; the wings' bases where the shape has them.

    Parameters
    ----------
    past : the last stances, one to three of them, the newest last
    bases_B : (2, 3) [m]
    rolling : whether the body's turn about its long axis goes on; it is no use where that is known roughly
    """
    now = replace(past[-1], bases_B=bases_B)
    if len(past) == 1:
        return [now]
    step = step_between(past[-2], past[-1])
    step[BASE_MOVE[0].start :] = 0.0
    step[TURN.start] *= rolling
    steady = stepped(now, step)
    if len(past) == 2:
        return [steady]
    before = step_between(past[-3], past[-2])
    wings = slice(WING_TURN[0].start, WING_TURN[1].stop)
    faster = step.copy()
    faster[wings] += step[wings] - before[wings]
    return [steady, stepped(now, faster)]


def drifted(covariance: FloatArray) -> FloatArray:
    """The covariance of steps (18, 18) after one more frame without sight [m, rad]."""
    spread = np.empty(STEPS)
    spread[MOVE], spread[TURN] = _DRIFT_MOVE, _DRIFT_TURN
    for k in (0, 1):
        spread[WING_TURN[k]], spread[BASE_MOVE[k]] = _DRIFT_WING, _DRIFT_BASE
    return covariance + np.diag(spread**2)


def unseen_wing(covariance: FloatArray, before: FloatArray, side: int) -> FloatArray:
    """The covariance of steps (18, 18) with a wing known only from what was known of it before, one frame on."""
    grown = drifted(before)
    columns = np.r_[WING_TURN[side], BASE_MOVE[side]]
    found = covariance.copy()
    found[columns, :], found[:, columns] = 0.0, 0.0
    found[np.ix_(columns, columns)] = grown[np.ix_(columns, columns)]
    return found

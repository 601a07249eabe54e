"""The loop's equation integrated twice, on a coarse even grid: linear in everything but the delay.

    y = c0 + c1 t + c2 t^2 - b I(y) - kp II(y_T) - kd I(y_T) - ki III(y_T) + J II(u),   y_T(t) = y(t - T),

where I integrates from the start, so that noise is averaged, not differentiated; the polynomial takes up heading,
initial yaw and rate. Good for starting values, not for estimates: its regressors carry the noise of y.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.identify.gains.kernels import regression as kernels
from flycontrol.identify.gains.problem import FitProblem, TrialPart
from flycontrol.identify.gains.response import NAMES, Drive

FloatArray = NDArray[np.float64]
_FEWEST, _MOST = 160, 1500  #: points of the longest trial
_STEP = 0.7e-3  #: between those bounds the grid's step [s]
_IMPULSE = NAMES.index("impulse")
GAINS = ("damping", "kp", "kd", "ki")  #: in the order of the kernel


@dataclass(frozen=True, slots=True, eq=False)
class Regression:
    """One trial on a coarse even grid, its yaw integrated once, twice and three times."""

    part: TrialPart
    step: float  #: of the grid [s]
    integrals: FloatArray  #: (4, n) yaw and its integrals from the first sample
    basis: FloatArray  #: (c, n) orthonormal rows that the trial's own unknowns span
    triangle: FloatArray  #: (c, c)
    push: bool  #: whether the first row is the drive's, for an unknown impulse
    moved: FloatArray  #: (n,) displacement by a known impulse [rad]


def regressions_of(problem: FitProblem) -> list[Regression]:
    """Every trial on grids of one step, so that one lag in samples is one delay."""
    longest = max(float(part.channels[0].times[-1] - part.channels[0].times[0]) for part in problem.parts)
    step = longest / min(max(longest / _STEP, _FEWEST), _MOST)
    return [_regression(part, step) for part in problem.parts]


def _regression(part: TrialPart, step: float) -> Regression:
    channel = part.channels[0]
    start = float(channel.times[0])
    n = max(int((float(channel.times[-1]) - start) / step) + 1, 8)
    tau = np.linspace(-1.0, 1.0, n)
    own, moved = [np.ones(n), tau, tau * tau], np.zeros(n)
    path = displacement(part.drive, start, step, n) if len(part.drive.majors) else moved
    push = _IMPULSE in part.active and bool(path.any())  # a pulse in the last cell moves nothing yet
    if push:
        own.insert(0, path)
    else:
        moved = part.resting[_IMPULSE] * path
    integrals = kernels.coarse_integrals(channel.times, channel.values, step, n)
    basis, triangle = kernels.orthonormal(np.array(own))
    return Regression(part, step, integrals, basis, triangle, push, moved)


def columns_of(regression: Regression, lag: int, asked: Sequence[str], known: Mapping[str, float]) -> FloatArray:
    """(k + 1, n): regressors of the gains asked for, then the target; yaw before the start is its first value."""
    return kernels.columns(regression.integrals, regression.moved, lag, *_asked(asked, known))


def products_of(
    regression: Regression, lags: NDArray[np.int64], asked: Sequence[str], known: Mapping[str, float]
) -> FloatArray:
    """(lags, k + 1, k + 1): products of the columns once the trial's own unknowns are projected out."""
    which, fixed = _asked(asked, known)
    return kernels.products(regression.integrals, regression.moved, regression.basis, lags, which, fixed)


def _asked(asked: Sequence[str], known: Mapping[str, float]) -> tuple[NDArray[np.int64], FloatArray]:
    """Places of the gains asked for, and the values of those known (4,)."""
    which = np.array([GAINS.index(name) for name in asked], dtype=np.int64)
    return which, np.array([float(known.get(name, 0.0)) for name in GAINS])


def displacement(drive: Drive, start: float, step: float, n: int) -> FloatArray:
    """Where a unit impulse of the drive alone would have moved a free body at the times of a grid (n,)."""
    return kernels.displacement(*drive.pieces, start, step, n)

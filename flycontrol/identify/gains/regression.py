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

from flycontrol.identify.gains.problem import FitProblem, TrialPart
from flycontrol.identify.gains.response import NAMES, Drive

FloatArray = NDArray[np.float64]
_FEWEST, _MOST = 160, 1500  #: points of the longest trial
_STEP = 0.7e-3  #: between those bounds the grid's step [s]
_IMPULSE = NAMES.index("impulse")


@dataclass(frozen=True, slots=True, eq=False)
class Regression:
    """One trial on a coarse even grid, its yaw integrated once, twice and three times."""

    part: TrialPart
    step: float  #: of the grid [s]
    integrals: FloatArray  #: (4, n) yaw and its integrals from the first sample
    basis: FloatArray  #: (n, c) orthonormal columns that the trial's own unknowns span
    triangle: FloatArray  #: (c, c)
    push: bool  #: whether the first column is the drive's, for an unknown impulse
    known: FloatArray  #: (n,) displacement by a known impulse [rad]


def regressions_of(problem: FitProblem) -> list[Regression]:
    """Every trial on grids of one step, so that one lag in samples is one delay."""
    longest = max(part.channels[0].times[-1] - part.channels[0].times[0] for part in problem.parts)
    step = longest / np.clip(longest / _STEP, _FEWEST, _MOST)
    return [_regression(part, float(step)) for part in problem.parts]


def _regression(part: TrialPart, step: float) -> Regression:
    channel = part.channels[0]
    n = max(int((channel.times[-1] - channel.times[0]) / step) + 1, 8)
    t = channel.times[0] + step * np.arange(n)
    y = _averaged(channel.times, channel.values, t)
    integrals = [y - y[0]]
    for _ in range(3):
        integrals.append(_integral(integrals[-1], step))
    tau = np.linspace(-1.0, 1.0, n)
    own, known = [np.ones(n), tau, tau**2], np.zeros(n)
    push = len(part.drive.majors) > 0 and _IMPULSE in part.active
    if push:
        own.insert(0, displacement(part.drive, t))
    elif len(part.drive.majors):
        known = part.resting[_IMPULSE] * displacement(part.drive, t)
    basis, triangle = np.linalg.qr(np.column_stack(own))
    return Regression(part, step, np.array(integrals), basis, triangle, push, known)


def columns_of(
    regression: Regression, lags: NDArray[np.int64], asked: Sequence[str], known: Mapping[str, float]
) -> FloatArray:
    """(lags, n, k + 1): regressors of the gains asked for, then the target; yaw before the start is its first value."""
    y, first, second, third = regression.integrals
    n = len(y)
    late = np.arange(n)[None, :] - lags[:, None]
    there, late = late >= 0, np.maximum(late, 0)
    named = {
        "damping": np.broadcast_to(-first, late.shape),
        "kp": np.where(there, -second[late], 0.0),
        "kd": np.where(there, -first[late], 0.0),
        "ki": np.where(there, -third[late], 0.0),
    }
    target = np.broadcast_to(y - regression.known, late.shape)
    for name, value in known.items():
        if name in named and value:
            target = target - value * named[name]
    return np.stack([*(named[name] for name in asked), target], axis=-1)


def products_of(
    regression: Regression, lags: NDArray[np.int64], asked: Sequence[str], known: Mapping[str, float]
) -> FloatArray:
    """(lags, k + 1, k + 1): products of the columns once the trial's own unknowns are projected out."""
    columns = columns_of(regression, lags, asked, known)
    rest = columns - regression.basis @ (regression.basis.T @ columns)
    return np.swapaxes(rest, 1, 2) @ rest


def displacement(drive: Drive, t: FloatArray) -> FloatArray:
    """Where a unit impulse of the drive alone would have moved a free body by the times t."""
    knots, levels, slopes = drive.pieces
    fine = np.linspace(min(t[0], knots[0]), t[-1], 8 * len(t))
    k = np.searchsorted(knots, fine, side="right") - 1
    u = np.where(k >= 0, levels[k] + slopes[k] * (fine - knots[k]), 0.0)
    h = fine[1] - fine[0]
    return np.interp(t, fine, _integral(_integral(u, h), h))


def _averaged(times: FloatArray, values: FloatArray, t: FloatArray) -> FloatArray:
    """Measured values at a coarser even grid: means over its cells, interpolated where a gap leaves a cell empty."""
    cell = np.clip(np.rint((times - t[0]) / (t[1] - t[0])).astype(np.int64), 0, len(t) - 1)
    count = np.bincount(cell, minlength=len(t))
    there = count > 0
    mean = np.bincount(cell, weights=values, minlength=len(t))[there] / count[there]
    centre = np.bincount(cell, weights=times, minlength=len(t))[there] / count[there]
    return np.interp(t, centre, mean)


def _integral(values: FloatArray, h: float) -> FloatArray:
    """Trapezoidal integral from the first sample to each."""
    out = np.zeros_like(values)
    np.cumsum((values[1:] + values[:-1]) * (h / 2), out=out[1:])
    return out

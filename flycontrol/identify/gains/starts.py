"""Starting values that need no user: the loop's equation, integrated twice, is linear in everything but the delay.

    y = c0 + c1 t + c2 t^2 - b I(y) - kp II(y_T) - kd I(y_T) - ki III(y_T) + J II(u),   y_T(t) = y(t - T),

where I integrates from the start, so that noise is averaged, not differentiated; the polynomial takes up heading,
initial yaw and rate. For each delay of a grid the gains shared by all trials follow from one linear regression.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.identify.gains.problem import FitProblem, TrialPart
from flycontrol.identify.gains.response import NAMES

FloatArray = NDArray[np.float64]
_POINTS = 160  #: of the longest trial that the regression uses
_DAMPINGS = (30.0, 80.0, 160.0)  #: [1/s], where noise in the regression would bias it
_RESTING = {"paddling_gain": 1e5, "limit": 1e4}
_IMPULSE, _PADDLING_GAIN = NAMES.index("impulse"), NAMES.index("paddling_gain")
_SHARED = ("damping", "kp", "kd", "ki")


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """One starting point and the residual that the regression leaves there."""

    x: FloatArray  #: (k,)
    residual: float  #: sum of squares [rad^2]
    lowest: bool  #: a local minimum over the delay


def starting_points(problem: FitProblem) -> Iterator[Start]:
    """One starting point for each delay tried: first the local minima of the regression's residual, best first."""
    lags, regressions = _lags(problem), _regressions(problem)
    asked = [name for name in _SHARED if name in problem.model.unknown]
    grams = sum(_gram(regression, lags, asked, dict(problem.model.known)) for regression in regressions)
    gains, residuals = _best_gains(np.asarray(grams), asked, problem)
    around = np.concatenate([[np.inf], residuals, [np.inf]])
    lowest = (around[:-2] >= residuals) & (residuals <= around[2:])
    order = np.lexsort((residuals, ~lowest))
    for i in order:
        yield Start(_point(problem, regressions, int(lags[i]), asked, gains[i]), float(residuals[i]), bool(lowest[i]))


@dataclass(frozen=True, slots=True, eq=False)
class _Regression:
    """One trial on a coarse even grid, its yaw integrated once, twice and three times."""

    part: TrialPart
    step: float  #: of the grid [s]
    integrals: FloatArray  #: (4, n) yaw and its integrals from the first sample
    basis: FloatArray  #: (n, c) orthonormal columns that the trial's own unknowns span
    triangle: FloatArray  #: (c, c)
    push: bool  #: whether the first column is the drive's, for an unknown impulse
    known: FloatArray  #: (n,) displacement by a known impulse [rad]


def _regressions(problem: FitProblem) -> list[_Regression]:
    """Every trial on grids of one step, so that one lag in samples is one delay."""
    longest = max(part.channels[0].times[-1] - part.channels[0].times[0] for part in problem.parts)
    return [_regression(part, longest / _POINTS) for part in problem.parts]


def _regression(part: TrialPart, step: float) -> _Regression:
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
        own.insert(0, _displacement(part, t))
    elif len(part.drive.majors):
        known = part.resting[_IMPULSE] * _displacement(part, t)
    basis, triangle = np.linalg.qr(np.column_stack(own))
    return _Regression(part, step, np.array(integrals), basis, triangle, push, known)


def _lags(problem: FitProblem) -> NDArray[np.int64]:
    """Delays to try, in samples of the coarse grid: those between the bounds, or the known one."""
    model = problem.model
    longest = max(part.channels[0].times[-1] - part.channels[0].times[0] for part in problem.parts)
    step = longest / _POINTS
    if "delay" not in model.unknown:
        return np.array([max(1, round(model.known["delay"] / step))])
    setting = model.unknown["delay"]
    if setting.start is not None:
        return np.array([max(1, round(setting.start / step))])
    low, high = max(setting.low, 2 * step), min(setting.high, longest / 3)
    return np.unique(np.rint(np.geomspace(low, max(high, low), 14) / step).astype(np.int64))


def _columns(
    regression: _Regression, lags: NDArray[np.int64], asked: Sequence[str], known: Mapping[str, float]
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


def _gram(
    regression: _Regression, lags: NDArray[np.int64], asked: Sequence[str], known: Mapping[str, float]
) -> FloatArray:
    """(lags, k + 1, k + 1): products of the columns once the trial's own unknowns are projected out."""
    columns = _columns(regression, lags, asked, known)
    rest = columns - regression.basis @ (regression.basis.T @ columns)
    return np.swapaxes(rest, 1, 2) @ rest


def _best_gains(grams: FloatArray, asked: Sequence[str], problem: FitProblem) -> tuple[FloatArray, FloatArray]:
    """For each lag the gains (k,) and the residual; damping is tried at a few values, where noise would bias it."""
    k = len(asked)
    if k == 0:
        return np.zeros((len(grams), 0)), grams[:, 0, 0]
    dampings: list[float | None] = [None]
    if "damping" in asked:
        setting = problem.model.unknown["damping"]
        tried = _DAMPINGS if setting.start is None else (setting.start,)
        dampings = [float(np.clip(b, setting.low, setting.high)) for b in tried]
    gains, residuals = np.zeros((len(grams), k)), np.full(len(grams), np.inf)
    for b in dampings:
        first = 0 if b is None else 1  # damping comes first among those asked for
        G, c = grams[:, first:k, first:k], grams[:, first:k, k]
        fixed = np.zeros((len(grams), 0)) if b is None else np.full((len(grams), 1), b)
        c = c - (grams[:, first:k, :first] @ fixed[..., None])[..., 0]
        scale = np.sqrt(np.maximum(np.diagonal(G, axis1=1, axis2=2), 1e-300))
        scaled = G / scale[:, :, None] / scale[:, None, :] + 1e-9 * np.eye(k - first)
        found = np.linalg.solve(scaled, (c / scale)[..., None])[..., 0] / scale
        x = np.concatenate([fixed, found], axis=1)
        through = np.concatenate([x, -np.ones((len(x), 1))], axis=1)
        left = np.einsum("li,lij,lj->l", through, grams, through)
        better = left < residuals
        gains[better], residuals[better] = x[better], left[better]
    return gains, residuals


def _point(
    problem: FitProblem, regressions: Sequence[_Regression], lag: int, asked: Sequence[str], gains: FloatArray
) -> FloatArray:
    """The vector of unknowns (k,) at one lag of the regression; given starts replace what it found."""
    model = problem.model
    delay = lag * regressions[0].step if "delay" in model.unknown else model.known["delay"]
    values = _RESTING | dict(zip(asked, gains.tolist(), strict=True)) | {"delay": delay}
    x = np.zeros(len(problem.names))
    for regression in regressions:
        part = regression.part
        columns = _columns(regression, np.array([lag]), asked, dict(model.known))[0]
        mine = regression.basis.T @ (columns[:, -1] - columns[:, :-1] @ gains)
        own = np.linalg.solve(regression.triangle, mine)
        here = values | _local_values(part, float(own[0]) if regression.push else 0.0)
        x[part.places] = [here.get(NAMES[i], 0.0) for i in part.active]
        if _PADDLING_GAIN in part.active:
            x[part.places[part.active == _PADDLING_GAIN]] = _paddling_gain(part, x)
    given = np.array([np.nan if setting.start is None else setting.start for setting in problem.settings])
    return np.clip(np.where(np.isfinite(given), given, x), problem.low, problem.high)


def _paddling_gain(part: TrialPart, x: FloatArray) -> float:
    """What divides the predicted torque to give paddling of the size measured, with the sign of their product."""
    x = x.copy()
    x[part.places[part.active == _PADDLING_GAIN]] = 1.0
    torque, measured = part.predicted(x, False)[1][0], part.channels[1].values
    product = float(torque @ measured)
    return float(torque @ torque) / product if product else _RESTING["paddling_gain"]


def _displacement(part: TrialPart, t: FloatArray) -> FloatArray:
    """Where a unit impulse of the drive alone would have moved a free body by the times t."""
    knots, levels, slopes = part.drive.pieces
    fine = np.linspace(min(t[0], knots[0]), t[-1], 8 * len(t))
    k = np.searchsorted(knots, fine, side="right") - 1
    u = np.where(k >= 0, levels[k] + slopes[k] * (fine - knots[k]), 0.0)
    h = fine[1] - fine[0]
    return np.interp(t, fine, _integral(_integral(u, h), h))


def _integral(values: FloatArray, h: float) -> FloatArray:
    """Trapezoidal integral from the first sample to each."""
    out = np.zeros_like(values)
    np.cumsum((values[1:] + values[:-1]) * (h / 2), out=out[1:])
    return out


def _averaged(times: FloatArray, values: FloatArray, t: FloatArray) -> FloatArray:
    """Measured values at a coarser even grid: means over its cells, interpolated where a gap leaves a cell empty."""
    cell = np.clip(np.rint((times - t[0]) / (t[1] - t[0])).astype(np.int64), 0, len(t) - 1)
    count = np.bincount(cell, minlength=len(t))
    there = count > 0
    mean = np.bincount(cell, weights=values, minlength=len(t))[there] / count[there]
    centre = np.bincount(cell, weights=times, minlength=len(t))[there] / count[there]
    return np.interp(t, centre, mean)


def _local_values(part: TrialPart, impulse: float) -> dict[str, float]:
    """Heading from the samples before the perturbation, or from the first ones; the rest zero."""
    channel = part.channels[0]
    before = channel.times < part.drive.majors[0] if len(part.drive.majors) else channel.times < -np.inf
    calm = channel.values[before] if before.sum() > 3 else channel.values[:4]
    return {"heading": float(np.mean(calm)), "impulse": impulse}

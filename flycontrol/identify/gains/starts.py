"""Starting values that need no user: for each delay of a grid one linear regression over all trials."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.identify.gains.problem import FitProblem, TrialPart
from flycontrol.identify.gains.regression import Regression, columns_of, products_of, regressions_of
from flycontrol.identify.gains.response import NAMES

FloatArray = NDArray[np.float64]
_DAMPINGS = (30.0, 80.0, 160.0)  #: [1/s], where noise in the regression would bias it
_RESTING = {"paddling_gain": 1e5, "limit": 1e4}
_PADDLING_GAIN = NAMES.index("paddling_gain")
_SHARED = ("damping", "kp", "kd", "ki")


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """One starting point and the residual that the regression leaves there."""

    x: FloatArray  #: (k,)
    residual: float  #: sum of squares [rad^2]
    lowest: bool  #: a local minimum over the delay


def starting_points(problem: FitProblem) -> Iterator[Start]:
    """One starting point for each delay tried: first the local minima of the regression's residual, best first."""
    regressions = regressions_of(problem)
    lags = _lags(problem, regressions[0].step)
    asked = [name for name in _SHARED if name in problem.model.unknown]
    grams = sum(products_of(regression, lags, asked, dict(problem.model.known)) for regression in regressions)
    gains, residuals = _best_gains(np.asarray(grams), asked, problem)
    around = np.concatenate([[np.inf], residuals, [np.inf]])
    lowest = (around[:-2] >= residuals) & (residuals <= around[2:])
    order = np.lexsort((residuals, ~lowest))
    for i in order:
        yield Start(_point(problem, regressions, int(lags[i]), asked, gains[i]), float(residuals[i]), bool(lowest[i]))


def _lags(problem: FitProblem, step: float) -> NDArray[np.int64]:
    """Delays to try, in samples of the coarse grid: those between the bounds, or the known one."""
    model = problem.model
    longest = max(part.channels[0].times[-1] - part.channels[0].times[0] for part in problem.parts)
    if "delay" not in model.unknown:
        return np.array([max(1, round(model.known["delay"] / step))])
    setting = model.unknown["delay"]
    if setting.start is not None:
        return np.array([max(1, round(setting.start / step))])
    low, high = max(setting.low, 2 * step), min(setting.high, longest / 3)
    return np.unique(np.rint(np.geomspace(low, max(high, low), 14) / step).astype(np.int64))


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
    problem: FitProblem, regressions: Sequence[Regression], lag: int, asked: Sequence[str], gains: FloatArray
) -> FloatArray:
    """The vector of unknowns (k,) at one lag of the regression; given starts replace what it found."""
    model = problem.model
    delay = lag * regressions[0].step if "delay" in model.unknown else model.known["delay"]
    values = _RESTING | dict(zip(asked, gains.tolist(), strict=True)) | {"delay": delay}
    x = np.zeros(len(problem.names))
    for regression in regressions:
        part = regression.part
        columns = columns_of(regression, np.array([lag]), asked, dict(model.known))[0]
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


def _local_values(part: TrialPart, impulse: float) -> dict[str, float]:
    """Heading from the samples before the perturbation, or from the first ones; the rest zero."""
    channel = part.channels[0]
    before = channel.times < part.drive.majors[0] if len(part.drive.majors) else channel.times < -np.inf
    calm = channel.values[before] if before.sum() > 3 else channel.values[:4]
    return {"heading": float(np.mean(calm)), "impulse": impulse}

"""Starting values that need no user: for each delay of a grid one linear regression over all trials."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.identify.gains.kernels import regression as kernels
from flycontrol.identify.gains.problem import FitProblem, TrialPart
from flycontrol.identify.gains.regression import GAINS, Regression, columns_of, products_of, regressions_of
from flycontrol.identify.gains.response import NAMES

FloatArray = NDArray[np.float64]
_DAMPINGS = (30.0, 80.0, 160.0)  #: [1/s], where noise in the regression would bias it
_RESTING = {"paddling_gain": 1e5, "limit": 1e4}
_PADDLING_GAIN = NAMES.index("paddling_gain")


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
    asked = [name for name in GAINS if name in problem.model.unknown]
    grams = sum(products_of(regression, lags, asked, problem.model.known) for regression in regressions)
    gains, residuals = kernels.best_gains(np.asarray(grams), _dampings(problem))
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


def _dampings(problem: FitProblem) -> FloatArray:
    """Values that damping is held at, where it is unknown: noise in the regression would bias it."""
    setting = problem.model.unknown.get("damping")
    if setting is None:
        return np.zeros(0)
    return np.clip(_DAMPINGS if setting.start is None else (setting.start,), setting.low, setting.high)


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
        columns = columns_of(regression, lag, asked, model.known)
        mine = regression.basis @ (columns[-1] - gains @ columns[:-1])
        own = np.linalg.solve(regression.triangle, mine)
        here = values | _local_values(part, float(own[0]) if regression.push else 0.0)
        x[part.places] = [here.get(NAMES[i], 0.0) for i in part.active]
    for place in problem.divisors:
        x[place] = _paddling_gain(problem, x, place)
    given = np.array([np.nan if setting.start is None else setting.start for setting in problem.settings])
    return np.clip(np.where(np.isfinite(given), given, x), problem.low, problem.high)


def _paddling_gain(problem: FitProblem, x: FloatArray, place: int) -> float:
    """What divides the torque predicted for all trials that share it to give paddling as measured, by least squares.

    Paddling is linear in the reciprocal; one trial alone may be mostly noise, and its sign with it.
    """
    x = x.copy()
    x[place] = 1.0
    parts = [part for part in problem.parts if place in part.places[part.active == _PADDLING_GAIN]]
    pairs = [(part.predicted(x, False)[1][0], part.channels[1].values) for part in parts]
    product = float(sum(torque @ measured for torque, measured in pairs))
    return float(sum(torque @ torque for torque, _ in pairs)) / product if product else _RESTING["paddling_gain"]


def _local_values(part: TrialPart, impulse: float) -> dict[str, float]:
    """Heading from the samples before the perturbation, or from the first ones; the rest zero."""
    channel = part.channels[0]
    before = channel.times < part.drive.majors[0] if len(part.drive.majors) else channel.times < -np.inf
    calm = channel.values[before] if before.sum() > 3 else channel.values[:4]
    return {"heading": float(np.mean(calm)), "impulse": impulse}

"""Profile likelihood of one unknown, and the interval that it gives.

    D(v) = min over all x with x_i = v of |V^(-1/2) (model(x) - measured)|^2, less its minimum over all x;
    the interval is {v : D(v) <= t^2}, t Student's quantile with Satterthwaite's degrees of freedom.

Along the ridge, with H = J^T J, the other unknowns o move by dx_o / dv = -H_oo^-1 H_oi, and D' = 2 g_i. sqrt(D) is
nearly straight in v, so Newton's method on it finds the ends in a few points (Venzon and Moolgavkar 1988 solve the same
equations at once), each reached by a short search from the ridge's tangent. An interval from the covariance is the
special case of a straight ridge and a parabola.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.special
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.least_squares import Minimum, NormalEquations, WeightedProblem, minimise
from flycontrol.identify.gains.response import UNITS
from flycontrol.identify.gains.uncertainty import LocalUncertainty

FloatArray = NDArray[np.float64]
_CLOSE = 1e-4  #: Newton decrement of a point, where the threshold is about 4
_MOST_STEPS = 40  #: of one search
_ACCURATE = 1e-3  #: of sqrt(D) at the ends, relative
_MOST_POINTS = 40  #: of one side
_MOST_MISSES = 6  #: searches of one side that may not converge
_GROWTH = 2.0  #: largest ratio of a distance from the minimum to the one before
_FARTHEST = 1e3  #: standard errors, after which a side counts as open
_SINGULAR = 1e-11  #: of H_ii; below it the data say nothing near the minimum
_FLAT = 0.5  #: slope of sqrt(D) at a crossing, in units of that at the minimum, below which D may come back
_HIGH = 1.5  #: in units of t, the sqrt(D) that ends the look beyond
_LOWER = -1e-3  #: D below which the search's minimum was not the lowest


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Profile:
    """The deviance along the ridge of one unknown."""

    name: str
    unit: str
    values: FloatArray  #: (p,) increasing, the minimum among them
    deviance: FloatArray  #: (p,) D, 0 at the minimum
    ridge: FloatArray  #: (p, k) all unknowns at the points
    threshold: float  #: t^2
    low: float  #: ends of the interval; infinite on an open side
    high: float
    open_because: str  #: why a side is open; empty where none is
    lower: FloatArray | None  #: (k,) a point of lower deviance than the minimum, if the ridge led to one


def profile(
    weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty, name: str, level: float = 0.95
) -> Profile:
    """Follow the ridge of one unknown to both ends of its interval, the noise held at its estimate.

    Parameters
    ----------
    name
        Of the unknown: "delay", "impulse[trial 3]".
    level
        Of the interval.

    Raises
    ------
    InvalidParameterError
        If no unknown has that name, or the level is not between 0 and 1.
    """
    return profiles(weighted, minimum, uncertainty, [name], level)[name]


def profiles(
    weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty, names: Sequence[str], level: float
) -> dict[str, Profile]:
    """Profiles of several unknowns; where one leads to values that another has not reached, that one goes on there.

    Parameters and exceptions as of `profile`.
    """
    if not 0 < level < 1:
        raise InvalidParameterError(f"The level of intervals must lie between 0 and 1, got {level!r}.")
    walks: dict[str, tuple[_Walk, _Walk]] = {}
    for name in names:
        i = _place(weighted, name)
        t = float(scipy.special.stdtrit(uncertainty.freedom[i], 0.5 + level / 2))
        walks[name] = (_Walk(weighted, minimum, i, t, -1).run(), _Walk(weighted, minimum, i, t, 1).run())
    met = [point for pair in walks.values() for walk in pair for point in walk.points]
    for pair in walks.values():
        for walk in pair:
            walk.join(met)
    return {name: _profile(name, *pair) for name, pair in walks.items()}


def _place(weighted: WeightedProblem, name: str) -> int:
    names = weighted.problem.names
    if name not in names:
        raise InvalidParameterError(f"No unknown is named {name!r}; there are {', '.join(names)}.")
    return names.index(name)


def _profile(name: str, below: _Walk, above: _Walk) -> Profile:
    points = [*reversed(below.points), (below.origin, 0.0), *above.points]
    ridge, i = np.array([x for x, _ in points]), above.i
    reasons = [walk.open_because for walk in (below, above) if walk.open_because]
    lower = next((walk.lower for walk in (below, above) if walk.lower is not None), None)
    return Profile(
        name=name, unit=UNITS[above.weighted.problem.kinds[i]], values=ridge[:, i],
        deviance=np.array([D for _, D in points]), ridge=ridge, threshold=above.t**2, low=below.end, high=above.end,
        open_because="; ".join(reasons), lower=lower,
    )  # fmt: skip


def ridge_direction(at: NormalEquations, i: int, free: NDArray[np.bool_]) -> tuple[FloatArray, float]:
    """dx / dv (k,) along the ridge of unknown i, and the curvature S = H_ii - H_io H_oo^-1 H_oi, half of D''."""
    others = free.copy()
    others[i] = False
    H, direction = at.matrix, np.zeros(len(free))
    direction[i] = 1.0
    if others.any():
        size = np.sqrt(np.maximum(np.diag(H), 1e-300))
        scaled = H / size / size[:, None]
        found = np.linalg.lstsq(scaled[others][:, others], scaled[others, i], rcond=1e-12)[0]
        direction[others] = -found * size[i] / size[others]
    return direction, float(max(H[i] @ direction, 0.0))


class _Walk:
    """One side of a profile, from the minimum outwards."""

    def __init__(self, weighted: WeightedProblem, minimum: Minimum, i: int, t: float, sign: int) -> None:
        self.weighted, self.i, self.t, self.sign = weighted, i, t, sign
        self.x, self.at, self.lowest, self.origin = minimum.x, minimum.at, minimum.at.cost, minimum.x
        self.start = float(minimum.x[i])
        self.room = abs(float((weighted.problem.high if sign > 0 else weighted.problem.low)[i]) - self.start)
        self.direction, curvature = ridge_direction(self.at, i, self._free())
        seen = curvature > _SINGULAR * self.at.matrix[i, i]
        self.unit = 1.0 / np.sqrt(curvature) if seen else 0.3 * max(abs(self.start), 1e-3)
        self.misses = 0
        self.inside = 0.0  #: distance of the last point kept from the minimum
        self.points: list[tuple[FloatArray, float]] = []  # outwards
        self.end, self.flat, self.open_because = sign * np.inf, False, ""
        self.lower: FloatArray | None = None

    def run(self) -> _Walk:
        """Walk to the last crossing of the threshold, the bound, a lower minimum, or too far."""
        self._cross(self.t * self.unit, np.inf)
        while np.isfinite(self.end) and self.flat:
            inside = self._returns()
            if inside is None:
                break
            self.end = self.sign * np.inf
            self._cross(*inside)
        return self

    def join(self, met: Sequence[tuple[FloatArray, float]]) -> None:
        """Go on from the outermost point below the threshold that another walk met beyond the end of this one."""
        beyond = [(self.sign * (x[self.i] - self.end), x) for x, D in met if self.t**2 > D]
        farthest, x = max(beyond, key=lambda it: it[0], default=(0.0, self.x))
        if not (np.isfinite(self.end) and farthest > _ACCURATE * abs(self.end - self.start)):
            return
        distance = abs(x[self.i] - self.start)
        self.x, self.direction = x, np.zeros(len(x))
        found = self._reach(distance)
        if found is not None:
            self._advance(found, distance)
            self.end = self.sign * np.inf
            self._cross(1.3 * distance, np.inf)

    def _cross(self, step: float, outside: float) -> None:
        """Find where D crosses the threshold between the last point inside and `outside`, first tried at `step`."""
        for _ in range(_MOST_POINTS):
            distance = min(step, self.room)
            if distance <= self.inside * (1 + 1e-6) or self.misses > _MOST_MISSES:  # at the bound, or no progress left
                break
            found = self._reach(distance)
            if found is None:  # the search does not follow so large a step
                step = 0.5 * (self.inside + distance)
                continue
            z, slope = self._height(found)
            if self.lower is not None:
                break
            if abs(z - self.t) < _ACCURATE * self.t:
                self._advance(found, distance)
                self.end, self.flat = self.start + self.sign * distance, slope * self.unit < _FLAT
                return
            if z > self.t:
                outside = distance
            else:
                self._advance(found, distance)
                if distance >= min(self.room, _FARTHEST * self.t * self.unit):
                    break
            newton = distance + (self.t - z) / slope if slope > 0 else np.inf
            step = _next(newton, self.inside, outside, self.unit)
        self._open()

    def _returns(self) -> tuple[float, float] | None:
        """Look beyond a flat crossing: a distance at which D is below the threshold again, and one where it is not."""
        distance = self.inside
        for _ in range(_MOST_POINTS):
            before, distance = distance, min(1.3 * distance, self.room)
            found = self._reach(distance)
            if found is None or distance <= before:
                return None
            z, _ = self._height(found)
            if z > _HIGH * self.t:
                return None
            self._advance(found, distance)
            if z < self.t:
                return _GROWTH * distance, np.inf
        return None

    def _free(self) -> NDArray[np.bool_]:
        low, high = self.weighted.problem.low, self.weighted.problem.high
        return ~(((self.x <= low) & (self.at.gradient > 0)) | ((self.x >= high) & (self.at.gradient < 0)))

    def _reach(self, distance: float) -> Minimum | None:
        v = self.start + self.sign * distance
        x = self.x + self.direction * (v - self.x[self.i])
        x[self.i] = v
        found = minimise(self.weighted, x, most_steps=_MOST_STEPS, scale=1.0, close=_CLOSE, fixed=(self.i,))
        self.misses += not found.converged
        return found if found.converged else None

    def _height(self, found: Minimum) -> tuple[float, float]:
        """sqrt(D) and its slope outwards."""
        D = found.at.cost - self.lowest
        if _LOWER > D:
            self.lower = found.x
        z = np.sqrt(max(D, 1e-12))
        return z, float(self.sign * found.at.gradient[self.i] / z)  # D' is twice the gradient's entry

    def _advance(self, found: Minimum, distance: float) -> None:
        self.x, self.at, self.inside = found.x, found.at, distance
        self.direction, _ = ridge_direction(found.at, self.i, ~found.held)
        self.points.append((found.x, max(found.at.cost - self.lowest, 0.0)))

    def _open(self) -> None:
        kind = self.weighted.problem.kinds[self.i]
        where, way = self.start + self.sign * self.inside, "up" if self.sign > 0 else "down"
        limit = "the bound of " if self.inside >= self.room else ""
        self.open_because = f"the likelihood stays above the threshold {way} to {limit}{where:.4g} {UNITS[kind]}"


def _next(newton: float, inside: float, outside: float, unit: float) -> float:
    """The next distance: Newton's, kept inside the bracket and from leaping."""
    if np.isfinite(outside):
        width = outside - inside
        return float(np.clip(newton, inside + 0.05 * width, outside - 0.05 * width))
    return float(min(newton, _GROWTH * max(inside, unit)))

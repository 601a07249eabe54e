"""The valley that data cannot see the end of: least deviance over two unknowns that make up for each other.

    D(u, v) = min over all x with x_i = u, x_j = v of |V^(-1/2) (model(x) - measured)|^2, less its minimum over all x

A pair (u, v) goes with the data at a level p where D is below Student's quantile squared, as along a profile. The two
are those that weigh most in the direction that the data tell least about, all that belongs to single recordings fitted.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import cast

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.labour import HERE, Labour
from flycontrol.identify.gains.least_squares import Minimum, WeightedProblem, minimise
from flycontrol.identify.gains.profile import Profile
from flycontrol.identify.gains.response import UNITS
from flycontrol.jobs.packed import Result
from flycontrol.jobs.work import Work

FloatArray = NDArray[np.float64]
SIDE = 25  #: points of each axis
_CLOSE = 1e-3  #: Newton decrement of a point, where the threshold is about 4
_MOST_STEPS = 20  #: of one search
_ROOM = 0.35  #: around what the profiles reached, as a share of it
#: As far as a profile is drawn beyond the estimate where nothing ends it: sizes that a fly's loop may have.
_USUAL = {"kp": 4000.0, "kd": 60.0, "ki": 1e5, "delay": 30e-3, "damping": 150.0, "limit": 1e4, "paddling_gain": 1e5}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ridge:
    """Deviance over two unknowns, all others fitted again at each point."""

    names: tuple[str, str]
    units: tuple[str, str]
    first: FloatArray  #: (m,) values of the first unknown
    second: FloatArray  #: (n,) of the second
    deviance: FloatArray  #: (m, n) D; NaN where the model's yaw overflows
    threshold: float  #: D below which the data go along with a pair
    estimate: tuple[float, float]  #: of the lowest D

    @property
    def inside(self) -> NDArray[np.bool_]:
        """(m, n) pairs that the data go along with."""
        return self.deviance <= self.threshold

    @property
    def valley(self) -> FloatArray:
        """(r, 2) the best second value for each first value that the data go along with."""
        filled = np.where(np.isfinite(self.deviance), self.deviance, np.inf)
        rows = np.flatnonzero(filled.min(axis=1) <= self.threshold)
        return np.column_stack([self.first[rows], self.second[np.argmin(filled[rows], axis=1)]])

    @property
    def open_ends(self) -> tuple[str, ...]:
        """Sides of the grid at which the data still go along: "kp down", "delay up"."""
        inside, (one, other) = self.inside, self.names
        sides = {
            f"{one} down": inside[0], f"{one} up": inside[-1],
            f"{other} down": inside[:, 0], f"{other} up": inside[:, -1],
        }  # fmt: skip
        return tuple(side for side, edge in sides.items() if edge.any())


def ridge(
    weighted: WeightedProblem, minimum: Minimum, seen: tuple[Profile, Profile], side: int = SIDE, labour: Labour = HERE
) -> Ridge:
    """Look at the deviance over two unknowns, in a window that holds what their profiles reached.

    Parameters
    ----------
    weighted, minimum
        The problem with its noise, and its minimum.
    seen
        Profiles of the two unknowns.
    side
        Points along each axis, at least three.

    Raises
    ------
    InvalidParameterError
        If the profiles are of one unknown, or the points too few.
    """
    one, other = seen
    if one.name == other.name or side < 3:
        raise InvalidParameterError(
            f"A ridge needs two different unknowns and at least 3 points a side, got {one.name!r}, {other.name!r} and "
            f"{side!r}."
        )
    axes = tuple(window(profile, weighted, side) for profile in seen)
    names = weighted.problem.names
    task = partial(
        _row, weighted=weighted, minimum=minimum, columns=axes[1], pair=(names.index(one.name), names.index(other.name))
    )
    rows = labour.done(Work(task=task, items=axes[0].tolist(), seed=0, chunk=4, name="ridge"))
    cost = np.stack([cast("dict[str, FloatArray]", row)["cost"] for row in rows])
    lowest = min(minimum.at.cost, float(np.nanmin(cost)))
    i, j = names.index(one.name), names.index(other.name)
    return Ridge(
        names=(one.name, other.name), units=(UNITS[weighted.problem.kinds[i]], UNITS[weighted.problem.kinds[j]]),
        first=axes[0], second=axes[1], deviance=cost - lowest, threshold=max(one.threshold, other.threshold),
        estimate=(float(minimum.x[i]), float(minimum.x[j])),
    )  # fmt: skip


def blind_pair(weighted: WeightedProblem, minimum: Minimum) -> tuple[str, str] | None:
    """The two shared unknowns that weigh most where the data say least; None where fewer than two are shared.

    The last eigenvector of their information matrix, each in units of its usual size, others eliminated.
    """
    problem = weighted.problem
    shared = [i for i, (name, kind) in enumerate(zip(problem.names, problem.kinds, strict=True)) if name == kind]
    if len(shared) < 2:
        return None
    others = [i for i in range(len(problem.names)) if i not in shared]
    unit = np.array([_USUAL.get(problem.kinds[i], 1.0) for i in shared])
    H = minimum.at.matrix
    between = H[others][:, shared]
    S = H[shared][:, shared] - between.T @ np.linalg.pinv(H[others][:, others], hermitian=True) @ between
    least = np.linalg.eigh(S * unit * unit[:, None])[1][:, 0]
    two = sorted(np.argsort(-np.abs(least), kind="stable")[:2])
    return problem.names[shared[two[0]]], problem.names[shared[two[1]]]


def window(profile: Profile, weighted: WeightedProblem, points: int) -> FloatArray:
    """Values (points,) around what a profile reached, the minimum among them, inside the unknown's bounds."""
    i = weighted.problem.names.index(profile.name)
    best = float(profile.values[np.argmin(profile.deviance)])
    usual = max(_USUAL.get(weighted.problem.kinds[i], abs(best)), 2.0 * abs(best))
    low = max(float(profile.values[0]), best - usual)
    high = min(float(profile.values[-1]), best + usual)
    room = _ROOM * (high - low) or usual
    low = max(low - room, float(weighted.problem.low[i]))
    high = min(high + room, float(weighted.problem.high[i]))
    grid = np.linspace(low, high, points)
    grid[np.argmin(np.abs(grid - best))] = best
    return grid


def _row(
    value: float,
    rng: np.random.Generator,
    *,
    weighted: WeightedProblem,
    minimum: Minimum,
    columns: FloatArray,
    pair: tuple[int, int],
) -> Result:
    """Costs (n,) for one value of the first unknown: from the minimum's column outwards, each from its neighbour."""
    del rng
    cost = np.full(len(columns), np.nan)
    middle = int(np.argmin(np.abs(columns - minimum.x[pair[1]])))
    start = _at(weighted, minimum.x, pair, value, float(columns[middle]))
    for way in (range(middle, len(columns)), range(middle - 1, -1, -1)):
        x = start.x
        for k in way:
            found = _at(weighted, x, pair, value, float(columns[k]))
            if found.at.finite:  # a search that ran out of steps still bounds the least cost from above
                cost[k], x = found.at.cost, found.x
    return {"cost": cost}


def _at(weighted: WeightedProblem, x: FloatArray, pair: tuple[int, int], u: float, v: float) -> Minimum:
    x = x.copy()
    x[list(pair)] = u, v
    return minimise(weighted, x, most_steps=_MOST_STEPS, scale=1.0, close=_CLOSE, fixed=pair)

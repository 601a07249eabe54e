"""A torque limit that the fly never reached: the data say only what it is at least.

    D(L) = least over all x with the limit at L of |V^(-1/2) (model(x) - measured)|^2, less the same without a limit,

falls as 1 / L^4 towards large limits; the least limit that the data go along with is where D crosses the threshold.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.identify.gains.least_squares import Minimum, WeightedProblem, minimise

FloatArray = NDArray[np.float64]
_SAME = 1e-3  #: of D, where the threshold is about 4: without a limit the data are explained as well
_ACCURATE = 1e-2  #: of the least limit, relative
_LOWEST = 1.0  #: [1/s^2], no torque at all
_CLOSE = 1e-4  #: Newton decrement of a point


def unreached(weighted: WeightedProblem, x: FloatArray) -> NDArray[np.bool_]:
    """Unknowns (k,) that are torque limits without any effect at x (k,)."""
    found = np.zeros(len(x), dtype=np.bool_)
    limits = [i for i, kind in enumerate(weighted.problem.kinds) if kind == "limit"]
    cost = weighted.cost(x) if limits else 0.0
    for i in limits:
        without = x.copy()
        without[i] = np.inf
        found[i] = weighted.cost(without) - cost < _SAME
    return found


def without_unreached(weighted: WeightedProblem, minimum: Minimum) -> Minimum:
    """The same minimum, limits that are never reached held where they are: nothing determines them."""
    return replace(minimum, held=minimum.held | unreached(weighted, minimum.x))


def least_limit(weighted: WeightedProblem, minimum: Minimum, i: int, t: float) -> float:
    """The least limit, unknown i, with D below t^2: what the data exclude lies below it [1/s^2]."""
    high = float(minimum.x[i])
    x, low = minimum.x, _LOWEST
    while high > (1 + _ACCURATE) * low:
        middle = float(np.sqrt(low * high))
        found = _at(weighted, x, i, middle)
        if found.converged and found.at.cost - minimum.at.cost < t**2:
            high, x = middle, found.x
        else:
            low = middle
    return high


def _at(weighted: WeightedProblem, x: FloatArray, i: int, limit: float) -> Minimum:
    start = x.copy()
    start[i] = limit
    return minimise(weighted, start, scale=1.0, close=_CLOSE, fixed=(i,))

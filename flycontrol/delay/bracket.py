"""A root between two points of opposite sign."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq


def bracketed_root(
    function: Callable[[float], float], low: float, high: float, tolerance: float | None = None
) -> float:
    """Root of a continuous function by Brent's method, to rounding unless a tolerance is given.

    Raises
    ------
    ValueError
        If the function has the same sign at both ends.
    """
    xtol = 1e-14 * max(abs(low), abs(high)) if tolerance is None else tolerance
    root, _ = brentq(function, low, high, xtol=xtol, rtol=4 * np.finfo(np.float64).eps, full_output=True)
    return float(root)

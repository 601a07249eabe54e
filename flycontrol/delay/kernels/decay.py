"""Rightmost roots of neighbouring systems, one from the other. The mathematics stands in `flycontrol.delay.chart`."""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.delay.kernels.newton import polish
from flycontrol.delay.kernels.winding import count_right_of, scale


@numba.njit(cache=True)
def abscissa_near(A, B2, C2, D22, tau, roots, most):
    """Real part of the rightmost root, Newton from a neighbour's roots (in place, imag >= 0); NaN if a count objects.

    The count right of a line between the rightmost root and the next one must be that of the rightmost one alone.
    """
    blocks = (A.copy(), B2.copy(), C2.copy(), D22.copy(), tau)
    scale(blocks[0], blocks[1], blocks[2], blocks[3])
    paired = roots.imag > 0.0
    steps = polish(blocks, roots, paired, 12)
    first = -1
    for k in range(len(roots)):
        if paired[k]:
            roots[k] = complex(roots[k].real, abs(roots[k].imag))
        settled = steps[k] <= 1e-9 * abs(roots[k])
        if settled and (first < 0 or roots[k].real > roots[first].real):
            first = k
    if first < 0:
        return np.nan
    size, gap = abs(roots[first]), np.inf
    for k in range(len(roots)):
        if k != first:
            gap = min(gap, roots[first].real - roots[k].real)
    if not gap > 1e-4 * size:
        return np.nan
    line = roots[first].real - min(0.5 * gap, 0.05 * size)
    counted, _ = count_right_of(blocks[0], blocks[1], blocks[2], blocks[3], tau, line, most)
    return roots[first].real if counted == (2 if paired[first] else 1) else np.nan


@numba.njit(cache=True)
def abscissae(A, B2, C2, D22, tau, roots, found, start, most):
    """Fill found (k,) from `start` on, each from the one before; returns the first place that this could not fill."""
    for k in range(start, len(found)):
        found[k] = abscissa_near(A[k], B2[k], C2[k], D22[k], tau[k], roots, most)
        if np.isnan(found[k]):
            return k
    return len(found)

"""Newton from predicted roots, and how fast roots move. The mathematics stands in `flycontrol.delay.continuation`."""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.delay.kernels.newton import log_derivative
from flycontrol.delay.kernels.winding import characteristic, invert

MOST_STEPS = 30


@numba.njit(cache=True)
def correct(A, B2, C2, D22, tau, starts, typical):
    """Newton on det M(s) = 0 from each start, a real one staying real; roots, and how badly Newton contracted.

    The contraction is the largest ratio of one step to the one before, as long as steps are above rounding: about
    e / d for a start at distance e from its root and d from the next one, whichever root that is. inf: no convergence.
    `typical` is how large roots are hereabouts [1/s].
    """
    roots = starts.copy()
    contraction = np.full(len(starts), np.inf)
    for k in range(len(starts)):
        s = starts[k]
        on_axis = s.imag == 0.0
        before, worst = np.inf, 0.0
        for _ in range(MOST_STEPS):
            slope = log_derivative(A, B2, C2, D22, tau, s)
            step = 1.0 / slope if slope != 0.0 else complex(np.inf)
            if on_axis:
                step = complex(step.real)
            size = abs(step)
            scale = max(abs(s), 1e-6 * typical)
            if not size < 1e3 * scale:
                break
            s -= step
            if before < np.inf and before > 1e-10 * scale:
                worst = max(worst, size / before)
            if size <= 1e-15 * scale or (size <= 1e-10 * scale and size >= 0.5 * before):
                roots[k] = s
                contraction[k] = worst
                break
            if worst > 0.7:
                break
            before = size
    return roots, contraction


@numba.njit(cache=True)
def speeds(A, B2, C2, D22, tau, before, after, width, roots):
    """ds/dp = -tr(M^-1 M_p) / tr(M^-1 M_s) at each root, M_p from blocks at two places `width` apart."""
    n, q = A.shape[0], len(tau)
    size = n + q
    M, inverse = np.empty((size, size), np.complex128), np.empty((size, size), np.complex128)
    left, right = np.empty((size, size), np.complex128), np.empty((size, size), np.complex128)
    found = np.empty(len(roots), np.complex128)
    for k in range(len(roots)):
        s = roots[k]
        characteristic(M, A, B2, C2, D22, tau, s)
        if invert(M, inverse) == 0.0:  # next to the root all that M^-1 needs is its direction
            s += 1e-12 * (abs(s) + np.abs(roots).max() * 1e-6)
            characteristic(M, A, B2, C2, D22, tau, s)
            invert(M, inverse)
        characteristic(left, before[0], before[1], before[2], before[3], before[4], s)
        characteristic(right, after[0], after[1], after[2], after[3], after[4], s)
        by_p, by_s = 0.0j, 0.0j
        for i in range(size):
            for j in range(size):
                by_p += inverse[i, j] * (right[j, i] - left[j, i])
        for a in range(n):
            by_s += inverse[a, a]
        for c in range(q):
            factor = tau[c] * np.exp(-s * tau[c])
            for b in range(n):
                by_s += inverse[b, n + c] * factor * C2[c, b]
            for d in range(q):
                by_s += inverse[n + d, n + c] * factor * D22[c, d]
        found[k] = -by_p / (width * by_s) if by_s != 0.0 else complex(np.inf)
        if roots[k].imag == 0.0:
            found[k] = complex(found[k].real)
    return found

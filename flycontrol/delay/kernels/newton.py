"""Newton's method with implicit deflation on det M(s) = 0. The mathematics stands in `flycontrol.delay.spectrum`."""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.delay.kernels.winding import characteristic, invert


@numba.njit(cache=True, error_model="numpy")
def log_derivative(A, B2, C2, D22, tau, s):
    """f'(s) / f(s) = tr(M^-1 M') for f = det M, M = [[s I - A, -B2], [-E C2, I - E D22]]; inf where M is singular.

    M' has the rows of I above those of -tau_i (M - I), so that with N = M^-1 the trace is that of the first n entries
    N_aa, and of tau_i (N_ii - 1) for the delays.
    """
    n, q = B2.shape
    M, N = np.empty((n + q, n + q), np.complex128), np.empty((n + q, n + q), np.complex128)
    characteristic(M, A, B2, C2, D22, tau, s)
    if invert(M, N) == 0.0:
        return complex(np.inf)
    trace = 0.0j
    for a in range(n):
        trace += N[a, a]
    for c in range(q):
        trace += tau[c] * (N[n + c, n + c] - 1.0)
    return trace


@numba.njit(cache=True, error_model="numpy")
def polish(blocks, roots, paired, sweeps):
    """Ehrlich-Aberth iteration on the roots with imag >= 0, in place; returns the size of each last step.

    A root marked `paired` stands for itself and its conjugate; one not marked is real and stays real.
    """
    A, B2, C2, D22, tau = blocks
    count = len(roots)
    steps = np.full(count, np.inf)
    active = np.ones(count, np.bool_)
    for _ in range(sweeps):
        moved = False
        for k in range(count):
            if not active[k]:
                continue
            s = roots[k]
            slope = log_derivative(A, B2, C2, D22, tau, s)
            near = 1e-3 * abs(s)
            for j in range(count):  # deflate neighbours only: distant roots are no part of the local polynomial
                if j != k and s != roots[j] and abs(s - roots[j]) < near:
                    slope -= 1.0 / (s - roots[j])
                if paired[j] and s != roots[j].conjugate() and abs(s - roots[j].conjugate()) < near:
                    slope -= 1.0 / (s - roots[j].conjugate())
            step = 1.0 / slope if slope != 0.0 else 0.0j
            if not np.isfinite(step.real + step.imag):
                step = 0.0j
            if not paired[k]:
                step = complex(step.real)
            roots[k] = s - step
            # a step within rounding that no longer shrinks is rounding
            still = abs(step) > 1e-12 * abs(roots[k]) or abs(step) < 0.5 * steps[k]
            steps[k] = abs(step)
            active[k] = still and steps[k] > 1e-15 * abs(roots[k])
            moved = moved or active[k]
        if not moved:
            break
    return steps

"""Newton's method with implicit deflation on det M(s) = 0. The mathematics stands in `flycontrol.delay.spectrum`."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def log_derivative(A, B2, C2, D22, tau, s):
    """f'(s) / f(s) = tr(M^-1 M') for f = det M, M = [[s I - A, -B2], [-E C2, I - E D22]]; inf where M is singular."""
    n, q = A.shape[0], len(tau)
    size = n + q
    M = np.zeros((size, size), np.complex128)
    R = np.zeros((size, size), np.complex128)
    for a in range(n):
        for b in range(n):
            M[a, b] = -A[a, b]
        M[a, a] += s
        R[a, a] = 1.0
        for c in range(q):
            M[a, n + c] = -B2[a, c]
    for c in range(q):
        factor = np.exp(-s * tau[c])
        for b in range(n):
            M[n + c, b] = -factor * C2[c, b]
            R[n + c, b] = tau[c] * factor * C2[c, b]
        for d in range(q):
            M[n + c, n + d] = -factor * D22[c, d]
            R[n + c, n + d] = tau[c] * factor * D22[c, d]
        M[n + c, n + c] += 1.0
    for k in range(size):  # Gauss-Jordan with row pivoting turns R into M^-1 M'
        pivot = k
        for i in range(k + 1, size):
            if abs(M[i, k]) > abs(M[pivot, k]):
                pivot = i
        if M[pivot, k] == 0.0:
            return complex(np.inf)
        if pivot != k:
            for j in range(size):
                M[k, j], M[pivot, j] = M[pivot, j], M[k, j]
                R[k, j], R[pivot, j] = R[pivot, j], R[k, j]
        for i in range(size):
            if i != k and M[i, k] != 0.0:
                ratio = M[i, k] / M[k, k]
                for j in range(k, size):
                    M[i, j] -= ratio * M[k, j]
                for j in range(size):
                    R[i, j] -= ratio * R[k, j]
    trace = 0.0j
    for k in range(size):
        trace += R[k, k] / M[k, k]
    return trace


@numba.njit(cache=True)
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
            steps[k] = abs(step)
            active[k] = steps[k] > 1e-15 * abs(roots[k])
            moved = moved or active[k]
        if not moved:
            break
    return steps

"""Phase of det M along a vertical line, by steps that cannot miss a turn. See `flycontrol.delay.count`."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def _characteristic(M, A, B2, C2, D22, tau, s):
    n, q = A.shape[0], len(tau)
    for a in range(n):
        for b in range(n):
            M[a, b] = -A[a, b]
        M[a, a] += s
        for c in range(q):
            M[a, n + c] = -B2[a, c]
    for c in range(q):
        factor = np.exp(-s * tau[c])
        for b in range(n):
            M[n + c, b] = -factor * C2[c, b]
        for d in range(q):
            M[n + c, n + d] = -factor * D22[c, d]
        M[n + c, n + c] += 1.0


@numba.njit(cache=True)
def _invert(M, inverse):
    """Gauss-Jordan with row pivoting; returns the direction of det M, of modulus 1, or 0 if M is singular."""
    size = M.shape[0]
    direction = 1.0 + 0.0j
    for i in range(size):
        for j in range(size):
            inverse[i, j] = 1.0 if i == j else 0.0
    for k in range(size):
        pivot = k
        for i in range(k + 1, size):
            if abs(M[i, k]) > abs(M[pivot, k]):
                pivot = i
        if M[pivot, k] == 0.0:
            return 0.0j
        if pivot != k:
            direction = -direction
            for j in range(size):
                M[k, j], M[pivot, j] = M[pivot, j], M[k, j]
                inverse[k, j], inverse[pivot, j] = inverse[pivot, j], inverse[k, j]
        direction *= M[k, k] / abs(M[k, k])
        scale = 1.0 / M[k, k]
        for j in range(size):
            M[k, j] *= scale
            inverse[k, j] *= scale
        for i in range(size):
            ratio = M[i, k]
            if i != k and ratio != 0.0:
                for j in range(size):
                    M[i, j] -= ratio * M[k, j]
                    inverse[i, j] -= ratio * inverse[k, j]
    return direction


@numba.njit(cache=True)
def _perron_bound(inverse, slope, y):
    """Upper bound on the Perron root of |inverse| slope: max (P y)_i / y_i for any y > 0 (Collatz, Wielandt).

    A few power steps make it tight; y is kept from call to call, since neighbours on the line resemble each other.
    """
    size = len(y)
    once, product = np.empty(size), np.empty(size)
    bound = np.inf
    for _ in range(4):
        for k in range(size):
            once[k] = 0.0
            for j in range(size):
                once[k] += slope[k, j] * y[j]
        largest = 0.0
        for i in range(size):
            total = 0.0
            for k in range(size):
                total += abs(inverse[i, k]) * once[k]
            product[i] = total
            largest = max(largest, total)
        ratio = 0.0
        for i in range(size):
            ratio = max(ratio, product[i] / y[i])
        bound = min(bound, ratio)
        for i in range(size):
            y[i] = product[i] / largest + 1e-6
    return bound


@numba.njit(cache=True)
def phase_along_line(blocks, line, top, most):
    """Phase change of det M(line + j w) from w = 0 to `top`, and the steps taken; NaN if a root lies too near the line.

    From a point s the step h keeps h times the Perron root of |M(s)^-1| |M'| below rho, where |M'| bounds the slope of
    M on the whole line entry by entry. Then det M(s + j h) / det M(s) is a product of n + q numbers within rho of 1, so
    its phase is below pi when (n + q) asin(rho) is, and its principal value is the true change.
    """
    A, B2, C2, D22, tau = blocks
    n, q = A.shape[0], len(tau)
    size = n + q
    slope = np.zeros((size, size))
    for a in range(n):
        slope[a, a] = 1.0
    for c in range(q):
        growth = tau[c] * np.exp(-line * tau[c])
        for b in range(n):
            slope[n + c, b] = growth * abs(C2[c, b])
        for d in range(q):
            slope[n + c, n + d] = growth * abs(D22[c, d])
    rho = 0.9 * np.sin(min(np.pi / size, 0.5 * np.pi))
    M, inverse = np.empty((size, size), np.complex128), np.empty((size, size), np.complex128)
    y = np.ones(size)
    w, total, steps = 0.0, 0.0, 0
    _characteristic(M, A, B2, C2, D22, tau, complex(line, 0.0))
    before = _invert(M, inverse)
    while w < top:
        if before == 0.0 or steps >= most:
            return np.nan, steps
        w = min(top, w + rho / _perron_bound(inverse, slope, y))
        _characteristic(M, A, B2, C2, D22, tau, complex(line, w))
        after = _invert(M, inverse)
        total += np.angle(after * np.conj(before))
        before = after
        steps += 1
    return total, steps

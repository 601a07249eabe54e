"""Taylor panels of a transfer matrix along a segment. The mathematics stands in `flycontrol.delay.panels`.

`b` holds the blocks of a `DelayLTI` by name; g is half a panel, so that s = centre + g u with |u| <= 1.
"""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.delay.kernels.winding import characteristic, invert

_LEAST_PIVOT = 0.1  # of I - Q: far enough from 0 that rounding cannot make it positive
_ROUNDING = 1e-15  # of what an entry of G is summed from, for each state and delay: solved to rounding only


@numba.njit(cache=True)
def _expand(inverse, b, s0, g, X, Z):
    """Coefficients in u of states and delayed signals X (K + 1, n + q, m), and of what is delayed Z (K + 1, q, m)."""
    n, q = b.B2.shape
    rhs, powers = np.empty(n + q, np.complex128), np.empty((q, X.shape[0]), np.complex128)
    for c in range(q):  # Taylor coefficients of exp(-s tau)
        powers[c, 0] = np.exp(-s0 * b.tau[c])
        for j in range(1, X.shape[0]):
            powers[c, j] = powers[c, j - 1] * (-b.tau[c] / j) * g
    for k in range(X.shape[0]):
        for col in range(X.shape[2]):
            for a in range(n):
                rhs[a] = b.B1[a, col] if k == 0 else -g * X[k - 1, a, col]
            for c in range(q):  # w = exp(-s tau) z, but for the unknown part of the same order
                total = b.D21[c, col] * powers[c, 0] if k == 0 else 0.0j
                for j in range(1, k + 1):
                    total += powers[c, j] * Z[k - j, c, col]
                rhs[n + c] = total
            for i in range(n + q):
                value = 0.0j
                for j in range(n + q):
                    value += inverse[i, j] * rhs[j]
                X[k, i, col] = value
            for c in range(q):
                value = b.D21[c, col] + 0.0j if k == 0 else 0.0j
                for a in range(n):
                    value += b.C2[c, a] * X[k, a, col]
                for d in range(q):
                    value += b.D22[c, d] * X[k, n + d, col]
                Z[k, c, col] = value


@numba.njit(cache=True)
def _read(b, X, series):
    """Coefficients (K + 1, p, m) of G = D11 + [C1 D12] X; largest sums of sizes: of coefficients, of what they sum."""
    n, q = b.B2.shape
    largest, all_terms = 0.0, 0.0
    for row in range(series.shape[1]):
        for col in range(series.shape[2]):
            reach, terms = 0.0, abs(b.D11[row, col])
            for k in range(X.shape[0]):
                value = b.D11[row, col] + 0.0j if k == 0 else 0.0j
                for a in range(n):
                    term = b.C1[row, a] * X[k, a, col]
                    terms += abs(term.real) + abs(term.imag)
                    value += term
                for c in range(q):
                    term = b.D12[row, c] * X[k, n + c, col]
                    terms += abs(term.real) + abs(term.imag)
                    value += term
                series[k, row, col] = value
                reach += abs(value)
            largest, all_terms = max(largest, reach), max(all_terms, terms)
    return largest, all_terms


@numba.njit(cache=True)
def _change(sizes, b, s0, h, T):
    """Fill T = I - Q, Q = |M(s0)^-1| |M(s0 + z) - M(s0)|, Q an upper bound entry by entry for every |z| <= h."""
    n, q = b.B2.shape
    for i in range(n + q):
        for j in range(n):
            T[i, j] = -h * sizes[i, j]
        for d in range(q):
            T[i, n + d] = 0.0
        T[i, i] += 1.0
    for c in range(q):
        growth = np.exp(-s0.real * b.tau[c]) * np.expm1(h * b.tau[c])
        for i in range(n + q):
            reach = growth * sizes[i, n + c]
            for j in range(n):
                T[i, j] -= reach * abs(b.C2[c, j])
            for d in range(q):
                T[i, n + d] -= reach * abs(b.D22[c, d])


@numba.njit(cache=True)
def _factor(T):
    """T = L U in place, without pivoting; returns the smallest pivot.

    For T = I - Q with Q >= 0 the pivots are all positive if and only if the Perron root of Q is below 1, and then
    T^-1 = I + Q + Q^2 + ... >= 0, solved for without cancellation.
    """
    size, smallest = T.shape[0], np.inf
    for k in range(size):
        smallest = min(smallest, T[k, k])
        if smallest <= 0.0:
            return smallest
        for i in range(k + 1, size):
            if T[i, k] != 0.0:
                T[i, k] /= T[k, k]
                for j in range(k + 1, size):
                    T[i, j] -= T[i, k] * T[k, j]
    return smallest


@numba.njit(cache=True)
def _solve(T, v):
    """v becomes T^-1 v, T factored."""
    for i in range(len(v)):
        for j in range(i):
            v[i] -= T[i, j] * v[j]
    for i in range(len(v) - 1, -1, -1):
        for j in range(i + 1, len(v)):
            v[i] -= T[i, j] * v[j]
        v[i] /= T[i, i]


@numba.njit(cache=True)
def _residual(b, s0, h, X, Z, col, out):
    """Bound on F - M X for |u| <= 1: what the Taylor polynomials of one input leave, all of order K + 1."""
    n, order = b.A.shape[0], X.shape[0] - 1
    for a in range(n):
        out[a] = h * abs(X[order, a, col])
    for c in range(len(b.tau)):
        x = b.tau[c] * h
        tail = 1.0 / (1.0 - x / (order + 2)) if x < order + 2 else np.inf  # of exp x from its power K + 1 on
        power = 1.0
        for j in range(1, order + 2):
            tail *= x / j
        for j in range(1, order + 1):
            power *= x / j
        value = 0.0
        for i in range(order + 1):
            value += abs(Z[i, c, col]) * tail
            tail += power  # now from the power K - i on
            power *= (order - i) / x
        out[n + c] = np.exp(-s0.real * b.tau[c]) * value


@numba.njit(cache=True)
def _remainder(sizes, T, b, s0, h, X, Z):
    """Bound on the Frobenius norm of G less its Taylor polynomial, for |u| <= 1.

    The error e of X solves (I + M^-1 dM) e = M^-1 r with the residual r, so that |e| <= T^-1 |M^-1| |r|, T = I - Q.
    """
    n, q = b.B2.shape
    residual, error = np.empty(n + q), np.empty(n + q)
    square = 0.0
    for col in range(X.shape[2]):
        _residual(b, s0, h, X, Z, col, residual)
        for i in range(n + q):
            error[i] = 0.0
            for j in range(n + q):
                error[i] += sizes[i, j] * residual[j]
        _solve(T, error)
        for row in range(b.C1.shape[0]):
            value = 0.0
            for a in range(n):
                value += abs(b.C1[row, a]) * error[a]
            for c in range(q):
                value += abs(b.D12[row, c]) * error[n + c]
            square += value * value
    return np.sqrt(square)


@numba.njit(cache=True)
def _grown(old):
    new = np.empty((2 * old.shape[0], *old.shape[1:]), old.dtype)
    source, target = old.reshape(-1), new.reshape(-1)
    for i in range(source.size):  # entry by entry: slices take seconds to compile
        target[i] = source[i]
    return new


@numba.njit(cache=True)
def panels(b, start, end, first, order, tolerances, most):
    """Cover the segment from start to end; returns centres, g, series in u (P, K + 1, p, m), errors, and whether done.

    The first panel tries the half length `first`; every next one what the last suggests. `tolerances` are the relative
    one, and an absolute one that is good enough.
    """
    size, q, m, length = b.A.shape[0] + len(b.tau), len(b.tau), b.B1.shape[1], abs(end - start)
    centres, halves, errors = np.empty(64, np.complex128), np.empty(64, np.complex128), np.empty(64)
    series = np.empty((64, order + 1, b.C1.shape[0], m), np.complex128)
    M, inverse = np.empty((size, size), np.complex128), np.empty((size, size), np.complex128)
    X, Z = np.empty((order + 1, size, m), np.complex128), np.empty((order + 1, q, m), np.complex128)
    T, sizes = np.empty((size, size)), np.empty((size, size))
    tolerance, floor = tolerances
    t, h, count, tries = 0.0, first, 0, 0
    while t < length * (1.0 - 1e-14) and count < most and tries < 4 * most:
        tries += 1
        h = min(h, 0.5 * (length - t))
        s0, g = start + (t + h) / length * (end - start), h / length * (end - start)
        characteristic(M, b.A, b.B2, b.C2, b.D22, b.tau, s0)
        if invert(M, inverse) == 0.0:
            h *= 0.5
            continue
        for i in range(size):
            for j in range(size):
                sizes[i, j] = abs(inverse[i, j])
        _change(sizes, b, s0, h, T)
        pivot = _factor(T)
        if not pivot > _LEAST_PIVOT:
            h *= 0.5
            continue
        if count == len(errors):
            centres, halves, errors, series = _grown(centres), _grown(halves), _grown(errors), _grown(series)
        _expand(inverse, b, s0, g, X, Z)
        scale, terms = _read(b, X, series[count])
        error = _remainder(sizes, T, b, s0, h, X, Z)
        if not np.isfinite(error):
            h *= 0.2
            continue
        quality = (max(tolerance * scale, floor) / error) ** (1.0 / (order + 1)) if error > 0.0 else 2.0
        if quality < 1.0:
            h *= max(0.2, 0.85 * quality)
            continue
        centres[count], halves[count], errors[count] = s0, g, error + _ROUNDING * size * terms
        count += 1
        t += 2.0 * h
        h *= min(3.0, 0.9 * quality, 0.8 / max(1.0 - pivot, 0.1))
    return centres[:count], halves[:count], series[:count], errors[:count], t >= length * (1.0 - 1e-14)


@numba.njit(cache=True)
def values(b, points):
    """G (k, p, m) and dG/ds (k, p, m) at complex frequencies (k,); infinite at a root of the system."""
    size, q, m, p = b.A.shape[0] + len(b.tau), len(b.tau), b.B1.shape[1], b.C1.shape[0]
    M, inverse = np.empty((size, size), np.complex128), np.empty((size, size), np.complex128)
    X, Z = np.empty((2, size, m), np.complex128), np.empty((2, q, m), np.complex128)
    G, slope = np.empty((len(points), p, m), np.complex128), np.empty((len(points), p, m), np.complex128)
    series = np.empty((2, p, m), np.complex128)
    for k in range(len(points)):
        characteristic(M, b.A, b.B2, b.C2, b.D22, b.tau, points[k])
        regular = invert(M, inverse) != 0.0
        if regular:
            _expand(inverse, b, points[k], 1.0 + 0.0j, X, Z)
            _read(b, X, series)
        for row in range(p):
            for col in range(m):
                G[k, row, col] = series[0, row, col] if regular else np.inf
                slope[k, row, col] = series[1, row, col] if regular else np.inf
    return G, slope

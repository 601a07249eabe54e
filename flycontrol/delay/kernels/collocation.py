"""Gauss collocation of x' = A x + F on one panel in Legendre coefficients: a block tridiagonal system of n x n blocks.

On a panel of length h, with M = h A / 2 and x' = sum_{k<s} c_k P_k, the polynomial x = sum_{k<=s} x_k P_k through the
panel's start x(0) has x_0 = x(0) + (h/2) (c_0 - c_1 / 3) and x_k = (h/2) (c_{k-1} / (2k - 1) - c_{k+1} / (2k + 3)).
Collocation at the Gauss nodes, where P_s vanishes, is c_k = A x_k + F_k for k < s, so that

    (I - M) c_0 + M c_1 / 3 = A x(0) + F_0,    c_k - M c_{k-1} / (2k - 1) + M c_{k+1} / (2k + 3) = F_k.

Eliminated from k = s - 1 down, with R_s-1 = I, S_k = R_k M / (2k + 3), G_k = R_k M / (2k - 1) and
R_k = (I + M G_{k+1} / (2k + 3))^-1, it costs s inverses of n x n matrices a panel length and 3 s n^2 products a panel.
"""

from __future__ import annotations

import numba
import numpy as np

SUMS = {"reassoc", "contract", "nsz"}  # sums may be taken in any order


@numba.njit(cache=True)
def assign(target, source):
    """target[:] = source for arrays of one index; Numba would spend seconds compiling the message for a misfit."""
    for i in range(len(target)):
        target[i] = source[i]


@numba.njit(cache=True)
def inverse(M):
    """Inverse by Gauss-Jordan with row pivoting where LAPACK's call would cost more; NaN if singular."""
    n = M.shape[0]
    if n > 8:
        return np.linalg.inv(M)
    a, out = M.copy(), np.eye(n)
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[pivot, k]):
                pivot = i
        if a[pivot, k] == 0.0:
            return np.full((n, n), np.nan)
        if pivot != k:
            for j in range(n):
                a[k, j], a[pivot, j] = a[pivot, j], a[k, j]
                out[k, j], out[pivot, j] = out[pivot, j], out[k, j]
        scale = 1.0 / a[k, k]
        for j in range(n):
            a[k, j] *= scale
            out[k, j] *= scale
        for i in range(n):
            factor = a[i, k]
            if i != k and factor != 0.0:
                for j in range(n):
                    a[i, j] -= factor * a[k, j]
                    out[i, j] -= factor * out[k, j]
    return out


@numba.njit(cache=True)
def product(X, Y):
    """X Y, without BLAS where its call would cost more."""
    n = X.shape[0]
    if n > 8:
        return X @ Y
    out = np.zeros((n, n))
    for i in range(n):
        for k in range(n):
            for j in range(n):
                out[i, j] += X[i, k] * Y[k, j]
    return out


@numba.njit(cache=True)
def factor(A, h, R, S):
    """Fill R and S (s, n, n) of the elimination for panels of length h."""
    s, n = R.shape[0], A.shape[0]
    M = (0.5 * h) * A
    if n == 2:
        _factor_pair(M[0, 0], M[0, 1], M[1, 0], M[1, 1], R, S)
        return
    square = product(M, M)
    identity = np.eye(n)
    R[s - 1] = 0.0
    for a in range(n):
        R[s - 1, a, a] = 1.0
    for k in range(s - 2, -1, -1):
        # M G_{k+1} / (2k + 3) = R_{k+1} M^2 / ((2k + 1) (2k + 3)), as all these matrices are functions of M
        inner = identity + product(R[k + 1], square) / ((2.0 * k + 1.0) * (2.0 * k + 3.0))
        if k == 0:
            inner -= M
        settled = inverse(inner)
        for a in range(n):
            assign(R[k, a], settled[a])
    for k in range(s):
        coupling = product(R[k], M)
        for a in range(n):
            for b in range(n):
                S[k, a, b] = coupling[a, b] / (2.0 * k + 3.0)


@numba.njit(cache=True)
def _factor_pair(a, b, c, d, R, S):
    """`factor` for M = [[a, b], [c, d]], written out: a system of two states spends a third of its time here."""
    s = R.shape[0]
    e, f, g, i = a * a + b * c, b * (a + d), c * (a + d), d * d + b * c  # M^2
    p, q, r, t = 1.0, 0.0, 0.0, 1.0  # R_{s-1}
    for k in range(s - 1, -1, -1):
        if k < s - 1:
            scale = 1.0 / ((2.0 * k + 1.0) * (2.0 * k + 3.0))
            w, x = 1.0 + scale * (p * e + q * g), scale * (p * f + q * i)
            y, z = scale * (r * e + t * g), 1.0 + scale * (r * f + t * i)
            if k == 0:
                w, x, y, z = w - a, x - b, y - c, z - d
            over = 1.0 / (w * z - x * y)
            p, q, r, t = z * over, -x * over, -y * over, w * over
        R[k, 0, 0], R[k, 0, 1], R[k, 1, 0], R[k, 1, 1] = p, q, r, t
        scale = 1.0 / (2.0 * k + 3.0)
        S[k, 0, 0], S[k, 0, 1] = scale * (p * a + q * c), scale * (p * b + q * d)
        S[k, 1, 0], S[k, 1, 1] = scale * (r * a + t * c), scale * (r * b + t * d)


@numba.njit(cache=True, fastmath=SUMS)
def solve(A, R, S, h, start, F, c, X):
    """Fill the Legendre coefficients c (s, n) of x' and X (s + 1, n) of x on a panel from x = start.

    F (>= s, n) are those of the forcing; c is overwritten, F is kept.
    """
    s, n = c.shape
    for k in range(s - 1, 0, -1):
        for a in range(n):
            total = 0.0
            for b in range(n):
                total += R[k, a, b] * F[k, b]
            if k < s - 1:
                for b in range(n):
                    total -= S[k, a, b] * c[k + 1, b]
            c[k, a] = total
    first = X[0]
    for a in range(n):
        total = F[0, a]
        for b in range(n):
            total += A[a, b] * start[b]
        first[a] = total
    for a in range(n):
        total = 0.0
        for b in range(n):
            total += R[0, a, b] * first[b] - S[0, a, b] * c[1, b]
        c[0, a] = total
    for k in range(1, s):
        ratio = (2.0 * k + 3.0) / (2.0 * k - 1.0)
        for a in range(n):
            total = 0.0
            for b in range(n):
                total += S[k, a, b] * c[k - 1, b]
            c[k, a] += ratio * total
    integrate(h, start, c, X)


@numba.njit(cache=True)
def integrate(h, start, c, X):
    """Fill X (s + 1, n), the Legendre coefficients of start + the integral of c (s, n) over a panel of length h."""
    s, n = c.shape
    half = 0.5 * h
    for a in range(n):
        X[0, a] = start[a] + half * (c[0, a] - c[1, a] / 3.0)
    for k in range(1, s - 1):
        before, after = half / (2.0 * k - 1.0), half / (2.0 * k + 3.0)
        for a in range(n):
            X[k, a] = before * c[k - 1, a] - after * c[k + 1, a]
    for k in range(s - 1, s + 1):
        for a in range(n):
            X[k, a] = half / (2.0 * k - 1.0) * c[k - 1, a]


@numba.njit(cache=True)
def legendre(coefficients, x):
    """Value at x in [-1, 1] of a Legendre series, by Clenshaw's recurrence."""
    b1, b2 = 0.0, 0.0
    for k in range(len(coefficients) - 1, 0, -1):
        b1, b2 = coefficients[k] + (2.0 * k + 1.0) / (k + 1.0) * x * b1 - (k + 1.0) / (k + 2.0) * b2, b1
    return coefficients[0] + x * b1 - 0.5 * b2


@numba.njit(cache=True)
def clenshaw(coefficients, x):
    """Value at x in [-1, 1] of a Chebyshev series."""
    b1, b2 = 0.0, 0.0
    for k in range(len(coefficients) - 1, 0, -1):
        b1, b2 = 2.0 * x * b1 - b2 + coefficients[k], b1
    return x * b1 - b2 + coefficients[0]


@numba.njit(cache=True, fastmath=SUMS)
def transformed(matrix, values, out):
    """out = matrix @ values for a (k, k) matrix of the rule."""
    for i in range(len(out)):
        total = 0.0
        for j in range(len(values)):
            total += matrix[i, j] * values[j]
        out[i] = total


@numba.njit(cache=True)
def chebyshev_from(matrix, values, out):
    """out = matrix @ values where T_i and P_j meet only for j >= i of the same parity."""
    for i in range(len(out)):
        total = 0.0
        for j in range(i, len(values), 2):
            total += matrix[i, j] * values[j]
        out[i] = total

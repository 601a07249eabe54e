"""March of a nonlinear delay system. The mathematics stands in `flycontrol.delay.nonlinear`."""

from __future__ import annotations

from functools import lru_cache

import numba
import numpy as np
from numba.core.ccallback import CFunc

from flycontrol.delay.kernels.collocation import clenshaw, factor, legendre, solve, transformed

_VECTOR = numba.types.Array(numba.types.float64, 1, "C")
_SIGNATURE = _VECTOR(numba.types.float64, _VECTOR, _VECTOR, _VECTOR, _VECTOR)


def in_python(function):
    """The Python original of a compiled function; None if it is not compiled."""
    if isinstance(function, CFunc):
        return function.__wrapped__
    return getattr(function, "py_func", None)


@lru_cache(maxsize=64)
def first_class(function):
    """A compiled function behind a pointer of one type, so that `march` is compiled once; or why it cannot be."""
    if isinstance(function, CFunc):
        return function
    try:
        return numba.cfunc(_SIGNATURE)(function.py_func)
    except numba.core.errors.NumbaError as refusal:
        return [line for line in str(refusal).splitlines() if line.strip()][1]


@numba.njit(cache=True)
def _doubled(array):
    """A copy with room for twice as many panels."""
    wider = np.empty((2 * array.shape[0],) + array.shape[1:])  # noqa: RUF005 (Numba unpacks no tuple in a display)
    wider[: array.shape[0]] = array
    return wider


@numba.njit(cache=True)
def _delayed_points(panel, first, h, starts, lengths, z_series, c, nodes, where, W):
    """Fill W[:, c] with z_c at the start `first` and at the nodes of a panel of length h, from the panels before it."""
    k = where[c]
    while k > 0 and starts[k] > first + 1e-9 * h:  # a rejected panel may have gone further
        k -= 1
    while k + 1 < panel and starts[k] + lengths[k] <= first + 1e-9 * h:
        k += 1
    where[c] = k
    for i in range(W.shape[0]):
        t = first if i == 0 else first + nodes[i - 1] * h
        while k + 1 < panel and starts[k + 1] < t - 1e-9 * h:
            k += 1
        W[i, c] = legendre(z_series[k, c], 2.0 * (t - starts[k]) / lengths[k] - 1.0)


@numba.njit(cache=True)
def _input_points(pieces, t0, h, nodes, piece, U):
    """Fill U (s + 1, m) with the inputs at the start and the nodes of a panel; returns the piece that holds there."""
    starts, lengths, series = pieces
    while piece + 1 < len(starts) and starts[piece + 1] <= t0 + 1e-9 * h:
        piece += 1
    for i in range(U.shape[0]):
        t = t0 - starts[piece] + (nodes[i - 1] * h if i > 0 else 0.0)
        for b in range(U.shape[1]):
            U[i, b] = clenshaw(series[piece, b], 2.0 * t / lengths[piece] - 1.0)
    return piece


@numba.njit(cache=True)
def _jacobian(f, t, x, w, u, p, J):
    """Fill J (n, n) with forward differences of f at the start of a panel."""
    base = f(t, x, w, u, p)
    size = 0.0
    for a in range(len(x)):
        size = max(size, abs(x[a]))
    moved = x.copy()
    for b in range(len(x)):
        step = 1e-7 * max(abs(x[b]), 1e-3 * size, 1e-12)
        moved[b] = x[b] + step
        slope = f(t, moved, w, u, p)
        for a in range(len(x)):
            J[a, b] = (slope[a] - base[a]) / step
        moved[b] = x[b]


@numba.njit(cache=True)
def _collocate(f, t, h, x, W, U, p, J, R, S, rule, values_at_nodes, F, c, X, tolerance):
    """Iterate x' = J x + (f - J x)(previous) on one panel; whether it converged to the tolerance (n,)."""
    nodes, to_legendre = rule[0], rule[1]
    s, n = c.shape
    X[:] = 0.0
    X[0] = x
    before = np.empty((s + 1, n))
    G = np.empty((s, n))
    last = np.inf
    for _ in range(15):
        before[:] = X
        for i in range(s):
            xi = np.zeros(n)
            for k in range(s):
                for a in range(n):
                    xi[a] += values_at_nodes[i, k] * X[k, a]
            slope = f(t + nodes[i] * h, xi, W[i + 1], U[i + 1], p)
            for a in range(n):
                G[i, a] = slope[a]
                for b in range(n):
                    G[i, a] -= J[a, b] * xi[b]
        for k in range(s):
            for a in range(n):
                total = 0.0
                for i in range(s):
                    total += to_legendre[k, i + 1] * G[i, a]
                F[k, a] = total
        solve(J, R, S, h, x, F, c, X)
        change = 0.0
        for a in range(n):
            moved = 0.0
            for k in range(s + 1):
                moved += abs(X[k, a] - before[k, a])
            if not np.isfinite(moved):
                return False
            change = max(change, moved / tolerance[a])
        if change <= 0.01:
            return True
        if change > 2.0 * last:
            return False
        last = change
    return False


@numba.njit(cache=True)
def march(f, g, tau, breaks, past, pieces, p, x0, rule, rtol, atol, most):
    """March to the last break with panels as long as the tolerances allow and no delay is shorter than.

    f(t, x, w, u, p) is x' and g(t, x, w, u, p) the delayed signals z; `past` = (starts, lengths, Legendre series
    (H, q, s + 1)) of z before time 0; `pieces` = (starts, lengths, Chebyshev series) of the inputs. Returns starts,
    lengths, Chebyshev series of x (P, n, s + 1), states (P + 1, n) and the time reached: short of the end when a panel
    would have become negligible or more than `most` were needed.
    """
    nodes, to_legendre, to_chebyshev, _ = rule
    s, n, q, H = len(nodes), len(x0), len(tau), len(past[0])
    shortest = tau.min() if q else np.inf
    end = breaks[-1]
    room = 64 + H
    starts, lengths = np.empty(room), np.empty(room)
    z_series, x_series, states = np.empty((room, q, s + 1)), np.empty((room, n, s + 1)), np.empty((room, n))
    starts[:H], lengths[:H], z_series[:H] = past
    values_at_nodes = np.empty((s, s))
    for i in range(s):
        for k in range(s):
            unit = np.zeros(s + 1)
            unit[k] = 1.0
            values_at_nodes[i, k] = legendre(unit, 2.0 * nodes[i] - 1.0)
    J, R, S = np.empty((n, n)), np.empty((s, n, n)), np.empty((s, n, n))
    F, c, X = np.empty((s + 1, n)), np.empty((s, n)), np.empty((s + 1, n))
    W, U, Z = np.empty((s + 1, q)), np.empty((s + 1, pieces[2].shape[1])), np.empty((s + 1, q))
    where, tolerance, column = np.zeros(q, np.int64), np.empty(n), np.empty(s + 1)
    x, t, next_break, piece, panel = x0.copy(), 0.0, 1, 0, H
    wanted = end
    while next_break < len(breaks):
        gap = breaks[next_break] - t
        parts = max(1, int(np.ceil(gap / min(wanted, shortest) - 1e-9)))
        h = gap / parts
        if panel - H >= most or h < 1e-13 * end:
            break
        for i in range(q):
            _delayed_points(panel, t - tau[i], h, starts, lengths, z_series, i, nodes, where, W)
        piece = _input_points(pieces, t, h, nodes, piece, U)
        _jacobian(f, t, x, W[0], U[0], p, J)
        factor(J, h, R, S)
        for a in range(n):
            tolerance[a] = atol + rtol * abs(x[a])
        good = _collocate(f, t, h, x, W, U, p, J, R, S, rule, values_at_nodes, F, c, X, tolerance)
        if not good:
            wanted = 0.25 * h
            continue
        error = 0.0
        for a in range(n):
            error = max(error, 0.5 * h * max(abs(c[s - 1, a]), abs(c[s - 2, a])) / (2.0 * s - 3.0) / tolerance[a])
        factor_of_step = 0.9 * max(error, 1e-300) ** (-1.0 / s)
        if error > 1.0:
            wanted = h * max(0.2, factor_of_step)
            continue
        if panel + 1 >= len(starts):
            starts, lengths, states = _doubled(starts), _doubled(lengths), _doubled(states)
            z_series, x_series = _doubled(z_series), _doubled(x_series)
        starts[panel], lengths[panel], states[panel] = t, h, x
        for a in range(n):
            transformed(to_chebyshev, X[:, a].copy(), x_series[panel, a])
        for i in range(s + 1):
            xi = x.copy()
            if i > 0:
                xi[:] = 0.0
                for k in range(s):
                    for a in range(n):
                        xi[a] += values_at_nodes[i - 1, k] * X[k, a]
            Z[i] = g(t + (nodes[i - 1] * h if i > 0 else 0.0), xi, W[i], U[i], p)
        for i in range(q):
            column[:] = Z[:, i]
            transformed(to_legendre, column, z_series[panel, i])
        for a in range(n):
            x[a] += h * c[0, a]
        panel += 1
        wanted = h * min(2.0, factor_of_step)
        if parts == 1:
            t = breaks[next_break]
            next_break += 1
        else:
            t += h
    states[panel] = x
    return starts[H:panel], lengths[H:panel], x_series[H:panel], states[H : panel + 1], t

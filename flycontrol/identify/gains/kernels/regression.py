"""The regression that starts a fit: coarse samples, their integrals, products of columns for every delay tried."""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.identify.gains.kernels.march import COMPILED

DAMPING, KP, KD, KI = range(4)


@numba.njit(**COMPILED)
def integrated(values, step):
    """Trapezoidal integral from the first sample to each."""
    out = np.empty_like(values)
    total = 0.0
    out[0] = 0.0
    for i in range(1, len(values)):
        total += 0.5 * step * (values[i - 1] + values[i])
        out[i] = total
    return out


@numba.njit(**COMPILED)
def coarse_integrals(times, values, step, n):
    """(4, n): means over the cells of an even grid less the first, and their integrals; empty cells interpolated."""
    sums, moments, count = np.zeros(n), np.zeros(n), np.zeros(n)
    for i in range(len(times)):
        cell = min(int((times[i] - times[0]) / step + 0.5), n - 1)
        sums[cell] += values[i]
        moments[cell] += times[i] - times[0]
        count[cell] += 1.0
    there = np.flatnonzero(count)
    grid = step * np.arange(n)
    y = np.interp(grid, moments[there] / count[there], sums[there] / count[there])
    out = np.empty((4, n))
    out[0] = y - y[0]
    for k in range(1, 4):
        out[k] = integrated(out[k - 1], step)
    return out


@numba.njit(**COMPILED)
def displacement(knots, levels, slopes, start, step, n):
    """Where a unit impulse of the drive alone would have moved a free body at the times of a grid (n,)."""
    refined = 8
    begin = min(start, knots[0])
    count = int((start + step * (n - 1) - begin) / step * refined + 1.5)
    h = step / refined
    u, k = np.zeros(count), -1
    for i in range(count):
        t = begin + i * h
        while k + 1 < len(knots) and knots[k + 1] <= t:
            k += 1
        if k >= 0:
            u[i] = levels[k] + slopes[k] * (t - knots[k])
    moved = integrated(integrated(u, h), h)
    return np.interp(start + step * np.arange(n), begin + h * np.arange(count), moved)


@numba.njit(**COMPILED)
def orthonormal(own):
    """Rows (c, n) made orthonormal by Gram and Schmidt, twice; the triangle (c, c) with own = triangle^T basis."""
    c = own.shape[0]
    basis, triangle = own.copy(), np.zeros((c, c))
    for a in range(c):
        for _ in range(2):
            for e in range(a):
                share = np.dot(basis[e], basis[a])
                triangle[e, a] += share
                basis[a] -= share * basis[e]
        triangle[a, a] = np.sqrt(np.dot(basis[a], basis[a]))
        basis[a] /= triangle[a, a]
    return basis, triangle


@numba.njit(**COMPILED)
def columns(integrals, moved, lag, which, fixed):
    """(k + 1, n): regressors of the gains asked for, then yaw less what is known of it; zero before the start."""
    k, n = len(which), integrals.shape[1]
    out = np.zeros((k + 1, n))
    out[k] = integrals[0] - moved
    order = (1, 2, 1, 3)  # of the integral that each gain multiplies
    for gain in range(4):
        late = 0 if gain == DAMPING else lag
        if fixed[gain] != 0.0:
            out[k, late:] += fixed[gain] * integrals[order[gain], : n - late]
    for a in range(k):
        late = 0 if which[a] == DAMPING else lag
        out[a, late:] = -integrals[order[which[a]], : n - late]
    return out


@numba.njit(**COMPILED)
def products(integrals, moved, basis, lags, which, fixed):
    """(lags, k + 1, k + 1): products of the columns once the trial's own unknowns are projected out."""
    k = len(which)
    out = np.empty((len(lags), k + 1, k + 1))
    for i in range(len(lags)):
        rest = columns(integrals, moved, lags[i], which, fixed)
        for a in range(k + 1):
            for e in range(basis.shape[0]):
                rest[a] -= np.dot(basis[e], rest[a]) * basis[e]
        for a in range(k + 1):
            for e in range(a + 1):
                out[i, a, e] = out[i, e, a] = np.dot(rest[a], rest[e])
    return out


@numba.njit(**COMPILED)
def best_gains(grams, dampings):
    """For each lag the gains (lags, k) of least residual, and that residual.

    Damping, the first gain where any are to be tried, is held at each of `dampings` in turn.
    """
    count, k = grams.shape[0], grams.shape[1] - 1
    gains, residuals = np.zeros((count, k)), np.full(count, np.inf)
    first = 1 if len(dampings) else 0
    m = k - first
    for i in range(count):
        for trial in range(max(len(dampings), 1)):
            x = np.zeros(k + 1)
            x[k] = -1.0
            if first:
                x[0] = dampings[trial]
            system, right = np.empty((m, m)), np.empty(m)
            for a in range(m):
                right[a] = grams[i, first + a, k] - (grams[i, first + a, 0] * x[0] if first else 0.0)
                for e in range(m):
                    system[a, e] = grams[i, first + a, first + e]
            if m:
                x[first:k] = _solved(system, right)
            left = 0.0
            for a in range(k + 1):
                for e in range(k + 1):
                    left += x[a] * grams[i, a, e] * x[e]
            if left < residuals[i]:
                residuals[i] = left
                gains[i] = x[:k]
    return gains, residuals


@numba.njit(**COMPILED)
def _solved(system, right):
    """A symmetric system scaled to a unit diagonal and a little stiffened, by elimination."""
    m = len(right)
    scale = np.empty(m)
    for a in range(m):
        scale[a] = 1.0 / np.sqrt(max(system[a, a], 1e-300))
    for a in range(m):
        right[a] *= scale[a]
        for e in range(m):
            system[a, e] *= scale[a] * scale[e]
        system[a, a] += 1e-9
    for a in range(m):
        for b in range(a + 1, m):
            f = system[b, a] / system[a, a]
            right[b] -= f * right[a]
            for e in range(a, m):
                system[b, e] -= f * system[a, e]
    for a in range(m - 1, -1, -1):
        for e in range(a + 1, m):
            right[a] -= system[a, e] * right[e]
        right[a] /= system[a, a]
    return right * scale

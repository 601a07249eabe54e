"""Autoregressive noise: prediction errors of columns of samples, and the restricted likelihood."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, error_model="numpy")
def coefficients(pacf, table):
    """Levinson's recursion: row j of table (order, order) predicts from j + 1 samples; relative error variances.

    pacf (order,) are partial autocorrelations in (-1, 1); variances (order + 1,) are those of the innovation when
    0, 1, ... earlier samples are known, over that when all are.
    """
    order = len(pacf)
    variances = np.ones(order + 1)
    for j in range(order):
        table[j, j] = pacf[j]
        for i in range(j):
            table[j, i] = table[j - 1, i] - pacf[j] * table[j - 1, j - 1 - i]
    for j in range(order - 1, -1, -1):
        variances[j] = variances[j + 1] / (1.0 - pacf[j] * pacf[j])
    return variances


@numba.njit(cache=True, error_model="numpy")
def whitened(rows, firsts, pacf, out):
    """Prediction errors of each row (c, n), divided by their relative size; sum of the logarithms of the variances.

    firsts (s,) are the indices at which a stretch without gap begins; before it nothing is known.
    """
    order = len(pacf)
    table = np.zeros((order, order))
    variances = coefficients(pacf, table)
    n = rows.shape[1]
    logs = 0.0
    for s in range(len(firsts)):
        first = firsts[s]
        last = firsts[s + 1] if s + 1 < len(firsts) else n
        for i in range(min(order, last - first)):
            scale = 1.0 / np.sqrt(variances[i])
            logs += np.log(variances[i])
            for c in range(rows.shape[0]):
                value = rows[c, first + i]
                for j in range(i):
                    value -= table[i - 1, j] * rows[c, first + i - 1 - j]
                out[c, first + i] = value * scale
        for c in range(rows.shape[0]):
            for i in range(first + order, last):
                value = rows[c, i]
                for j in range(order):
                    value -= table[order - 1, j] * rows[c, i - 1 - j]
                out[c, i] = value
    return logs


@numba.njit(cache=True, error_model="numpy")
def lagged(rows, firsts, order):
    """Products of rows (c, n) at lags i and j, (order + 1, order + 1, c, c), and the heads of all stretches.

    Products run over the samples that have `order` earlier ones in their stretch; heads (s, c, order) are the others,
    `held` (s,) how many of them a stretch has.
    """
    c, n = rows.shape
    products = np.zeros((order + 1, order + 1, c, c))
    heads, held = np.zeros((len(firsts), c, order)), np.zeros(len(firsts), dtype=np.int64)
    for s in range(len(firsts)):
        first = firsts[s]
        last = firsts[s + 1] if s + 1 < len(firsts) else n
        held[s] = min(order, last - first)
        heads[s, :, : held[s]] = rows[:, first : first + held[s]]
        for i in range(order + 1):
            for j in range(i + 1):
                for a in range(c):
                    for e in range(c):
                        total = 0.0
                        for t in range(first + order, last):
                            total += rows[a, t - i] * rows[e, t - j]
                        products[i, j, a, e] += total
    for i in range(order + 1):
        for j in range(i):
            products[j, i] = products[i, j].T
    return products, heads, held


@numba.njit(cache=True, error_model="numpy")
def _gram(products, heads, held, pacf):
    """Products of the whitened rows (c, c), and the sum of the logarithms of the relative variances."""
    order, c = len(pacf), products.shape[2]
    table = np.zeros((order, order))
    variances = coefficients(pacf, table)
    weights = np.ones(order + 1)
    for i in range(order):
        weights[i + 1] = -table[order - 1, i]
    gram, logs = np.zeros((c, c)), 0.0
    for i in range(order + 1):
        for j in range(order + 1):
            gram += weights[i] * weights[j] * products[i, j]
    error = np.empty(c)
    for s in range(len(held)):
        for i in range(held[s]):
            logs += np.log(variances[i])
            for a in range(c):
                error[a] = heads[s, a, i]
                for j in range(i):
                    error[a] -= table[i - 1, j] * heads[s, a, i - 1 - j]
            for a in range(c):
                for e in range(c):
                    gram[a, e] += error[a] * error[e] / variances[i]
    return gram, logs


@numba.njit(cache=True, error_model="numpy")
def restricted(products, heads, held, samples, pacf):
    """Minus twice the restricted log likelihood, the innovations' variance profiled out; that variance.

    From the products of rows: residuals, then the derivatives of the model; what these can explain is projected out.
    """
    gram, logs = _gram(products, heads, held, pacf)
    determinant, rank = 0.0, 0
    sizes = np.diag(gram).copy()
    for a in range(len(gram) - 1, 0, -1):  # eliminate the derivatives, last first: the residuals' share remains
        pivot = gram[a, a]
        if pivot <= 1e-12 * sizes[a] or sizes[a] < 1e-200:  # this channel says nothing new of the parameter
            continue
        rank += 1
        determinant += np.log(pivot)
        for e in range(a):
            f = gram[a, e] / pivot
            for d in range(a):
                gram[e, d] -= f * gram[a, d]
    left = max(gram[0, 0], 1e-300)
    freedom = samples - rank
    return freedom * np.log(left / freedom) + logs + determinant, left / freedom


@numba.njit(cache=True, error_model="numpy")
def coloured(innovations, firsts, pacf, out):
    """The inverse of `whitened` for one row (n,): noise whose prediction errors are the innovations."""
    order = len(pacf)
    table = np.zeros((order, order))
    variances = coefficients(pacf, table)
    n = len(innovations)
    for s in range(len(firsts)):
        first = firsts[s]
        last = firsts[s + 1] if s + 1 < len(firsts) else n
        for i in range(first, last):
            known = min(i - first, order)
            value = innovations[i] * np.sqrt(variances[known])
            for j in range(known):
                value += table[known - 1, j] * out[i - 1 - j]
            out[i] = value

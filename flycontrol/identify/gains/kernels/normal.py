"""Products of whitened residuals and derivatives of one yaw channel, in one compiled call."""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.identify.gains.kernels.march import COMPILED, HEADING, march, sampled
from flycontrol.identify.gains.kernels.noise import whitened


@numba.njit(**COMPILED)
def products(p, active, span, knots, drive, samples, noise, rule):
    """R R^T of rows R: whitened residuals of yaw, then its derivatives: (1 + m, 1 + m).

    span = (start, end), knots = (majors, minors), drive as in `march`, samples = (times, values, firsts), noise =
    (partial autocorrelations, standard deviation of the innovations).
    """
    times, values, firsts = samples
    edges, series, _ = march(p, active, span[0], span[1], knots[0], knots[1], drive, False, rule)
    c, n = 1 + len(active), len(times)
    rows = np.empty((c, n))
    sampled(edges, series, times, rows)
    for i in range(n):
        rows[0, i] += p[HEADING] - values[i]
    for a in range(1, c):
        if active[a - 1] == HEADING:
            rows[a] = 1.0
    pacf, deviation = noise
    if len(pacf):
        out = np.empty((c, n))
        whitened(rows, firsts, pacf, out)
        rows = out
    square = np.empty((c, c))
    for a in range(c):
        for e in range(a + 1):
            total = 0.0
            for i in range(n):
                total += rows[a, i] * rows[e, i]
            square[a, e] = square[e, a] = total / (deviation * deviation)
    return square

"""Exact distances of pixels to the nearest one on, or off, a silhouette.

Down and up each column goes the distance g within it; along a row the distance from column q is then the least of
(q - p)^2 + g_p^2 over p, the lower envelope of parabolas, built in one sweep (Felzenszwalb & Huttenlocher 2012).
"""

from __future__ import annotations

import numba
import numpy as np

_NONE = 1 << 14  #: rows to the nearest pixel in a column that has none, more than images have


@numba.njit(cache=True)
def _within_columns(mask, wanted):
    """(H, W) int32 rows to the nearest pixel of the column that is as wanted."""
    rows, columns = mask.shape
    away = np.empty((rows, columns), np.int32)
    for j in range(columns):
        away[0, j] = 0 if mask[0, j] == wanted else _NONE
    for i in range(1, rows):
        for j in range(columns):
            away[i, j] = 0 if mask[i, j] == wanted else min(away[i - 1, j] + 1, _NONE)
    for i in range(rows - 2, -1, -1):
        for j in range(columns):
            away[i, j] = min(away[i, j], away[i + 1, j] + 1)
    return away


@numba.njit(cache=True)
def _envelope(g, vertices, begins):
    """Columns of the parabolas that are lowest somewhere, and where each begins to be; their number."""
    k = -1
    for q in range(g.shape[0]):
        if g[q] >= _NONE:
            continue
        begin = -np.inf
        while k >= 0:
            p = vertices[k]
            begin = 0.5 * ((q + p) + float(g[q] * g[q] - g[p] * g[p]) / (q - p))
            if begin > begins[k]:
                break
            k -= 1
            begin = -np.inf
        k += 1
        vertices[k], begins[k] = q, begin
    return k + 1


@numba.njit(cache=True)
def distance_to(mask, wanted):
    """(H, W) distance of each pixel to the nearest one of a boolean (H, W) that is as wanted; inf if none is [px]."""
    rows, columns = mask.shape
    away = _within_columns(mask, wanted)
    found = np.empty((rows, columns))
    vertices, begins = np.empty(columns, np.int64), np.empty(columns)
    for i in range(rows):
        count = _envelope(away[i], vertices, begins)
        k = 0
        for j in range(columns):
            if away[i, j] == 0:
                found[i, j] = 0.0
                continue
            while k + 1 < count and begins[k + 1] < j:
                k += 1
            p = vertices[k]
            found[i, j] = np.sqrt(float((j - p) ** 2 + away[i, p] ** 2)) if count else np.inf
    return found

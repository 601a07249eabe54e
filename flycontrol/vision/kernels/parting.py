"""Whose the voxels of a hull are: the body of revolution claims what is near it, then each wing what is nearer to it.

The body's profile and the wings' outline are tables whose rows begin with a place along the long axis or the span and
go on with the widths there and their slopes up to the next row. `starts` has, for equal bins between the first and the
last place, the row from which to look for a place in the bin.
"""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True, inline="always")
def _row_at(rows, starts, bins, x):
    """The last row whose place is not beyond x, but no later than the last but one."""
    k = starts[min(int((x - rows[0, 0]) * bins), starts.shape[0] - 1)]
    while k < rows.shape[0] - 2 and rows[k + 1, 0] <= x:
        k += 1
    return k


@numba.njit(cache=True)
def claim_for_body(indices, place, rows, starts, widest, reach, away, labels):
    """Distance of voxels from the body, < 0 inside; beyond its reach they are no one's and the reach stands.

    Parameters
    ----------
    indices : (N, 3) int32
    place : (3, 4) from (i, j, k, 1) to the long axis, right and down from the body's centre [m]
    rows, starts : (M, 3) place, radius, its slope [m]; (B,)
    widest, reach : radius at the thickest; farthest distance at which a voxel is the body's [m]
    away : (N,) written [m];  labels : (N,) int8, written: 1 the body's, 0 no one's
    """
    (a0, a1, a2, a3), (b0, b1, b2, b3), (c0, c1, c2, c3) = place[0], place[1], place[2]
    first, last = rows[0, 0], rows[rows.shape[0] - 1, 0]
    bins, within = starts.shape[0] / (last - first), (widest + reach) ** 2
    for v in range(indices.shape[0]):
        i, j, k = float(indices[v, 0]), float(indices[v, 1]), float(indices[v, 2])
        x = a0 * i + a1 * j + a2 * k + a3
        y = b0 * i + b1 * j + b2 * k + b3
        z = c0 * i + c1 * j + c2 * k + c3
        along, aside = min(max(x, first), last), y * y + z * z
        beyond = x - along
        away[v], labels[v] = reach, 0
        if abs(beyond) > reach or aside > within:
            continue
        row = _row_at(rows, starts, bins, along)
        d = np.sqrt(aside) - rows[row, 1] - rows[row, 2] * (along - rows[row, 0])
        if beyond != 0.0:
            d = np.sqrt(max(d, 0.0) ** 2 + beyond * beyond)
        if d <= reach:
            away[v], labels[v] = d, 1


@numba.njit(cache=True)
def claim_for_wing(indices, place, rows, starts, label, away, labels):
    """Voxels nearer to a flat wing than to what they belong to become the wing's; beside its edges about so.

    Parameters
    ----------
    indices : (N, 3) int32
    place : (3, 4) from (i, j, k, 1) to span, chord and normal from the wing's base [m]
    rows, starts : (S, 5) place, leading and trailing edge, their slopes [m]; (B,)
    label : the wing's
    away : (N,) distance from what they belong to, or their reach [m], and labels : (N,) int8, overwritten
    """
    (a0, a1, a2, a3), (b0, b1, b2, b3), (c0, c1, c2, c3) = place[0], place[1], place[2]
    first, last = rows[0, 0], rows[rows.shape[0] - 1, 0]
    bins = starts.shape[0] / (last - first)
    for v in range(indices.shape[0]):
        limit = away[v]
        if limit <= 0.0:
            continue  # inside the body
        limit *= limit
        i, j, k = float(indices[v, 0]), float(indices[v, 1]), float(indices[v, 2])
        n = c0 * i + c1 * j + c2 * k + c3
        if n * n >= limit:
            continue
        s = a0 * i + a1 * j + a2 * k + a3
        along = min(max(s, first), last)
        d = n * n + (s - along) ** 2
        if d >= limit:
            continue
        c = b0 * i + b1 * j + b2 * k + b3
        row = _row_at(rows, starts, bins, along)
        on = along - rows[row, 0]
        leading, trailing = rows[row, 1] + rows[row, 3] * on, rows[row, 2] + rows[row, 4] * on
        d += (c - min(max(c, trailing), leading)) ** 2
        if d < limit:
            away[v], labels[v] = np.sqrt(d), label


@numba.njit(cache=True)
def gather(indices, labels, label, count, size, base, along, least):
    """(M, 3) centres, counted from a base (3,), of the voxels of one label that lie beyond `least` along a way [m].

    Parameters
    ----------
    indices, labels, label, count : (N, 3) int32, (N,) int8; which label, and how many voxels have it
    size : edge of a voxel [m]
    base, along, least : (3,) [m], (3,) unit vector, [m]; all voxels where this is -inf
    """
    points, n = np.empty((count, 3)), 0
    (x0, y0, z0), (ax, ay, az) = base, along
    for v in range(indices.shape[0]):
        if labels[v] == label:
            x, y, z = (indices[v, 0] + 0.5) * size, (indices[v, 1] + 0.5) * size, (indices[v, 2] + 0.5) * size
            x, y, z = x - x0, y - y0, z - z0
            if x * ax + y * ay + z * az > least:
                points[n, 0], points[n, 1], points[n, 2] = x, y, z
                n += 1
    return points[:n]

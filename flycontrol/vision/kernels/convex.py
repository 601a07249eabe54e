"""Corners of the smallest convex polygon around points of a plane, by Andrew's chains."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def _in_order(points):
    """Points by u, those of equal u by v."""
    order = np.argsort(points[:, 0])
    for n in range(1, order.shape[0]):
        moved, k = order[n], n
        while k > 0 and points[order[k - 1], 0] == points[moved, 0] and points[order[k - 1], 1] > points[moved, 1]:
            order[k] = order[k - 1]
            k -= 1
        order[k] = moved
    return order


@numba.njit(cache=True)
def _extended(found, first, count, points, n):
    """One more corner, before which those that no longer turn left are left out again; their number."""
    while count - first >= 2:
        (u0, v0), (u1, v1) = points[found[count - 2]], points[found[count - 1]]
        if (u1 - u0) * (points[n, 1] - v0) - (v1 - v0) * (points[n, 0] - u0) > 0.0:
            break
        count -= 1
    found[count] = n
    return count + 1


@numba.njit(cache=True)
def corners(points):
    """Which points (N, 2) are corners, (K,), once around to the left; those of a line are its two ends."""
    order = _in_order(points)
    found, count, last = np.empty(2 * order.shape[0], np.int64), 0, order.shape[0] - 1
    for n in order:
        count = _extended(found, 0, count, points, n)
    first = count - 1
    for k in range(last - 1, -1, -1):
        count = _extended(found, first, count, points, order[k])
    return found[: max(count - 1, 1)].copy()

"""Corners of the smallest convex polygon around points of a plane, by Andrew's chains."""

from __future__ import annotations

import numba
import numpy as np

_WAYS = np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [-1.0, 1.0], [-1.0, 0.0], [-1.0, -1.0], [0.0, -1.0], [1.0, -1.0]])


@numba.njit(cache=True)
def _farthest(points):
    """(8, 2) the points that lie farthest in eight directions, once around to the left."""
    octagon, reach = np.empty((8, 2)), np.full(8, -np.inf)
    for n in range(points.shape[0]):
        u, v = points[n, 0], points[n, 1]
        for k in range(8):
            along = u * _WAYS[k, 0] + v * _WAYS[k, 1]
            if along > reach[k]:
                reach[k], octagon[k, 0], octagon[k, 1] = along, u, v
    return octagon


@numba.njit(cache=True)
def _outer(points):
    """Which points are not inside the octagon of the farthest ones: few, and all corners are among them."""
    octagon, found, count = _farthest(points), np.empty(points.shape[0], np.int64), 0
    for n in range(points.shape[0]):
        inside, sides = True, 0
        for k in range(8):
            u0, v0, u1, v1 = octagon[k - 1, 0], octagon[k - 1, 1], octagon[k, 0], octagon[k, 1]
            if u0 == u1 and v0 == v1:
                continue
            sides += 1
            if not (u1 - u0) * (points[n, 1] - v0) - (v1 - v0) * (points[n, 0] - u0) > 0.0:
                inside = False
                break
        if not inside or sides < 3:
            found[count] = n
            count += 1
    return found[:count]


@numba.njit(cache=True)
def _in_order(points):
    """Points that may be corners, by u, those of equal u by v."""
    outer = _outer(points)
    order = outer[np.argsort(points[outer, 0])]
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

"""Sums over points, of which their middle and their scatter consist."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def sums(indices, labels, label, origin):
    """Whole numbers (10,): how many voxels have a label, and sums of x, y, z, xx, xy, xz, yy, yz, zz of their indices.

    Indices are counted from an origin (3,) near them, so that the sums stay small.
    """
    n = sx = sy = sz = sxx = sxy = sxz = syy = syz = szz = np.int64(0)
    x0, y0, z0 = np.int64(origin[0]), np.int64(origin[1]), np.int64(origin[2])
    for v in range(indices.shape[0]):
        if labels[v] == label:
            x, y, z = indices[v, 0] - x0, indices[v, 1] - y0, indices[v, 2] - z0
            n += 1
            sx, sy, sz = sx + x, sy + y, sz + z
            sxx, sxy, sxz = sxx + x * x, sxy + x * y, sxz + x * z
            syy, syz, szz = syy + y * y, syz + y * z, szz + z * z
    return np.array([n, sx, sy, sz, sxx, sxy, sxz, syy, syz, szz])


@numba.njit(cache=True)
def spread(points):
    """Mean (3,) of points (N, 3), and sum of (p - m)(p - m)^T, (3, 3)."""
    count = max(points.shape[0], 1)
    x = y = z = xx = xy = xz = yy = yz = zz = 0.0
    for n in range(points.shape[0]):
        x, y, z = x + points[n, 0], y + points[n, 1], z + points[n, 2]
    x, y, z = x / count, y / count, z / count
    for n in range(points.shape[0]):
        a, b, c = points[n, 0] - x, points[n, 1] - y, points[n, 2] - z
        xx, xy, xz = xx + a * a, xy + a * b, xz + a * c
        yy, yz, zz = yy + b * b, yz + b * c, zz + c * c
    return np.array([x, y, z]), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

"""The pixels that voxels cover in an image."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def paint(P, indices, half_u, half_v, image):
    """Set the pixels whose centres lie within half_u, half_v [px] of a projected voxel, and the nearest one.

    Parameters
    ----------
    P : (3, 4) from lattice indices to homogeneous pixels
    indices : (N, 3) int32
    image : (H, W) bool, written
    """
    rows, columns = image.shape
    for n in range(indices.shape[0]):
        x, y, z = indices[n, 0], indices[n, 1], indices[n, 2]
        w = P[2, 0] * x + P[2, 1] * y + P[2, 2] * z + P[2, 3]
        if not w > 0.0:
            continue
        u = (P[0, 0] * x + P[0, 1] * y + P[0, 2] * z + P[0, 3]) / w
        v = (P[1, 0] * x + P[1, 1] * y + P[1, 2] * z + P[1, 3]) / w
        if not (-1e6 < u < 1e6 and -1e6 < v < 1e6):
            continue
        near_u, near_v = int(np.floor(u + 0.5)), int(np.floor(v + 0.5))
        j0, j1 = min(int(np.ceil(u - half_u)), near_u), max(int(np.floor(u + half_u)), near_u)
        i0, i1 = min(int(np.ceil(v - half_v)), near_v), max(int(np.floor(v + half_v)), near_v)
        for i in range(max(i0, 0), min(i1 + 1, rows)):
            for j in range(max(j0, 0), min(j1 + 1, columns)):
                image[i, j] = True

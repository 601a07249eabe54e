"""The pixels that voxels cover in an image."""

from __future__ import annotations

import numba
import numpy as np

#: Marks of a pixel: under a projected voxel, nearest to the projected centre of one.
UNDER, NEAREST = 1, 2
#: Farther outside no image is; added before fractions are cut off, so that cutting off rounds down [px]
_FAR = 1 << 20


@numba.njit(cache=True)
def paint(P, indices, image):
    """Mark the pixels whose centres lie in the rectangle around a projected voxel, and the nearest one.

    Half its width is the sum over a = x, y, z of |du/da| / 2 = |p0a - u p2a| / 2 w.

    Parameters
    ----------
    P : (3, 4) from lattice indices to homogeneous pixels
    indices : (N, 3) int32
    image : (H, W) uint8, written
    """
    rows, columns = image.shape
    p00, p01, p02, p03 = P[0]
    p10, p11, p12, p13 = P[1]
    p20, p21, p22, p23 = P[2]
    for n in range(indices.shape[0]):
        x, y, z = np.float64(indices[n, 0]), np.float64(indices[n, 1]), np.float64(indices[n, 2])
        w = p20 * x + p21 * y + p22 * z + p23
        u = (p00 * x + p01 * y + p02 * z + p03) / w
        v = (p10 * x + p11 * y + p12 * z + p13) / w
        if not (w > 0.0 and -_FAR / 2 < u < _FAR / 2 and -_FAR / 2 < v < _FAR / 2):
            continue
        half_u = 0.5 * (abs(p00 - u * p20) + abs(p01 - u * p21) + abs(p02 - u * p22)) / w
        half_v = 0.5 * (abs(p10 - v * p20) + abs(p11 - v * p21) + abs(p12 - v * p22)) / w
        near_u, near_v = int(u + (_FAR + 0.5)) - _FAR, int(v + (_FAR + 0.5)) - _FAR
        j0, j1 = min(int(u - half_u + _FAR) - _FAR + 1, near_u), max(int(u + half_u + _FAR) - _FAR, near_u)
        i0, i1 = min(int(v - half_v + _FAR) - _FAR + 1, near_v), max(int(v + half_v + _FAR) - _FAR, near_v)
        for i in range(max(i0, 0), min(i1 + 1, rows)):
            for j in range(max(j0, 0), min(j1 + 1, columns)):
                image[i, j] |= np.uint8(UNDER)
        if 0 <= near_u < columns and 0 <= near_v < rows:
            image[near_v, near_u] |= np.uint8(NEAREST)

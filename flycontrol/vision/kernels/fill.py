"""Filling projected triangles: a pixel is set if its centre lies in one of them, borders included."""

from __future__ import annotations

import numba
import numpy as np

#: By which spans are widened, so that no crack opens between neighbours [px]
_ROUNDING = 1e-9


@numba.njit(cache=True)
def fill_triangles(pixels, faces, image):
    """Set the pixels of an image under triangles.

    Parameters
    ----------
    pixels : (V, 2) u, v of the vertices
    faces : (F, 3) whose vertices
    image : (H, W) bool, written
    """
    rows, columns = image.shape
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        v_low = min(pixels[a, 1], pixels[b, 1], pixels[c, 1])
        v_high = max(pixels[a, 1], pixels[b, 1], pixels[c, 1])
        first, last = max(np.ceil(v_low - _ROUNDING), 0.0), min(np.floor(v_high + _ROUNDING), rows - 1.0)
        for i in range(int(first), int(last) + 1):
            u_low, u_high = np.inf, -np.inf
            for side in range(3):
                p = a if side == 0 else (b if side == 1 else c)
                q = b if side == 0 else (c if side == 1 else a)
                u0, v0, u1, v1 = pixels[p, 0], pixels[p, 1], pixels[q, 0], pixels[q, 1]
                if not (min(v0, v1) - _ROUNDING <= i <= max(v0, v1) + _ROUNDING):
                    continue
                if abs(v1 - v0) <= _ROUNDING:
                    u_low, u_high = min(u_low, u0, u1), max(u_high, u0, u1)
                else:
                    u = u0 + (u1 - u0) * min(max((i - v0) / (v1 - v0), 0.0), 1.0)
                    u_low, u_high = min(u_low, u), max(u_high, u)
            left, right = max(np.ceil(u_low - _ROUNDING), 0.0), min(np.floor(u_high + _ROUNDING), columns - 1.0)
            for j in range(int(left), int(right) + 1):
                image[i, j] = True

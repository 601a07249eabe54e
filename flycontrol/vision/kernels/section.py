"""The section of a cloud of points across a line."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def section(points, middle, along, half, first, second):
    """(M, 2) places along two directions of the points that lie within `half` of a middle along a third.

    Parameters
    ----------
    points : (N, 3) [m]
    middle : (3,) from where places count [m]
    along, first, second : (3,) unit vectors
    half : [m]
    """
    found, count = np.empty((points.shape[0], 2)), 0
    (mx, my, mz), (ax, ay, az), (ux, uy, uz), (vx, vy, vz) = middle, along, first, second
    for n in range(points.shape[0]):
        x, y, z = points[n, 0] - mx, points[n, 1] - my, points[n, 2] - mz
        if abs(x * ax + y * ay + z * az) < half:
            found[count, 0], found[count, 1] = x * ux + y * uy + z * uz, x * vx + y * vy + z * vz
            count += 1
    return found[:count]

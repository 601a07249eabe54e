"""Middle and scatter of points, from which their principal axes follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.vision.kernels.moments import spread, sums

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Moments:
    """Of N points."""

    middle: FloatArray  #: (3,) [m]
    scatter: FloatArray  #: (3, 3) sum of (p - m)(p - m)^T [m^2]

    @property
    def long_axis(self) -> FloatArray:
        """(3,) first principal axis."""
        return np.linalg.eigh(self.scatter)[1][:, -1]


def moments_of_points(points: FloatArray) -> Moments:
    """Of points (N, 3) [m]."""
    middle, scatter = spread(points)
    return Moments(middle=middle, scatter=scatter)


def moments_of_voxels(indices: NDArray[np.int32], labels: NDArray[np.int8], label: int, size: float) -> Moments:
    """sum (p - m)(p - m)^T = h^2 (n sum i i^T - s s^T) / n of n voxels i with edges h, s = sum i: whole numbers inside.

    Parameters
    ----------
    indices : (N, 3) of voxels centred at (i + 1/2) h
    labels : (N,)
    label : of the voxels meant
    size : h [m]
    """
    origin = indices[0] if len(indices) else np.zeros(3, np.int32)
    n, x, y, z, xx, xy, xz, yy, yz, zz = (int(one) for one in sums(indices, labels, label, origin))
    s, n = np.array([x, y, z]), max(n, 1)
    inside = n * np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) - np.outer(s, s)
    return Moments(middle=(origin + s / n + 0.5) * size, scatter=inside * (size**2 / n))

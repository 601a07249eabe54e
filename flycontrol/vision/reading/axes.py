"""Axes from one direction and another near to the next."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """A x b of two vectors (3,); NumPy's own, made for many, takes ten times as long for one."""
    (a0, a1, a2), (b0, b1, b2) = a.tolist(), b.tolist()
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])


def across(direction: FloatArray, near: FloatArray) -> FloatArray:
    """(3,) unit vector across a unit vector (3,), as near to another vector as it can be; any where that lies along."""
    way = near - (near @ direction) * direction
    length = float(np.sqrt(way @ way))
    return way / length if length > 1e-6 else np.linalg.svd(direction[None])[2][1]

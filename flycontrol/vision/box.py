"""The box of the lattice that can hold a hull: where the pyramids over the silhouettes' rectangles meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.vision.kernels.corners import box_of_corners, is_open
from flycontrol.vision.views import Views

FloatArray = NDArray[np.float64]

MOST_VOXELS = 2**33  #: of a box: 2048 a side; more is a wrong unit
_ROUNDING = 1e-9  #: of a voxel


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """Voxels low <= (i, j, k) < high of the lattice whose voxel (i, j, k) is centred at (i + 1/2, ...) sizes."""

    low: tuple[int, int, int]
    high: tuple[int, int, int]

    @property
    def shape(self) -> tuple[int, int, int]:
        """Voxels along x, y, z."""
        x, y, z = (max(b - a, 0) for a, b in zip(self.low, self.high, strict=True))
        return (x, y, z)


def box_of_views(views: Views, size: float) -> Box:
    """Smallest box of voxels of `size` [m] that holds all points which project onto every view's rectangle.

    Raises
    ------
    InvalidInputError
        If the views leave the box open, as one camera alone or parallel ones do.
    """
    planes = _planes(views)
    if is_open(planes):
        raise InvalidInputError(
            f"{', '.join(camera.name for camera in views.cameras)}: these views do not enclose the animal, since some "
            "direction lies within all of them; give cameras that look from different sides."
        )
    least, most = box_of_corners(planes)
    if not np.all(least <= most):
        return Box(low=(0, 0, 0), high=(0, 0, 0))
    low = np.floor(least / size - _ROUNDING).astype(int)
    high = np.ceil(most / size + _ROUNDING).astype(int)
    box = Box(low=_whole(low), high=_whole(high))
    if np.prod(np.array(box.shape, dtype=np.float64)) > MOST_VOXELS:
        raise InvalidParameterError(
            f"A box of {' x '.join(map(str, box.shape))} voxels of {size!r} m is too large; check the voxels' size "
            "and the unit of the cameras."
        )
    return box


def _whole(values: NDArray[np.int_]) -> tuple[int, int, int]:
    x, y, z = (int(v) for v in values)
    return (x, y, z)


def _planes(views: Views) -> FloatArray:
    """(4 C, 4) half-spaces n . (x, y, z, 1) >= 0, |n[:3]| = 1: half a pixel around each view's rectangle."""
    sides: list[FloatArray] = []
    for camera, (low, high) in zip(views.cameras, views.extent, strict=True):
        P = camera.matrix
        for axis in (0, 1):
            sides.append(P[axis] - (low[axis] - 0.5) * P[2])
            sides.append((high[axis] + 0.5) * P[2] - P[axis])
    planes = np.array(sides)
    return planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)

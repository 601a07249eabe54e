"""Silhouettes with soft borders: what a fitted fly is compared with."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.camera import Camera
from flycontrol.vision.kernels.distance import distance_to
from flycontrol.vision.views import BoolArray, Views

FloatArray = NDArray[np.float64]

_FAR = 500.0  #: softnesses from a border: there and beyond a silhouette is nothing


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BorderDistance:
    """Signed distances to the borders of C silhouettes, > 0 outside, cropped with a margin."""

    cameras: tuple[Camera, ...]  #: without lenses
    distance: FloatArray  #: (C, V, U) [px]; far outside where a crop is smaller than the array
    corner: FloatArray  #: (C, 2) u, v of each crop's first pixel
    extent: NDArray[np.int64]  #: (C, 2) columns and rows of each crop
    _made: dict[float, FloatArray] = field(default_factory=dict[float, FloatArray], init=False, repr=False)

    @property
    def image(self) -> FloatArray:
        """(C, 2) columns and rows of the images."""
        return np.array([camera.shape[::-1] for camera in self.cameras], dtype=np.float64)

    def softened(self, softness: float) -> FloatArray:
        """1 / (1 + exp(D / s)), (C, V, U), of a softness s [px]; made once."""
        if softness not in self._made:
            self._made[softness] = 1 / (1 + np.exp(np.minimum(self.distance / softness, _FAR)))
        return self._made[softness]


def border_distance(views: Views, margin: int) -> BorderDistance:
    """Distances of the silhouettes of views, up to `margin` pixels around them where the images have as many."""
    crops = [_crop(mask, margin) for mask in views.masks]
    height, width = (max(crop[0].shape[axis] for crop in crops) for axis in (0, 1))
    distance = np.full((len(crops), height, width), float(height + width))
    for padded, (crop, _) in zip(distance, crops, strict=True):
        padded[: crop.shape[0], : crop.shape[1]] = signed_distance(crop)
    return BorderDistance(
        cameras=views.cameras,
        distance=distance,
        corner=np.array([corner for _, corner in crops], dtype=np.float64),
        extent=np.array([crop.shape[::-1] for crop, _ in crops], dtype=np.int64),
    )


def signed_distance(mask: BoolArray) -> FloatArray:
    """Distance of pixels' centres to the border, half a pixel from the outermost pixels of a mask; < 0 inside."""
    mask = np.ascontiguousarray(mask)
    return np.where(mask, 0.5 - distance_to(mask, False), distance_to(mask, True) - 0.5)


def _crop(mask: BoolArray, margin: int) -> tuple[BoolArray, tuple[int, int]]:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    top, left = max(int(rows[0]) - margin, 0), max(int(columns[0]) - margin, 0)
    return mask[top : rows[-1] + margin + 1, left : columns[-1] + margin + 1], (left, top)

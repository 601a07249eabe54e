"""What a tracker takes of a filmed instant: silhouettes of the one animal that it follows, or why there are none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label

from flycontrol.model.camera import Camera
from flycontrol.vision.checks.calibration_check import check_calibration
from flycontrol.vision.fit_shape import FitShape
from flycontrol.vision.footage import FilmedFrame
from flycontrol.vision.stance import Stance
from flycontrol.vision.views import BoolArray

FloatArray = NDArray[np.float64]

_FULL = 0.5  #: of an image: no animal that is followed fills more of it (C)
_REACH = 0.3  #: wing lengths around the expected fly in which its own parts lie (C)
_IN_VIEW = 0.6  #: of a body, without which its place and attitude are not told (C)
_RIVAL = 0.5  #: of the largest part: what is larger may be another animal, as in `Segmentation`
_AGREEING = 3.0  #: epipolar residual of parts that may be of one animal [px] (C)
_MOST_CHOICES = 64
_TOUCHING = np.ones((3, 3), dtype=np.bool_)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sighting:
    """One instant seen by C cameras, ready to be followed."""

    masks: tuple[BoolArray, ...]  #: without dust; empty where the frame is unusable
    fault: str = ""  #: why it is unusable, or empty
    crowded: tuple[str, ...] = ()  #: names of cameras that see more than one animal

    @property
    def clear(self) -> bool:
        """Whether every camera sees one animal and no more."""
        return not self.fault and not self.crowded and all(mask.any() for mask in self.masks)


def sighting_of(frame: FilmedFrame | Sequence[BoolArray], cameras: Sequence[Camera]) -> Sighting:
    """What a filmed frame, or its bare masks, show."""
    if not isinstance(frame, FilmedFrame):
        return Sighting(masks=tuple(frame), fault=_overfull(frame, cameras))
    if frame.fault:
        return Sighting(masks=(), fault=frame.fault)
    masks = tuple(silhouette.mask for silhouette in frame.silhouettes)
    pairs = zip(frame.silhouettes, cameras, strict=False)
    crowded = tuple(camera.name for silhouette, camera in pairs if silhouette.animals > 1)
    return Sighting(masks=masks, fault=_overfull(masks, cameras), crowded=crowded)


def _overfull(masks: Sequence[BoolArray], cameras: Sequence[Camera]) -> str:
    for mask, camera in zip(masks, cameras, strict=False):
        share = float(np.mean(mask))
        if share > _FULL:
            return f"{camera.name}: the silhouette fills {100 * share:.0f} % of the image, as no animal does"
    return ""


def of_the_expected(
    masks: Sequence[BoolArray], cameras: Sequence[Camera], shape: FitShape, expected: Stance
) -> tuple[BoolArray, ...]:
    """Silhouettes without those parts that lie farther from an expected fly than its own parts can.

    Where nothing would be left, the silhouette stays as it is.
    """
    return tuple(_near(mask, camera, shape, expected) for mask, camera in zip(masks, cameras, strict=True))


def leaving(masks: Sequence[BoolArray], cameras: Sequence[Camera], shape: FitShape, expected: Stance) -> str:
    """Name of a camera whose image ends before most of an expected body, and whose silhouette reaches that end."""
    body = expected.position_W + shape.spheres[:, :3] @ expected.body_axes_W.T
    for mask, camera in zip(masks, cameras, strict=True):
        ends = mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any() or not mask.any()
        if ends and float(np.mean(camera.sees(camera.project(body)))) < _IN_VIEW:
            return camera.name
    return ""


def one_animal(masks: Sequence[BoolArray], cameras: Sequence[Camera]) -> tuple[BoolArray, ...]:
    """Silhouettes of one of several animals in view: of all choices of a part from each view, the largest that agree.

    Parts of less than half of the largest one are no choices; they stay with the nearest large part of their view.
    """
    choices = list(product(*(_large_parts(mask) for mask in masks)))
    if len(choices) < 2 or len(choices) > _MOST_CHOICES:
        return tuple(masks)
    residuals = np.array([max(pair.median for pair in check_calibration([each], cameras).pairs) for each in choices])
    areas = np.array([sum(int(part.sum()) for part in choice) for choice in choices])
    agreeing = residuals <= max(_AGREEING, float(np.min(residuals)))
    return choices[int(np.argmax(np.where(agreeing, areas, 0)))]


def _large_parts(mask: BoolArray) -> list[BoolArray]:
    """The mask shared out among its large parts, each pixel to the nearest."""
    parts, count = cast(tuple[NDArray[np.int32], int], label(mask, structure=_TOUCHING))
    area = np.bincount(parts.ravel(), minlength=count + 1)
    area[0] = 0
    large = np.flatnonzero(area >= _RIVAL * area.max()) if count else np.empty(0, dtype=np.int64)
    if len(large) < 2:
        return [mask]
    away = np.stack([np.asarray(distance_transform_edt(parts != number)) for number in large])
    nearest = np.argmin(away, axis=0)
    return [mask & (nearest == k) for k in range(len(large))]


def _near(mask: BoolArray, camera: Camera, shape: FitShape, expected: Stance) -> BoolArray:
    parts, count = cast(tuple[NDArray[np.int32], int], label(mask, structure=_TOUCHING))
    if count < 2:
        return mask
    points, radii = _outline(shape, expected)
    pixels, scale = camera.project(points), camera.pixels_per_metre(points)
    limit = _REACH * shape.wing_length * float(np.mean(scale))
    kept = np.zeros(count + 1, dtype=np.bool_)
    if limit > 1:  # parts that hold a pixel of the expected fly, as its own do, need no look at every pixel
        nearest = np.floor(pixels[camera.sees(pixels)] + 0.5).astype(np.intp)
        kept[parts[nearest[:, 1], nearest[:, 0]]] = True
        kept[0] = False
    for number in np.flatnonzero(~kept[1:]) + 1:
        v, u = np.nonzero(parts == number)
        away = np.hypot(u[:, None] - pixels[None, :, 0], v[:, None] - pixels[None, :, 1]) - radii * scale
        kept[number] = np.nanmin(away) < limit
    return kept[parts] if kept.any() else mask


def _outline(shape: FitShape, stance: Stance) -> tuple[FloatArray, FloatArray]:
    """Points (M, 3) of body and wings in the world, and how far around them the fly reaches (M,) [m]."""
    body = stance.position_W + shape.spheres[:, :3] @ stance.body_axes_W.T
    wings = [stance.base_W(side) + shape.outline @ stance.wing_axes_W(side)[:, :2].T for side in (0, 1)]
    flat = np.zeros(2 * len(shape.outline))
    return np.vstack([body, *wings]), np.concatenate([shape.spheres[:, 3], flat])

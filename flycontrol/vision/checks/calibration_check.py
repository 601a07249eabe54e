"""Whether cameras and silhouettes fit: a plane through two cameras that touches an animal in one view does in both."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera import Camera
from flycontrol.vision.views import BoolArray, require_fitting

FloatArray = NDArray[np.float64]

_INFINITY = 1e3  #: from where orthographic cameras look [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class PairResidual:
    """Two cameras, how far the planes that touch the silhouettes miss each other, frame by frame [px]."""

    cameras: tuple[str, str]
    shift: FloatArray  #: (N,) mean of both sides: a wrong place of a camera; NaN where a silhouette is empty
    growth: FloatArray  #: (N,) how much taller the second silhouette is: thresholds that differ, parts unseen

    @property
    def median(self) -> float:
        """Median of |shift| [px]."""
        return float(np.nanmedian(np.abs(self.shift)))


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationCheck:
    """All pairs of cameras."""

    pairs: tuple[PairResidual, ...]

    @property
    def residual(self) -> float:
        """Median of |shift| over all pairs and frames: the number of a calibration [px]."""
        return float(np.nanmedian(np.abs(np.concatenate([pair.shift for pair in self.pairs]))))


def check_calibration(frames: Iterable[Sequence[BoolArray]], cameras: Sequence[Camera]) -> CalibrationCheck:
    """Epipolar residuals of the extreme points of silhouettes, frame by frame.

    Planes through two cameras' centres make angles phi about the line between them. Those planes that just touch the
    animal appear in both views at the extremes of phi; a difference d_phi at a distance r from the line, seen at s
    pixels a metre, is a residual of s r d_phi pixels. It sees errors across these planes only.

    Parameters
    ----------
    frames : frames of C boolean images (rows, columns)
    cameras : C cameras
    """
    pairs = list(combinations(range(len(cameras)), 2))
    found: list[FloatArray] = []
    for masks in frames:
        require_fitting(masks, cameras)
        rays = [_extreme_rays(mask, camera) for mask, camera in zip(masks, cameras, strict=True)]
        found.append(np.array([_residual((rays[a], rays[b]), (cameras[a], cameras[b])) for a, b in pairs]))
    if not found or not pairs:
        raise InvalidInputError("A calibration is checked on frames of two or more cameras; there were none.")
    residuals = np.stack(found, axis=1)
    if np.all(np.isnan(residuals)):
        raise InvalidInputError("A calibration is checked on silhouettes; every frame had an empty one in some view.")
    return CalibrationCheck(
        pairs=tuple(
            PairResidual(cameras=(cameras[a].name, cameras[b].name), shift=each[:, 0], growth=each[:, 1])
            for (a, b), each in zip(pairs, residuals, strict=True)
        )
    )


def _extreme_rays(mask: BoolArray, camera: Camera) -> FloatArray:
    """(M, 3) vectors from the camera to the first and last pixel of each row, on lines of sight; none if empty."""
    rows = np.flatnonzero(mask.any(axis=1))
    if not len(rows):
        return np.empty((0, 3))
    left = mask[rows].argmax(axis=1)
    right = mask.shape[1] - 1 - mask[rows, ::-1].argmax(axis=1)
    pixels = np.concatenate([np.stack([left, rows], 1), np.stack([right, rows], 1)]).astype(np.float64)
    rays = camera.rays(pixels)
    return rays.direction if not camera.orthographic else rays.origin - _centre(camera)


def _centre(camera: Camera) -> FloatArray:
    return camera.centre if not camera.orthographic else -_INFINITY * camera.direction


def _residual(rays: tuple[FloatArray, FloatArray], cameras: tuple[Camera, Camera]) -> tuple[float, float]:
    """Shift and growth from the first camera's silhouette to the second's [px]."""
    if not (len(rays[0]) and len(rays[1])):
        return np.nan, np.nan
    start, end = (_centre(camera) for camera in cameras)
    base = (end - start) / np.linalg.norm(end - start)
    ahead = rays[0].mean(axis=0)
    up = ahead - (ahead @ base) * base
    up /= np.linalg.norm(up)
    side = np.cross(base, up)
    first, second = (np.arctan2(each @ side, each @ up) for each in rays)
    point = _between(start, ahead, end, rays[1].mean(axis=0))
    away = point - start
    lever = np.linalg.norm(away - (away @ base) * base) * cameras[1].pixels_per_metre(point[None])[0]
    at_low, at_high = lever * (second.min() - first.min()), lever * (second.max() - first.max())
    return float((at_low + at_high) / 2), float(at_high - at_low)


def _between(a: FloatArray, along_a: FloatArray, b: FloatArray, along_b: FloatArray) -> FloatArray:
    """Point of the first line nearest to the second, (3,) [m]."""
    steps = np.linalg.lstsq(np.stack([along_a, -along_b], axis=1), b - a, rcond=None)[0]
    return np.asarray(a + steps[0] * along_a)

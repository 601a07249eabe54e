"""Silhouettes and grey frames of a parametric fly for any cameras and any motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.model.camera import Camera
from flycontrol.model.pose import Pose
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.kernels.fill import fill_triangles
from flycontrol.vision.mesh import ALL, Part, patch_of, placed

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
GreyArray = NDArray[np.uint8]
Silhouettes = tuple[BoolArray, ...]

BRIGHT, DARK = 200.0, 40.0  #: grey levels of background and fly
_AT_ONCE = 64  #: frames whose vertices are held in memory together


@dataclass(frozen=True, slots=True, kw_only=True)
class Imaging:
    """What stands between a silhouette and what a camera stores."""

    blur: float = 0.0  #: standard deviation of a Gaussian [px]
    noise: float = 0.0  #: standard deviation over the contrast of fly and background
    missing: float = 0.0  #: share of the silhouette that is lost, in patches
    patch: float = 2.0  #: radius of a lost patch [px]

    def __post_init__(self) -> None:
        if not (self.blur >= 0 and self.noise >= 0 and 0 <= self.missing < 1 and self.patch >= 0):
            raise InvalidParameterError(
                f"Imaging needs blur, noise and patch >= 0 and a missing share in 0..1, got {self!r}."
            )


#: A perfect camera.
IDEAL = Imaging()


def render_silhouettes(
    shape: FlyShape, pose: Pose, cameras: Sequence[Camera], *, parts: Sequence[Part] = ALL
) -> Iterator[Silhouettes]:
    """For each instant of a pose one boolean image (rows, columns) a camera; one instant at a time is in memory.

    A pixel belongs to the silhouette if the line of sight of its centre meets the fly.

    Raises
    ------
    InvalidInputError
        If the pose is not finite, or if part of the fly is behind a camera.
    """
    for start in range(0, len(pose), _AT_ONCE):
        piece = pose[start : start + _AT_ONCE]
        if not np.all(np.isfinite(piece.coordinates)):
            raise InvalidInputError("A pose that shall be drawn must be finite; leave out the frames without one.")
        vertices = [(placed(shape, piece, part), patch_of(shape, part).faces) for part in parts]
        for k in range(len(piece)):
            yield tuple(_drawn([(points[k], faces) for points, faces in vertices], camera) for camera in cameras)


def render_frames(silhouettes: Iterator[Silhouettes], imaging: Imaging, seed: int) -> Iterator[tuple[GreyArray, ...]]:
    """Grey frames, dark fly on bright ground, of silhouettes; each frame has its own random numbers."""
    for number, views in enumerate(silhouettes):
        rng = np.random.default_rng([seed, number])
        yield tuple(grey_frame(mask, imaging, rng) for mask in views)


def degraded(silhouettes: Iterator[Silhouettes], imaging: Imaging, seed: int) -> Iterator[Silhouettes]:
    """Silhouettes as half-way thresholds of their grey frames return them."""
    for frames in render_frames(silhouettes, imaging, seed):
        yield tuple(frame < (BRIGHT + DARK) / 2 for frame in frames)


def grey_frame(mask: BoolArray, imaging: Imaging, rng: np.random.Generator) -> GreyArray:
    """(rows, columns) uint8 image of a silhouette."""
    cover = with_missing_patches(mask, imaging, rng).astype(np.float64)
    if imaging.blur > 0:
        cover = gaussian_filter(cover, imaging.blur)
    grey = BRIGHT + (DARK - BRIGHT) * cover
    if imaging.noise > 0:
        grey += rng.normal(0.0, imaging.noise * (BRIGHT - DARK), grey.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def with_missing_patches(mask: BoolArray, imaging: Imaging, rng: np.random.Generator) -> BoolArray:
    """The silhouette without round patches about random pixels of it, until at least the missing share is lost."""
    left = mask.copy()
    v, u = np.nonzero(mask)
    keep = (1 - imaging.missing) * len(v)
    reach = int(imaging.patch)
    rows, columns = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    disc = rows**2 + columns**2 <= imaging.patch**2
    for k in rng.permutation(len(v)) if imaging.missing > 0 else ():
        if np.count_nonzero(left) <= keep:
            break
        near_v, near_u = v[k] + rows[disc], u[k] + columns[disc]
        on = (near_v >= 0) & (near_v < mask.shape[0]) & (near_u >= 0) & (near_u < mask.shape[1])
        left[near_v[on], near_u[on]] = False
    return left


def _drawn(parts: list[tuple[FloatArray, NDArray[np.int64]]], camera: Camera) -> BoolArray:
    image = np.zeros(camera.shape, dtype=np.bool_)
    for points, faces in parts:
        if not len(points):
            continue
        pixels = camera.project(points)
        if not np.all(np.isfinite(pixels)):
            raise InvalidInputError(f"{camera.name}: the fly to be drawn is not in front of the camera.")
        fill_triangles(pixels, faces, image)
    return image

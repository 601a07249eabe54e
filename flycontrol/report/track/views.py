"""What the page shows of a view: a window of its image, and the fly or its hull drawn finely into that window."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera import Camera
from flycontrol.model.pose import Pose
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.footage import FilmedFrame
from flycontrol.vision.mesh import Part, placed
from flycontrol.vision.render import render_silhouettes

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
GreyArray = NDArray[np.uint8]

PARTS: tuple[Part, ...] = ("body", "left", "right")
EMPTY, DUST, ANIMAL, OUTSIDE = 255, 238, 214, 247  #: grey levels of silhouettes, and of what no image shows
_AROUND = 6  #: pixels around the fly
_LARGEST = 1.7  #: of a window that silhouettes widen, over that of the fly alone


@dataclass(frozen=True, slots=True)
class Window:
    """Part of an image: its first column and row, columns and rows [px]; it may reach beyond the image."""

    left: int
    top: int
    width: int
    height: int

    @property
    def edges(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top edge, between pixels."""
        return self.left - 0.5, self.left + self.width - 0.5, self.top + self.height - 0.5, self.top - 0.5


def square_about(middle: FloatArray, side: int) -> Window:
    """Window of equal sides about a pixel (u, v)."""
    left, top = np.floor(middle - side / 2 + 0.5).astype(int)
    return Window(int(left), int(top), side, side)


def largest_side(cameras: tuple[Camera, ...]) -> int:
    """Of a window: twice the largest image, however near to a camera the fly is thought to be [px]."""
    return 2 * max(max(camera.shape) for camera in cameras)


def extent_of_fly(shape: FlyShape, pose: Pose, camera: Camera) -> FloatArray:
    """(2, 2) least and largest u, v of a fly at one instant [px]; those of the image where it is not in front of it."""
    points = np.concatenate([placed(shape, pose, part)[0] for part in PARTS])
    pixels = camera.project(points)
    if not np.all(np.isfinite(pixels)):
        return np.array([[0.0, 0.0], [camera.shape[1] - 1.0, camera.shape[0] - 1.0]])
    return np.stack([pixels.min(axis=0), pixels.max(axis=0)])


def extent_of_mask(mask: BoolArray) -> FloatArray | None:
    """(2, 2) least and largest u, v of a silhouette [px]; None where it is empty."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return None
    return np.array([[columns[0], rows[0]], [columns[-1], rows[-1]]], dtype=np.float64)


def windows(frame: FilmedFrame, cameras: tuple[Camera, ...], shape: FlyShape, pose: Pose | None) -> list[Window]:
    """Windows of one size about fly and silhouette in every view of a frame."""
    extents = [_extent(frame, c, camera, shape, pose) for c, camera in enumerate(cameras)]
    side = int(np.ceil(max(np.max(extent[1] - extent[0]) for extent in extents))) + 2 * _AROUND
    side = min(side, largest_side(cameras))
    return [square_about(extent.mean(axis=0), side) for extent in extents]


def backdrop(frame: FilmedFrame, view: int, window: Window, shape: tuple[int, int]) -> GreyArray:
    """Grey levels of a window: the image as filmed, or the silhouette; what lies outside the image is nearly white."""
    picture = np.full((window.height, window.width), OUTSIDE, dtype=np.uint8)
    if not frame.images:
        return picture
    top, left = max(window.top, 0), max(window.left, 0)
    rows = slice(top, max(min(window.top + window.height, shape[0]), top))
    columns = slice(left, max(min(window.left + window.width, shape[1]), left))
    inside = _levels(frame, view)[rows, columns]
    high, wide = inside.shape
    picture[top - window.top :, left - window.left :][:high, :wide] = inside
    return picture


def part_masks(shape: FlyShape, pose: Pose, camera: Camera, window: Window, zoom: float) -> dict[Part, BoolArray]:
    """Silhouettes of body and wings at one instant in a window, `zoom` points a pixel; none if behind the camera."""
    try:
        return {
            part: seen_in(camera, window, zoom, lambda at, part=part: _drawn(shape, pose, at, part)) for part in PARTS
        }
    except InvalidInputError:
        return {}


def seen_in(camera: Camera, window: Window, zoom: float, draw: Callable[[Camera], BoolArray]) -> BoolArray:
    """What an ideal camera draws, as the camera with its lens shows it in a window, `zoom` points a pixel."""
    high, wide = points_of(window, zoom)
    if camera.distortion is None:
        return draw(_zoomed(camera, window, zoom, (high, wide)))
    v, u = np.mgrid[:high, :wide]
    pixels = np.stack([u.ravel(), v.ravel()], axis=1)
    pixels = (pixels + 0.5) / zoom - 0.5 + np.array([window.left, window.top])
    straight = camera.distortion.undistorted(pixels)
    known = np.all(np.isfinite(straight), axis=1)
    seen = np.zeros(high * wide, dtype=np.bool_)
    if np.any(known):
        seen[known] = _looked_up(straight[known], camera.ideal, zoom, draw)
    return seen.reshape(high, wide)


def points_of(window: Window, zoom: float) -> tuple[int, int]:
    """Rows and columns of a window drawn with `zoom` points a pixel."""
    return round(window.height * zoom), round(window.width * zoom)


def _looked_up(pixels: FloatArray, camera: Camera, zoom: float, draw: Callable[[Camera], BoolArray]) -> BoolArray:
    """(N,) what is drawn at pixels (N, 2) of a camera without a lens."""
    low, most = np.floor(pixels.min(axis=0)).astype(int) - 1, np.ceil(pixels.max(axis=0)).astype(int) + 2
    around = Window(int(low[0]), int(low[1]), int(most[0] - low[0]), int(most[1] - low[1]))
    drawn = draw(_zoomed(camera, around, zoom, points_of(around, zoom)))
    u, v = np.floor((pixels - low + 0.5) * zoom).astype(int).T
    return np.asarray(drawn[np.minimum(v, drawn.shape[0] - 1), np.minimum(u, drawn.shape[1] - 1)])


def _extent(frame: FilmedFrame, view: int, camera: Camera, shape: FlyShape, pose: Pose | None) -> FloatArray:
    mask = extent_of_mask(frame.silhouettes[view].mask) if frame.silhouettes else None
    if pose is None:
        rows, columns = camera.shape
        return np.array([[0.0, 0.0], [columns - 1.0, rows - 1.0]]) if mask is None else mask
    fly = extent_of_fly(shape, pose, camera)
    if mask is None:
        return fly
    both = np.stack([np.minimum(fly[0], mask[0]), np.maximum(fly[1], mask[1])])
    size = np.max(fly[1] - fly[0])
    return both if np.max(both[1] - both[0]) <= _LARGEST * size else fly


def _levels(frame: FilmedFrame, view: int) -> GreyArray:
    image = np.asarray(frame.images[view])
    if image.dtype == np.bool_:
        silhouette = frame.silhouettes[view]
        return np.where(silhouette.mask, ANIMAL, np.where(silhouette.raw, DUST, EMPTY)).astype(np.uint8)
    if image.dtype == np.uint8:
        return np.asarray(image, dtype=np.uint8)
    dark, bright = np.percentile(image, [0.1, 99.9])
    return np.clip(255 * (image - dark) / max(bright - dark, 1e-300), 0, 255).astype(np.uint8)


def _drawn(shape: FlyShape, pose: Pose, camera: Camera, part: Part) -> BoolArray:
    return next(iter(render_silhouettes(shape, pose, [camera], parts=[part])))[0]


def _zoomed(camera: Camera, window: Window, zoom: float, shape: tuple[int, int]) -> Camera:
    """u' = zoom (u - left + 1/2) - 1/2, and v likewise."""
    shift = [zoom * (0.5 - window.left) - 0.5, zoom * (0.5 - window.top) - 0.5]
    Z = np.array([[zoom, 0.0, shift[0]], [0.0, zoom, shift[1]], [0.0, 0.0, 1.0]])
    return Camera(matrix=Z @ camera.matrix, shape=shape, name=camera.name)

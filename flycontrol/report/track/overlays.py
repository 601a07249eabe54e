"""Frames looked at: windows of their images with the fitted fly and the hull drawn finely into them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera import Camera
from flycontrol.model.pose import Pose
from flycontrol.report.track.views import Window, backdrop, part_masks, seen_in, windows
from flycontrol.units import mm
from flycontrol.vision.first_pose import fine_hull
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.footage import FilmedFrame
from flycontrol.vision.hull import VisualHull, footprint
from flycontrol.vision.mesh import Part
from flycontrol.vision.tracked_flight import TrackedFlight

BoolArray = NDArray[np.bool_]

_ZOOM = 3.0  #: points a pixel of what is drawn


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ViewOverlay:
    """One camera's window."""

    name: str
    window: Window
    zoom: float  #: points of the masks a pixel
    image: NDArray[np.uint8]  #: (rows, columns) of the window
    parts: dict[Part, BoolArray]  #: of the fitted fly, (zoom rows, zoom columns)
    hull: BoolArray | None  #: likewise
    pixels_per_mm: float | None  #: at the fly
    note: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrameOverlay:
    """All views of one frame."""

    frame: int
    views: tuple[ViewOverlay, ...]


def frame_overlay_of(flight: TrackedFlight, frame: FilmedFrame, k: int) -> FrameOverlay:
    """Frame k of a flight as filmed, with what was found in it."""
    pose = pose_at(flight, k)
    shape = flight.fly.shape
    hull = hull_of(frame, flight.cameras, shape)
    around = windows(frame, flight.cameras, shape, pose)
    return FrameOverlay(
        frame=k,
        views=tuple(_view(flight, frame, c, window, pose, hull) for c, window in enumerate(around)),
    )


def pose_at(flight: TrackedFlight, k: int) -> Pose | None:
    """Where the fly was found, or expected, in frame k; None where it was lost."""
    pose = flight.track.pose[k : k + 1]
    return pose if np.all(np.isfinite(pose.coordinates)) else None


def hull_of(frame: FilmedFrame, cameras: tuple[Camera, ...], shape: FlyShape) -> VisualHull | None:
    """The hull that a frame is dissected at; None where there is none."""
    if not frame.silhouettes:
        return None
    try:
        masks = [silhouette.mask for silhouette in frame.silhouettes]
        hull = fine_hull(masks, cameras, fit_shape(shape), compared=True)
    except InvalidInputError:
        return None
    return hull if len(hull) else None


def _view(
    flight: TrackedFlight, frame: FilmedFrame, c: int, window: Window, pose: Pose | None, hull: VisualHull | None
) -> ViewOverlay:
    camera = flight.cameras[c]
    scale = None if pose is None else float(camera.pixels_per_metre(pose.position_W)[0]) * mm
    shadow = None
    if hull is not None:
        shadow = seen_in(camera, window, _ZOOM, lambda at: footprint(hull.indices, hull.size, at))
    return ViewOverlay(
        name=camera.name,
        window=window,
        zoom=_ZOOM,
        image=backdrop(frame, c, window, camera.shape),
        parts={} if pose is None else part_masks(flight.fly.shape, pose, camera, window, _ZOOM),
        hull=shadow,
        pixels_per_mm=scale,
        note=_note(frame, c),
    )


def _note(frame: FilmedFrame, c: int) -> str:
    if not frame.images:
        return "no image"
    return "" if frame.silhouettes[c].mask.any() else "empty silhouette"

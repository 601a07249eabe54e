"""Pictures of a dissected hull from two sides: voxels as shaded surfaces, coloured by the part that they belong to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera import Camera
from flycontrol.units import mm
from flycontrol.vision.dissection import BODY, LEFT, REST, RIGHT, Dissection, dissect
from flycontrol.vision.first_pose import Masks, fine_hull
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.stance import Stance

FloatArray = NDArray[np.float64]

FILLS = {BODY: "#9a9a9a", LEFT: "#6fa8d6", RIGHT: "#f0b45c", REST: "#dedede"}
_FINE = 4  #: points of the picture along a voxel
_LIGHT = np.array([-0.35, 0.45, 0.85])  #: from where it comes: right, up, to the viewer
_DIM = 0.55  #: brightness in the shade
_SMOOTH = 1.1  #: voxels over which the surface is evened before it is lit


class Side(NamedTuple):
    """A direction to look from: what points to the right, upward and to the viewer, body axes."""

    name: str
    across: tuple[float, float, float]
    up: tuple[float, float, float]
    near: tuple[float, float, float]
    labels: tuple[str, str]


SIDES = (
    Side("from above its back", (0, 1, 0), (1, 0, 0), (0, 0, -1), ("to the right [mm]", "ahead [mm]")),
    Side("from its right", (1, 0, 0), (0, 0, -1), (0, 1, 0), ("ahead [mm]", "towards its back [mm]")),
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HullPicture:
    """A hull seen from one side, and the outlines of the fitted fly."""

    side: Side
    colours: FloatArray  #: (rows, columns, 4), transparent where no voxel is
    extent: tuple[float, float, float, float]  #: left, right, bottom, top edge of the picture [mm]
    wires: dict[str, list[FloatArray]]  #: lines (M, 2) of body, left, right [mm]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeenHull:
    """A hull from all sides, and what it consists of."""

    frame: int
    pictures: tuple[HullPicture, ...]
    voxels: dict[int, int]  #: how many by label
    size: float  #: edge of a voxel [m]
    complete: bool  #: body and both wings were found


def seen_hull(
    frame: int, masks: Masks, cameras: tuple[Camera, ...], shape: FlyShape, stance: Stance
) -> SeenHull | None:
    """The hull of one frame, taken apart as the tracker does; None where the silhouettes have none."""
    try:
        hull = fine_hull(masks, cameras, fit_shape(shape))
    except InvalidInputError:
        return None
    if not len(hull):
        return None
    parts = dissect(hull, stance, shape)
    counts = np.bincount(parts.labels, minlength=4)
    return SeenHull(
        frame=frame,
        pictures=tuple(_picture(parts, stance, shape, side) for side in SIDES),
        voxels={label: int(counts[label]) for label in (BODY, LEFT, RIGHT, REST)},
        size=hull.size,
        complete=parts.complete,
    )


def _picture(parts: Dissection, stance: Stance, shape: FlyShape, side: Side) -> HullPicture:
    in_B = (parts.hull.centres - stance.position_W) @ stance.body_axes_W
    seen = in_B @ np.array([side.across, side.up, side.near]).T / (parts.hull.size / _FINE)
    low = np.floor(seen[:, :2].min(axis=0)).astype(int) - 2 * _FINE
    high = np.ceil(seen[:, :2].max(axis=0)).astype(int) + 2 * _FINE
    depth, label = _nearest(seen, parts.labels, low, high - low + 1)
    edges = np.array([low[0] - 0.5, high[0] + 0.5, low[1] - 0.5, high[1] + 0.5]) * parts.hull.size / _FINE / mm
    return HullPicture(
        side=side,
        colours=_shaded(depth, label),
        extent=(float(edges[0]), float(edges[1]), float(edges[2]), float(edges[3])),
        wires=_wires(stance, shape, np.array([side.across, side.up]).T / mm),
    )


def _nearest(
    seen: FloatArray, labels: NDArray[np.int8], low: NDArray[np.int_], size: NDArray[np.int_]
) -> tuple[FloatArray, NDArray[np.int8]]:
    """Depth and label of what is nearest to the viewer, bottom row first; voxels are drawn as balls."""
    radius = 0.8 * _FINE
    reach = int(radius)
    b, a = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    on = a**2 + b**2 <= radius**2
    a, b = a[on], b[on]
    bulge = np.sqrt(radius**2 - a**2 - b**2)
    place = np.rint(seen[:, :2]).astype(int) - low
    depths = (seen[:, 2:] + bulge).ravel()
    at = ((place[:, 1:] + b) * size[0] + place[:, :1] + a).ravel()
    order = np.argsort(depths, kind="stable")
    depth, label = np.full(size[0] * size[1], np.nan), np.zeros(size[0] * size[1], np.int8)
    depth[at[order]] = depths[order]  # of several the last one stays: the nearest
    label[at[order]] = np.repeat(labels, len(a))[order]
    return depth.reshape(size[1], size[0]), label.reshape(size[1], size[0])


def _shaded(depth: FloatArray, label: NDArray[np.int8]) -> FloatArray:
    """Colours (rows, columns, 4) of a surface under a light, bottom row first."""
    here = np.isfinite(depth)
    flat = np.where(here, depth, 0.0)
    weight = gaussian_filter(here.astype(np.float64), _SMOOTH * _FINE)
    smooth = gaussian_filter(flat, _SMOOTH * _FINE) / np.maximum(weight, 1e-9)
    up, across = np.gradient(np.where(here, smooth, 0.0))
    steep = np.sqrt(1 + across**2 + up**2)
    lit = (-across * _LIGHT[0] - up * _LIGHT[1] + _LIGHT[2]) / steep / np.linalg.norm(_LIGHT)
    brightness = _DIM + (1 - _DIM) * np.clip(lit, 0, 1)
    colours = np.zeros((*depth.shape, 4))
    for part, fill in FILLS.items():
        mine = here & (label == part)
        colours[mine, :3] = np.array(to_rgb(fill)) * brightness[mine, None] * 1.08
    colours[here, 3] = 1.0
    return np.clip(colours, 0, 1)


def _wires(stance: Stance, shape: FlyShape, view: FloatArray) -> dict[str, list[FloatArray]]:
    """Rings and outline of the body, edges and ribs of the wings, (M, 2) each; `view` (3, 2) from body axes."""
    x, r = shape.profile.T
    turn = np.linspace(0, 2 * np.pi, 33)
    rings = [
        np.stack([np.full_like(turn, x[k]), r[k] * np.cos(turn), r[k] * np.sin(turn)], axis=1)
        for k in range(4, len(x) - 3, 6)
    ]
    along = [np.stack([x, r * np.cos(angle), r * np.sin(angle)], axis=1) for angle in np.arange(4) * np.pi / 2]
    wires = {"body": [line @ view for line in (*rings, *along)]}
    span, leading, trailing = shape.wing.T
    edge = np.stack([np.concatenate([span, span[::-1]]), np.concatenate([leading, trailing[::-1]])], axis=1)
    ribs = [np.array([[span[k], leading[k]], [span[k], trailing[k]]]) for k in range(4, len(span) - 2, 4)]
    for number, name in enumerate(("left", "right")):
        axes, base = stance.wings_B[number][:, :2], stance.bases_B[number]
        wires[name] = [(base + line @ axes.T) @ view for line in (edge, *ribs)]
    return wires

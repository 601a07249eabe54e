"""A body found in a hull: where in it, and along which line, there is room for one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from flycontrol.units import deg
from flycontrol.vision.fit_shape import FitShape
from flycontrol.vision.hull import VisualHull

FloatArray = NDArray[np.float64]

_THICK = 0.6  #: of the greatest depth inside the hull: a body's middle is among deeper voxels
_PLACES, _WAYS = 150, 300  #: that are tried: middles, and directions some 13 deg apart
_EVERY = 2  #: of the spheres that make up a body
_APART = 25 * deg  #: nearer lines are one
_NEARLY = 0.1  #: of a body, by which another line may have less room than the best and still be the right one (C)
_MOST = 6  #: lines, each end of a body counted


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BodyLine:
    """A line along which a body may lie."""

    middle: FloatArray  #: (3,) the body's reference point [m]
    forward: FloatArray  #: (3,) towards the head
    room: float  #: for how much of the body, 1 for all of it


def body_lines(hull: VisualHull, shape: FitShape) -> list[BodyLine]:
    """The lines with most room for a body, best first: mean over its spheres of min(depth / radius, 1), by radius.

    A hull's long axis is no guide: where wings lie beside the body or cross it, silhouettes leave room that is longer.

    Parameters
    ----------
    hull : at a few pixels to the voxel; not empty
    shape : of the fly
    """
    low = hull.indices.min(axis=0) - 1
    inside = np.zeros(hull.indices.max(axis=0) - low + 2, dtype=np.bool_)
    inside[tuple((hull.indices - low).T)] = True
    depth = np.asarray(distance_transform_edt(inside), dtype=np.float64) * hull.size
    own = depth[tuple((hull.indices - low).T)]
    middles = hull.centres[own >= _THICK * np.percentile(own, 99.5)]
    middles = middles[:: max(len(middles) // _PLACES, 1)]
    ways = _directions()
    spheres = shape.spheres[shape.spheres[:, 1] == 0][::_EVERY]
    centres = middles[:, None, None] + ways[None, :, None] * spheres[None, None, :, :1]
    voxel = np.floor(centres / hull.size).astype(np.int64) - low
    within = np.all((voxel >= 0) & (voxel < depth.shape), axis=-1)
    i, j, k = np.moveaxis(np.where(within[..., None], voxel, 0), -1, 0)
    radius = spheres[:, 3]
    room = np.minimum(np.where(within, depth[i, j, k], 0.0) / radius, 1.0) @ radius / radius.sum()
    return _best(middles[np.argmax(room, axis=0)], ways, np.max(room, axis=0))


def _best(middles: FloatArray, ways: FloatArray, room: FloatArray) -> list[BodyLine]:
    kept: list[int] = []
    for k in np.argsort(-room):
        if room[k] < room[kept[0] if kept else k] - _NEARLY or len(kept) == _MOST:
            break
        if all(ways[k] @ ways[other] < np.cos(_APART) for other in kept):
            kept.append(int(k))
    return [BodyLine(middle=middles[k], forward=ways[k], room=float(room[k])) for k in kept]


def _directions() -> FloatArray:
    """(_WAYS, 3) unit vectors about evenly over the sphere, by the golden angle."""
    k = np.arange(_WAYS) + 0.5
    z, turn = 1 - 2 * k / _WAYS, np.pi * (1 + np.sqrt(5)) * k
    return np.stack([np.cos(turn) * np.sqrt(1 - z**2), np.sin(turn) * np.sqrt(1 - z**2), z], axis=1)

"""A visual hull taken apart into body, left and right wing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.hull import VisualHull
from flycontrol.vision.stance import Stance

FloatArray = NDArray[np.float64]
LabelArray = NDArray[np.int8]

REST, BODY, LEFT, RIGHT = 0, 1, 2, 3  #: labels of voxels; the rest are legs and what silhouettes cannot deny
#: A voxel farther than this from every part is part of none, in wing lengths (C)
_REACH = 0.1
#: A wing of fewer voxels than this share of its area's worth has not been found (C)
_FEWEST = 0.2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Dissection:
    """Whose the voxels of a hull are."""

    hull: VisualHull
    labels: LabelArray  #: (N,) REST, BODY, LEFT or RIGHT
    found: tuple[bool, bool, bool]  #: whether body, left and right wing have voxels enough

    def part(self, label: int) -> FloatArray:
        """(M, 3) centres of one part's voxels [m]."""
        return self.hull.centres[self.labels == label]

    @property
    def complete(self) -> bool:
        """Whether all three parts were found."""
        return all(self.found)


def dissect(hull: VisualHull, seed: Stance, shape: FlyShape) -> Dissection:
    """Every voxel goes to the nearest of body, left and right wing where these are expected.

    One round of a clustering whose centres are not points but a body of revolution and two plates with the outline of
    the wings, so that clusters that touch are parted where the fly's size says so. Voxels far from all of them are
    legs, or ghosts: places that no silhouette denies.

    Parameters
    ----------
    hull : its voxels
    seed : where the parts are expected, from the instant before
    shape : sizes of the fly
    """
    points = hull.centres
    in_B = (points - seed.position_W) @ seed.body_axes_W
    away = np.stack([
        _from_body(in_B, shape), *(_from_wing((in_B - seed.bases_B[k]) @ seed.wings_B[k], shape) for k in (0, 1))
    ])  # fmt: skip
    near = np.argmin(away, axis=0)
    labels = np.where(away[near, np.arange(len(points))] <= _REACH * _length(shape), near + 1, REST).astype(np.int8)
    counts = np.bincount(labels, minlength=4)
    wing, body = _area(shape) / hull.size**2, shape.body_volume / hull.size**3
    found = (
        bool(counts[BODY] >= 0.5 * body),
        bool(counts[LEFT] >= _FEWEST * wing),
        bool(counts[RIGHT] >= _FEWEST * wing),
    )
    return Dissection(hull=hull, labels=labels, found=found)


def _from_body(in_B: FloatArray, shape: FlyShape) -> FloatArray:
    """About the distance from points (N, 3) in body axes to the body, < 0 inside [m]."""
    x, r = shape.profile.T
    along = np.clip(in_B[:, 0], x[0], x[-1])
    beside = np.hypot(in_B[:, 1], in_B[:, 2]) - np.interp(along, x, r)
    beyond = in_B[:, 0] - along
    return np.where(beyond == 0, beside, np.hypot(np.maximum(beside, 0), beyond))


def _from_wing(in_wing: FloatArray, shape: FlyShape) -> FloatArray:
    """Distance from points (N, 3) along span, chord and normal to a wing [m], about so beside its edges."""
    span, leading, trailing = shape.wing.T
    s = np.clip(in_wing[:, 0], span[0], span[-1])
    c = np.clip(in_wing[:, 1], np.interp(s, span, trailing), np.interp(s, span, leading))
    return np.sqrt((in_wing[:, 0] - s) ** 2 + (in_wing[:, 1] - c) ** 2 + in_wing[:, 2] ** 2)


def _length(shape: FlyShape) -> float:
    return float(shape.wing[-1, 0])


def _area(shape: FlyShape) -> float:
    return float(np.trapezoid(shape.wing[:, 1] - shape.wing[:, 2], shape.wing[:, 0]))

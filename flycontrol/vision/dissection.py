"""A visual hull taken apart into body, left and right wing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.hull import VisualHull
from flycontrol.vision.kernels.parting import claim_for_body, claim_for_wing, gather
from flycontrol.vision.reading.moments import Moments, moments_of_voxels
from flycontrol.vision.stance import Stance

FloatArray = NDArray[np.float64]
LabelArray = NDArray[np.int8]
IntArray = NDArray[np.int64]

REST, BODY, LEFT, RIGHT = 0, 1, 2, 3  #: labels of voxels; the rest are legs and what silhouettes cannot deny
#: A voxel farther than this from every part is part of none, in wing lengths (C)
_REACH = 0.1
#: A wing of fewer voxels than this share of its area's worth has not been found (C)
_FEWEST = 0.2
_ORIGIN = np.zeros(3)
_BINS = 16  #: of a table to each of its rows: a place is then seldom looked for beyond the first row tried


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Dissection:
    """Whose the voxels of a hull are."""

    hull: VisualHull
    labels: LabelArray  #: (N,) REST, BODY, LEFT or RIGHT
    counts: IntArray  #: (4,) voxels of each label
    found: tuple[bool, bool, bool]  #: whether body, left and right wing have voxels enough

    def part(self, label: int) -> FloatArray:
        """(M, 3) centres of one part's voxels [m]."""
        return self.beyond(label, _ORIGIN, _ORIGIN, -np.inf)

    def beyond(self, label: int, base: FloatArray, along: FloatArray, least: float) -> FloatArray:
        """(M, 3) centres of one part's voxels that lie beyond `least` [m] from a base (3,) along a way (3,).

        They are counted from the base [m].
        """
        hull = self.hull
        return gather(hull.indices, self.labels, label, self.counts[label], hull.size, base, along, least)

    def moments(self, label: int) -> Moments:
        """Of the centres of one part's voxels."""
        return moments_of_voxels(self.hull.indices, self.labels, label, self.hull.size)

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
    own, voxels = _tables(shape), hull.indices
    away, labels = np.empty(len(hull)), np.empty(len(hull), np.int8)
    body, wings = _places(seed, hull.size)
    claim_for_body(voxels, body, own.body, own.body_starts, own.widest, own.reach, away, labels)
    for label, wing in zip((LEFT, RIGHT), wings, strict=True):
        claim_for_wing(voxels, wing, own.wing, own.wing_starts, label, away, labels)
    counts = np.array([np.count_nonzero(labels == label) for label in (REST, BODY, LEFT, RIGHT)])
    wing, body = own.wing_area / hull.size**2, shape.body_volume / hull.size**3
    found = (
        bool(counts[BODY] >= 0.5 * body),
        bool(counts[LEFT] >= _FEWEST * wing),
        bool(counts[RIGHT] >= _FEWEST * wing),
    )
    return Dissection(hull=hull, labels=labels, counts=counts, found=found)


def _places(stance: Stance, size: float) -> tuple[FloatArray, FloatArray]:
    """From voxels (i, j, k, 1) to body axes (3, 4), and to span, chord and normal of either wing (2, 3, 4) [m]."""
    to_world = np.hstack([np.eye(3) * size, np.full((3, 1), size / 2)])
    to_world[:, 3] -= stance.position_W
    to_body = stance.body_axes_W.T @ to_world
    from_bases = np.repeat(to_body[None], 2, axis=0)
    from_bases[:, :, 3] -= stance.bases_B
    return to_body, np.swapaxes(stance.wings_B, 1, 2) @ from_bases


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Tables:
    """A fly's profile and outline, line by line, as the kernel looks them up."""

    body: FloatArray  #: (M, 3) place along the body, radius, its slope
    body_starts: IntArray  #: (B,) the row that each of equal bins begins in
    widest: float  #: [m]
    wing: FloatArray  #: (S, 5) place along the span, leading and trailing edge, their slopes
    wing_starts: IntArray
    wing_area: float  #: [m^2]
    reach: float  #: [m]


@lru_cache(maxsize=16)
def _tables(shape: FlyShape) -> _Tables:
    span, leading, trailing = shape.wing.T
    body, wing = _with_slopes(shape.profile), _with_slopes(shape.wing)
    return _Tables(
        body=body,
        body_starts=_starts(body),
        widest=float(shape.profile[:, 1].max()),
        wing=wing,
        wing_starts=_starts(wing),
        wing_area=float(np.trapezoid(leading - trailing, span)),
        reach=_REACH * float(span[-1]),
    )


def _with_slopes(rows: FloatArray) -> FloatArray:
    slopes = np.diff(rows[:, 1:], axis=0) / np.diff(rows[:, :1], axis=0)
    return np.ascontiguousarray(np.hstack([rows, np.vstack([slopes, slopes[-1]])]))


def _starts(rows: FloatArray) -> IntArray:
    """(B,) the last row whose place is not beyond the beginning of each of equal bins."""
    begin = np.linspace(rows[0, 0], rows[-1, 0], _BINS * len(rows), endpoint=False)
    return np.maximum(np.searchsorted(rows[:, 0], begin, side="right") - 1, 0).astype(np.int64)

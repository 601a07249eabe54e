"""The visual hull: the largest volume that no silhouette contradicts, as voxels of a lattice fixed in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.camera import Camera
from flycontrol.vision.box import Box, box_of_views
from flycontrol.vision.kernels.carve import coarse_to_fine, summed_areas
from flycontrol.vision.kernels.footprint import NEAREST, UNDER, paint
from flycontrol.vision.kernels.planes import meet_of_planes
from flycontrol.vision.views import MASK, SLACK, BoolArray, Views, views_of

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int32]

#: How far a projected voxel may drift over the box for a view to count as looking along the lattice [px]
_ALONG = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerance:
    """What a silhouette may miss: in up to `views` views a voxel may lie off it, but by no more than `slack` [px].

    slack = 0 is the visual hull itself. views = 1 forgives one view a hole, a folded wing or a wing seen on edge;
    views = the number of cameras widens every silhouette by the slack.
    """

    slack: float = 0.0  #: from a pixel's centre to the nearest one on the silhouette [px]
    views: int = 0

    def __post_init__(self) -> None:
        if not (self.slack >= 0 and self.views >= 0):
            raise InvalidParameterError(f"Tolerance.slack [px] and .views must be >= 0, got {self!r}.")


#: No pixel is missing.
EXACT = Tolerance()


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewConsistency:
    """How a hull's projection and one silhouette agree, in pixels."""

    camera: str
    covered: int  #: of the silhouette, under some voxel
    uncovered: int  #: of the silhouette, under none: another view contradicts them
    beyond: int  #: nearest to projected voxels but off the silhouette: what the tolerance forgave
    touches_edge: bool  #: the silhouette reaches the border of the image: part of the animal may be unseen

    @property
    def coverage(self) -> float:
        """Share of the silhouette that is covered."""
        return self.covered / (self.covered + self.uncovered)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VisualHull:
    """Voxels (i, j, k) centred at (i + 1/2, j + 1/2, k + 1/2) sizes from the world's origin, in no given order."""

    indices: IndexArray  #: (N, 3)
    size: float  #: edge of a voxel [m]
    views: tuple[ViewConsistency, ...]  #: none where voxels and silhouettes were not compared

    def __post_init__(self) -> None:
        self.indices.setflags(write=False)

    def __len__(self) -> int:
        return len(self.indices)

    @property
    def centres(self) -> FloatArray:
        """(N, 3) [m]."""
        return np.asarray((self.indices + 0.5) * self.size, dtype=np.float64)

    @property
    def volume(self) -> float:
        """[m^3]."""
        return len(self.indices) * self.size**3


def visual_hull(
    masks: Sequence[BoolArray] | BoolArray,
    cameras: Sequence[Camera],
    size: float,
    *,
    tolerance: Tolerance = EXACT,
    box: Box | None = None,
    compared: bool = True,
) -> VisualHull:
    """All voxels whose centres project onto every silhouette, and how well they cover the silhouettes.

    Empty if the silhouettes contradict each other everywhere. What lies outside an image counts as off its silhouette.

    Parameters
    ----------
    masks : C boolean images (rows, columns), or (C, rows, columns)
    cameras : C cameras
    size : edge of a voxel; a pixel's width at the animal is a good one [m]
    tolerance : what silhouettes may miss
    box : where to look; found from the silhouettes if not given
    compared : whether to look how well the voxels cover the silhouettes, which takes longer than to carve them

    Raises
    ------
    InvalidInputError
        If masks and cameras do not fit, a silhouette is empty, or the views do not enclose the animal.
    """
    if not (size > 0 and np.isfinite(size)):
        raise InvalidParameterError(f"The voxels' size must be finite and > 0 m, got {size!r}.")
    views = views_of(masks, cameras, tolerance.slack if tolerance.views else 0.0)
    indices = carve(views, size, tolerance, box or box_of_views(views, size))
    return VisualHull(indices=indices, size=size, views=consistency(indices, size, views) if compared else ())


def carve(views: Views, size: float, tolerance: Tolerance, box: Box) -> IndexArray:
    """(N, 3) indices of the voxels of a box that stay; orthographic cameras along the lattice go a faster way."""
    P = np.stack([lattice_matrix(camera, size) for camera in views.cameras])
    low, high = np.array(box.low, dtype=np.int64), np.array(box.high, dtype=np.int64)
    if not all(box.shape):
        return np.empty((0, 3), np.int32)
    least = _single_grade(tolerance, len(P))
    axes = [_lattice_axes(matrix, box) for matrix in P]
    if least is not None and all(axis is not None for axis in axes):
        xy, xz, yz = _planes(views.grades >= least, views.corner, P, [a for a in axes if a is not None], box)
        return meet_of_planes(xy, xz, yz, low)
    lenient = min(tolerance.views, len(P))
    return coarse_to_fine(P, views.grades, summed_areas(views.grades), views.corner, lenient, low, high)


def consistency(indices: IndexArray, size: float, views: Views) -> tuple[ViewConsistency, ...]:
    """How voxels (N, 3) cover each silhouette."""
    found: list[ViewConsistency] = []
    for camera, mask in zip(views.cameras, views.masks, strict=True):
        marks = _marks(indices, size, camera)
        under = (marks & UNDER) > 0
        border = mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any()
        found.append(
            ViewConsistency(
                camera=camera.name,
                covered=int(np.count_nonzero(mask & under)),
                uncovered=int(np.count_nonzero(mask & ~under)),
                beyond=int(np.count_nonzero((marks >= NEAREST) & ~mask)),
                touches_edge=bool(border),
            )
        )
    return tuple(found)


def footprint(indices: IndexArray, size: float, camera: Camera) -> BoolArray:
    """(rows, columns) pixels of the camera without its lens that voxels (N, 3) of an edge of `size` [m] cover."""
    return (_marks(indices, size, camera) & UNDER) > 0


def _marks(indices: IndexArray, size: float, camera: Camera) -> NDArray[np.uint8]:
    image = np.zeros(camera.shape, dtype=np.uint8)
    paint(lattice_matrix(camera, size), indices, image)
    return image


def lattice_matrix(camera: Camera, size: float) -> FloatArray:
    """P' = P diag(h, h, h, 1) shifted by half a voxel: (3, 4) from indices (i, j, k, 1) to homogeneous pixels."""
    P = camera.matrix * np.array([size, size, size, 1.0])
    P[:, 3] += 0.5 * P[:, :3].sum(axis=1)
    return np.ascontiguousarray(P)


def _single_grade(tolerance: Tolerance, cameras: int) -> int | None:
    """The grade that every view must give, where the rule is as simple as that."""
    if tolerance.views == 0 or tolerance.slack == 0:
        return MASK
    return SLACK if tolerance.views >= cameras else None


def _lattice_axes(P: FloatArray, box: Box) -> tuple[int, int] | None:
    """Lattice axes along which u and v run, each alone; None for any other view."""
    if np.any(P[2, :3] != 0):
        return None
    drift = np.abs(P[:2, :3]) * (np.abs([box.low, box.high]).max(axis=0) + 1)
    along = np.argmax(drift, axis=1)
    others = drift.copy()
    others[[0, 1], along] = 0
    if along[0] == along[1] or others.max() > _ALONG:
        return None
    return int(along[0]), int(along[1])


def _planes(
    allowed: BoolArray, corner: FloatArray, P: FloatArray, axes: Sequence[tuple[int, int]], box: Box
) -> tuple[BoolArray, BoolArray, BoolArray]:
    """What the views allow, on the lattice's planes xy, xz and yz; a plane that no view looks onto allows all."""
    shape = box.shape
    planes = {pair: np.ones((shape[pair[0]], shape[pair[1]]), np.bool_) for pair in ((0, 1), (0, 2), (1, 2))}
    for image, (u0, v0), matrix, (along_u, along_v) in zip(allowed, corner, P, axes, strict=True):
        columns = _nearest(matrix[0], along_u, u0, box)
        rows = _nearest(matrix[1], along_v, v0, box)
        framed = np.zeros((image.shape[0] + 2, image.shape[1] + 2), np.bool_)
        framed[1:-1, 1:-1] = image
        rows, columns = np.clip(rows + 1, 0, len(framed) - 1), np.clip(columns + 1, 0, framed.shape[1] - 1)
        seen = framed[rows[:, None], columns[None, :]]
        pair = (min(along_u, along_v), max(along_u, along_v))
        planes[pair] &= seen if along_v < along_u else seen.T
    return planes[0, 1], planes[0, 2], planes[1, 2]


def _nearest(row: FloatArray, axis: int, first: float, box: Box) -> NDArray[np.intp]:
    """Pixels nearest to the voxels along an axis, counted from the crop's first one."""
    along = np.arange(box.low[axis], box.high[axis])
    return np.floor(row[axis] * along + row[3] - first + 0.5).astype(np.intp)

"""The first pose of a fly in a recording: the best of those found in some of its first frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera import Camera
from flycontrol.vision.fit_shape import FitShape
from flycontrol.vision.hull import Tolerance, VisualHull, visual_hull
from flycontrol.vision.search.acquire import acquire
from flycontrol.vision.silhouette_fit import SilhouetteFit
from flycontrol.vision.soft_silhouette import border_distance
from flycontrol.vision.views import BoolArray, views_of

Masks = Sequence[BoolArray]

MARGIN = 20  #: pixels around a silhouette in which the fly may be looked for
_VOXELS = 56  #: along a wing: of one and a half pixels at 35 px/mm
_SLACK = 1.0  #: of the silhouettes, so that a wing on edge is not lost between voxels' centres [px]
_EVERY = 6  #: frames from one try to the next
#: A pose this good is taken at once: intersection over union, and precision, in the mean of the views (C)
_GOOD_OVERLAP, _GOOD_PRECISION = 0.85, 0.96


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FirstPose:
    """Where to start."""

    fit: SilhouetteFit
    frame: int


def first_pose(
    first: Sequence[Masks], cameras: Sequence[Camera], shape: FitShape, stroke_plane_angle: float
) -> FirstPose:
    """The best of the poses found in some of the first frames.

    Raises
    ------
    InvalidInputError
        If none of them holds a fly.
    """
    best: FirstPose | None = None
    rank = (np.inf, np.inf)
    for k in range(0, len(first), _EVERY):
        try:
            border = border_distance(views_of(first[k], cameras), MARGIN)
            found = acquire(fine_hull(first[k], cameras, shape), border, shape, stroke_plane_angle)
        except InvalidInputError:
            continue
        seen = found.fit.agreement
        here = (float(found.rank[0]), -float(np.mean(seen.overlap)))
        if here < rank:
            best, rank = FirstPose(fit=found.fit, frame=k), here
        if not rank[0] and np.mean(seen.overlap) > _GOOD_OVERLAP and np.mean(seen.precision) > _GOOD_PRECISION:
            break
    if best is None:
        raise InvalidInputError(
            f"No fly was found in the first {len(first)} frames: in each of them some silhouette is empty, or the "
            "silhouettes contradict one another; check the threshold, and the order and the calibration of the cameras."
        )
    return best


def fine_hull(masks: Masks, cameras: Sequence[Camera], shape: FitShape, *, compared: bool = False) -> VisualHull:
    """The hull at which a fly is dissected; compared with its silhouettes only if asked for."""
    tolerance = Tolerance(slack=_SLACK, views=len(cameras))
    return visual_hull(masks, cameras, shape.wing_length / _VOXELS, tolerance=tolerance, compared=compared)

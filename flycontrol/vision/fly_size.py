"""A fly as large as the first frames of a film say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.camera import Camera
from flycontrol.model.pose import Pose
from flycontrol.units import deg
from flycontrol.vision.first_pose import MARGIN, fine_hull
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.follower import Fly
from flycontrol.vision.render import render_silhouettes
from flycontrol.vision.sighting import Sighting
from flycontrol.vision.size_fit import Sizes, fitted_sizes, resized
from flycontrol.vision.soft_silhouette import BorderDistance, border_distance
from flycontrol.vision.stance import Stance
from flycontrol.vision.track import Pursuit
from flycontrol.vision.tracked_frame import TrackedFrame
from flycontrol.vision.views import views_of

_WANTED, _FEWEST = 8, 4  #: instants to which sizes are fitted
_NEAR = 1.15  #: a fly as large as that is followed with the sizes given
_HEADINGS, _STROKES, _PITCHES = (
    np.array([0, 90, 180, 270]) * deg,
    np.array([-60, 0, 60]) * deg,
    np.array([45, 135]) * deg,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class SizedFly:
    """A fly, and by which factors it is larger than the one that was given; None where they could not be fitted."""

    fly: Fly
    sizes: Sizes | None


def sized_fly(first: Sequence[Sighting], cameras: Sequence[Camera], fly: Fly) -> SizedFly:
    """Follow the fly with the sizes given, then fit them to the best-seen instants, spread over the frames.

    Where fewer than four frames are tracked, the fly stays as given.
    """
    about = _about_as_large(first, cameras, fly)
    tracked = Pursuit(cameras=cameras, fly=about, refine=True).begun(first)
    good = [k for k, frame in enumerate(tracked) if frame.status == "tracked" and first[k].clear]
    if len(good) < _FEWEST:
        return SizedFly(fly=fly, sizes=None)
    seen = [_seen(first[k], cameras, tracked[k]) for k in _best_of_each_stretch(good, tracked)]
    found = fitted_sizes(about.shape, seen)
    return SizedFly(fly=replace(fly, shape=found.shape), sizes=_over(fly.shape, about.shape, found.sizes))


def _about_as_large(first: Sequence[Sighting], cameras: Sequence[Camera], fly: Fly) -> Fly:
    """The fly stretched so that its silhouettes are as large as those seen, on average; as given where it is near."""
    some = [sighting.masks for sighting in first if sighting.clear][:: max(1, len(first) // _WANTED)]
    if not some:
        return fly
    seen = np.median([[np.count_nonzero(mask) for mask in masks] for masks in some], axis=0)
    ratio = float(np.sqrt(np.mean(seen / _mean_area(some[0], cameras, fly))))
    return fly if abs(np.log(ratio)) < np.log(_NEAR) else replace(fly, shape=resized(fly.shape, _all(ratio)))


def _mean_area(masks: Sequence[NDArray[np.bool_]], cameras: Sequence[Camera], fly: Fly) -> NDArray[np.float64]:
    """(C,) pixels of the fly drawn where it is, level, with its wings in many places, headed in four directions."""
    shape = fit_shape(fly.shape)
    hull = fine_hull(masks, cameras, shape)
    middle = hull.centres.mean(axis=0) if len(hull) else np.zeros(3)
    angles = np.array(list(product(_HEADINGS, _STROKES, _PITCHES)))
    X = np.zeros((len(angles), 18))
    X[:, :3], X[:, 3], X[:, 4] = middle, angles[:, 0], fly.stroke_plane_angle
    X[:, 6:12:3], X[:, 8:12:3] = angles[:, [1]], angles[:, [2]]
    X[:, 12:] = shape.bases_B.ravel()
    pose = Pose(coordinates=X, stroke_plane_angle=fly.stroke_plane_angle)
    drawn = render_silhouettes(fly.shape, pose, cameras)
    return np.mean([[np.count_nonzero(mask) for mask in masks] for masks in drawn], axis=0)


def _all(factor: float) -> Sizes:
    return Sizes(body_length=factor, body_radius=factor, wing_length=factor, wing_chord=factor)


def _over(given: FlyShape, about: FlyShape, sizes: Sizes) -> Sizes:
    """Factors over the shape that was given, of factors over one of about that size."""
    ratio = float(about.wing[-1, 0] / given.wing[-1, 0])
    return Sizes(**{field.name: ratio * getattr(sizes, field.name) for field in fields(sizes)})


def _best_of_each_stretch(good: Sequence[int], tracked: Sequence[TrackedFrame]) -> list[int]:
    """The best-covered frame of each of up to eight stretches."""
    stretches = np.array_split(np.array(good), min(_WANTED, len(good)))
    return [int(max(stretch, key=lambda k: _overlap(tracked[int(k)]))) for stretch in stretches]


def _overlap(frame: TrackedFrame) -> float:
    return 0.0 if frame.agreement is None else float(np.mean(frame.agreement.overlap))


def _seen(sighting: Sighting, cameras: Sequence[Camera], frame: TrackedFrame) -> tuple[BorderDistance, Stance]:
    assert frame.stance is not None
    return border_distance(views_of(sighting.masks, cameras), MARGIN), frame.stance

"""A fly as large as the first frames of a film say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flycontrol.model.camera import Camera
from flycontrol.vision.first_pose import MARGIN
from flycontrol.vision.follower import Fly
from flycontrol.vision.sighting import Sighting
from flycontrol.vision.size_fit import Sizes, fitted_sizes
from flycontrol.vision.soft_silhouette import BorderDistance, border_distance
from flycontrol.vision.stance import Stance
from flycontrol.vision.track import Pursuit
from flycontrol.vision.tracked_frame import TrackedFrame
from flycontrol.vision.views import views_of

_WANTED, _FEWEST = 8, 4  #: instants to which sizes are fitted


@dataclass(frozen=True, slots=True, kw_only=True)
class SizedFly:
    """A fly, and by which factors it is larger than the one that was given; None where they could not be fitted."""

    fly: Fly
    sizes: Sizes | None


def sized_fly(first: Sequence[Sighting], cameras: Sequence[Camera], fly: Fly) -> SizedFly:
    """Follow the fly with the sizes given, then fit them to the best-seen instants, spread over the frames.

    Where fewer than four frames are tracked, the fly stays as given.
    """
    tracked = Pursuit(cameras=cameras, fly=fly, refine=True).begun(first)
    good = [k for k, frame in enumerate(tracked) if frame.status == "tracked" and first[k].clear]
    if len(good) < _FEWEST:
        return SizedFly(fly=fly, sizes=None)
    seen = [_seen(first[k], cameras, tracked[k]) for k in _best_of_each_stretch(good, tracked)]
    found = fitted_sizes(fly.shape, seen)
    return SizedFly(fly=replace(fly, shape=found.shape), sizes=found.sizes)


def _best_of_each_stretch(good: Sequence[int], tracked: Sequence[TrackedFrame]) -> list[int]:
    """The best-covered frame of each of up to eight stretches."""
    stretches = np.array_split(np.array(good), min(_WANTED, len(good)))
    return [int(max(stretch, key=lambda k: _overlap(tracked[int(k)]))) for stretch in stretches]


def _overlap(frame: TrackedFrame) -> float:
    return 0.0 if frame.agreement is None else float(np.mean(frame.agreement.overlap))


def _seen(sighting: Sighting, cameras: Sequence[Camera], frame: TrackedFrame) -> tuple[BorderDistance, Stance]:
    assert frame.stance is not None
    return border_distance(views_of(sighting.masks, cameras), MARGIN), frame.stance

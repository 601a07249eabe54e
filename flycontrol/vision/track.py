"""A fly followed through its silhouettes, frame after frame in one pass."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera import Camera
from flycontrol.vision.first_pose import FirstPose, Masks, first_pose
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.follower import Fly, Follower
from flycontrol.vision.footage import FilmedFrame
from flycontrol.vision.sighting import Sighting, leaving, of_the_expected, one_animal, sighting_of
from flycontrol.vision.tracked_frame import Track, TrackedFrame, gathered
from flycontrol.vision.views import BoolArray, require_fitting

FIRST = 48  #: frames among which the first pose is looked for


def track(frames: Iterable[FilmedFrame | Masks], cameras: Sequence[Camera], fly: Fly, *, refine: bool = True) -> Track:
    """The 18 coordinates of a fly in every frame, as arrays; see `tracked_frames`."""
    return gathered(tracked_frames(frames, cameras, fly, refine=refine), fly.stroke_plane_angle, len(cameras))


def tracked_frames(
    frames: Iterable[FilmedFrame | Masks], cameras: Sequence[Camera], fly: Fly, *, refine: bool = True
) -> Iterator[TrackedFrame]:
    """Follow a fly; one result for each frame, as they come.

    The first pose is looked for in the first frames, of which the best one is taken and followed both ways; where none
    of them shows a fly, in those after them. From there on each frame starts from where the fly is expected. Left and
    right, head and tail are those of the body found at first. At most the silhouettes of 48 frames are held in memory.

    Parameters
    ----------
    frames : for each instant what was filmed, or C boolean images (rows, columns), without dust
    cameras : C cameras; the world's z points up
    fly : its sizes
    refine : fit the parametric fly to the silhouettes; without, the hull alone is read

    Raises
    ------
    InvalidInputError
        If images do not fit the cameras, or if no pose is found in any of the frames.
    """
    pursuit, source = Pursuit(cameras=cameras, fly=fly, refine=refine), iter(frames)
    some = False
    while pursuit.follower is None and (first := [sighting_of(frame, cameras) for frame in islice(source, FIRST)]):
        yield from pursuit.begun(first)
        some = True
    if some and pursuit.follower is None:
        raise InvalidInputError(NOWHERE)
    for frame in source:
        yield pursuit.followed(sighting_of(frame, cameras))


NOWHERE = (
    "No fly was found in any frame: in each of them some silhouette is empty, or the silhouettes contradict one "
    "another; check the threshold, and the order and the calibration of the cameras."
)


@dataclass(slots=True, kw_only=True)
class Pursuit:
    """A fly that is being followed, once it has been found."""

    cameras: Sequence[Camera]
    fly: Fly
    refine: bool
    follower: Follower | None = None

    def begun(self, first: Sequence[Sighting]) -> list[TrackedFrame]:
        """Look for the fly in some frames and follow it both ways from the best one; all are lost if it is in none."""
        for sighting in first:
            if not sighting.fault:
                require_fitting(sighting.masks, self.cameras)
        start = self._start(first)
        if start is None:
            return [_lost(sighting) for sighting in first]
        back, self.follower = (
            Follower(cameras=self.cameras, fly=self.fly, refine=self.refine, start=start.fit) for _ in range(2)
        )
        before = [_followed(back, sighting) for sighting in first[start.frame :: -1]][:0:-1]
        return before + [_followed(self.follower, sighting) for sighting in first[start.frame :]]

    def followed(self, sighting: Sighting) -> TrackedFrame:
        """One more frame."""
        assert self.follower is not None
        if not sighting.fault:
            require_fitting(sighting.masks, self.cameras)
        return _followed(self.follower, sighting)

    def _start(self, first: Sequence[Sighting]) -> FirstPose | None:
        clear = [k for k, sighting in enumerate(first) if sighting.clear]
        usable = clear or [k for k, sighting in enumerate(first) if not sighting.fault]
        if not usable:
            return None
        shape, angle = fit_shape(self.fly.shape), self.fly.stroke_plane_angle
        try:
            found = first_pose([self._alone(first[k]) for k in usable], self.cameras, shape, angle)
        except InvalidInputError:
            return None
        return replace(found, frame=usable[found.frame])

    def _alone(self, sighting: Sighting) -> Masks:
        return one_animal(sighting.masks, self.cameras) if sighting.crowded else sighting.masks


def _followed(follower: Follower, sighting: Sighting) -> TrackedFrame:
    if sighting.fault:
        return follower.missed(sighting.fault)
    masks, shape = sighting.masks, fit_shape(follower.fly.shape)
    if follower.past:
        if camera := leaving(masks, follower.cameras, shape, follower.past[-1]):
            return follower.missed(f"most of the body is out of the image of {camera}")
        masks = of_the_expected(masks, follower.cameras, shape, follower.past[-1])
    elif sighting.crowded:
        masks = one_animal(masks, follower.cameras)
    found = follower.follow(masks)
    if not sighting.crowded or found.status not in ("tracked", "partial"):
        return found
    whom = _crowd(sighting, masks)
    return replace(found, status="partial", reason="; ".join(reason for reason in (found.reason, whom) if reason))


def _crowd(sighting: Sighting, followed: Sequence[BoolArray]) -> str:
    seen = ", ".join(sighting.crowded)
    if any(np.count_nonzero(all_) > np.count_nonzero(one) for all_, one in zip(sighting.masks, followed, strict=True)):
        return f"more than one animal before {seen}; that near the expected one is followed"
    return f"the silhouette is in several large pieces before {seen}"


def _lost(sighting: Sighting) -> TrackedFrame:
    reason = sighting.fault or "no fly was found yet"
    return TrackedFrame(stance=None, covariance=np.full((18, 18), np.nan), status="lost", reason=reason, agreement=None)

"""A fly followed through its silhouettes, frame after frame in one pass."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice

from flycontrol.model.camera import Camera
from flycontrol.vision.first_pose import Masks, first_pose
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.follower import Fly, Follower
from flycontrol.vision.tracked_frame import Track, TrackedFrame, gathered
from flycontrol.vision.views import require_fitting

_FIRST = 48  #: frames among which the first pose is looked for


def track(frames: Iterable[Masks], cameras: Sequence[Camera], fly: Fly, *, refine: bool = True) -> Track:
    """The 18 coordinates of a fly in every frame, as arrays; see `tracked_frames`."""
    return gathered(tracked_frames(frames, cameras, fly, refine=refine), fly.stroke_plane_angle, len(cameras))


def tracked_frames(
    frames: Iterable[Masks], cameras: Sequence[Camera], fly: Fly, *, refine: bool = True
) -> Iterator[TrackedFrame]:
    """Follow a fly; one result for each frame of silhouettes, as they come.

    The first pose is looked for in the first frames, of which the best one is taken and followed both ways. From there
    on each frame starts from where the fly is expected. Left and right, head and tail are those of the body found at
    first. At most 48 frames are held in memory.

    Parameters
    ----------
    frames : for each instant C boolean images (rows, columns), without dust
    cameras : C cameras; the world's z points up
    fly : its sizes
    refine : fit the parametric fly to the silhouettes; without, the hull alone is read

    Raises
    ------
    InvalidInputError
        If images do not fit the cameras, or if no pose is found in any of the first frames.
    """
    source = iter(frames)
    first = list(islice(source, _FIRST))
    if not first:
        return
    for masks in first:
        require_fitting(masks, cameras)
    start = first_pose(first, cameras, fit_shape(fly.shape), fly.stroke_plane_angle)
    back, ahead = (Follower(cameras=cameras, fly=fly, refine=refine, start=start.fit) for _ in range(2))
    yield from [back.follow(masks) for masks in first[start.frame :: -1]][:0:-1]
    for masks in first[start.frame :]:
        yield ahead.follow(masks)
    del first
    for masks in source:
        require_fitting(masks, cameras)
        yield ahead.follow(masks)

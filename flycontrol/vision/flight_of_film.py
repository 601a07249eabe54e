"""A film and what is known of it, tracked and put together as a flight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.model.camera import Camera
from flycontrol.model.pose import Pose
from flycontrol.vision.footage import Footage
from flycontrol.vision.footage_check import FootageCheck
from flycontrol.vision.tracked_film import Asked, tracked_film
from flycontrol.vision.tracked_flight import TrackedFlight
from flycontrol.vision.unsmoothed import unsmoothed


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FilmedFlight:
    """What is tracked, and all that belongs to it."""

    name: str
    footage: Footage
    frames: range  #: numbers of its frames in the films
    cameras: tuple[Camera, ...]  #: world z up
    world: str  #: how that world lies in the calibration's
    truth: Pose | None = None


def flight_of_film(
    filmed: FilmedFlight,
    asked: Asked,
    check: FootageCheck,
    checkpoint: Checkpoint | None = None,
    progress: Progress = no_progress,
) -> TrackedFlight:
    """Track a film; raises as `tracked_film` does."""
    found = tracked_film(filmed.footage, filmed.cameras, asked, checkpoint, progress)
    rate = filmed.footage.frame_rate
    return TrackedFlight(
        name=filmed.name,
        time=np.array(filmed.frames) / (rate * filmed.frames.step),
        cameras=filmed.cameras,
        fly=found.sized.fly,
        sizes_fitted=found.sized.sizes is not None,
        refined=asked.refine,
        track=found.track,
        smoothed=unsmoothed(found.track, rate),
        check=check.calibration,
        truth=filmed.truth,
        frames=filmed.frames,
        sizes=found.sized.sizes,
        world=filmed.world,
        doubt=check.doubt,
    )

"""A film and what is known of it, tracked, smoothed and put together as a flight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.model.camera import Camera
from flycontrol.model.pose import Pose
from flycontrol.vision.checks.attitude_check import upside_down
from flycontrol.vision.checks.footage_check import FootageCheck
from flycontrol.vision.footage import Footage
from flycontrol.vision.smoothing import smoothed
from flycontrol.vision.tracked_film import Asked, tracked_film
from flycontrol.vision.tracked_flight import TrackedFlight


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
    """Track a film and smooth what was found; raises as `tracked_film` does."""
    found = tracked_film(filmed.footage, filmed.cameras, asked, checkpoint, progress)
    progress(len(filmed.frames), len(filmed.frames), "smoothing")
    rate = filmed.footage.frame_rate
    return TrackedFlight(
        name=filmed.name,
        time=np.array(filmed.frames) / (rate * filmed.frames.step),
        frame_rate=rate,
        cameras=filmed.cameras,
        fly=found.sized.fly,
        sizes_fitted=found.sized.sizes is not None,
        refined=asked.refine,
        track=found.track,
        smoothed=smoothed(found.track, rate),
        check=check.calibration,
        truth=filmed.truth,
        frames=filmed.frames,
        sizes=found.sized.sizes,
        world=filmed.world,
        doubt="; ".join(filter(None, (check.doubt, upside_down(found.track)))),
    )

"""A flight that was tracked: all that its files and its page are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.camera import Camera
from flycontrol.model.pose import Pose
from flycontrol.vision.calibration_check import CalibrationCheck
from flycontrol.vision.follower import Fly
from flycontrol.vision.smoothed_pose import SmoothedPose
from flycontrol.vision.tracked_frame import Track

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrackedFlight:
    """N frames seen by C cameras."""

    name: str
    time: FloatArray  #: (N,) [s]
    cameras: tuple[Camera, ...]  #: world z up
    fly: Fly  #: its sizes, as fitted or as given
    sizes_fitted: bool
    refined: bool  #: the parametric fly was fitted to the silhouettes; otherwise the hull alone was read
    track: Track
    smoothed: SmoothedPose
    check: CalibrationCheck
    truth: Pose | None = None  #: of a simulated flight

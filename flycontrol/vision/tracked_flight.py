"""A flight that was tracked: all that its files and its page are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.camera import Camera
from flycontrol.model.pose import Pose
from flycontrol.vision.checks.calibration_check import CalibrationCheck
from flycontrol.vision.follower import Fly
from flycontrol.vision.size_fit import Sizes
from flycontrol.vision.smoothed_pose import SmoothedPose
from flycontrol.vision.smoothing import too_few_to_smooth
from flycontrol.vision.tracked_frame import Track

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrackedFlight:
    """N frames seen by C cameras."""

    name: str
    time: FloatArray  #: (N,) since frame 0 of the films [s]
    frame_rate: float  #: of these frames, as it was given and not from their times, which are rounded [1/s]
    cameras: tuple[Camera, ...]  #: world z up
    fly: Fly  #: its sizes, as fitted or as given
    sizes_fitted: bool
    refined: bool  #: the parametric fly was fitted to the silhouettes; otherwise the hull alone was read
    track: Track
    smoothed: SmoothedPose
    check: CalibrationCheck
    truth: Pose | None = None  #: of a simulated flight
    frames: range | None = None  #: numbers of the frames in the films; None: all from 0 on
    sizes: Sizes | None = None  #: fitted factors on the sizes of the fly that was given
    world: str = "as calibrated"  #: how this world lies in that of the calibration
    doubt: str = ""  #: what the check of films and cameras warns of

    @property
    def unsmoothed(self) -> str:
        """Why nothing is smoothed, one sentence; empty where something is."""
        return "" if np.any(np.isfinite(self.smoothed.pose.coordinates)) else too_few_to_smooth(self.track)

    @property
    def numbers(self) -> NDArray[np.int64]:
        """(N,) numbers of the frames in the films."""
        return np.array(range(len(self.time)) if self.frames is None else self.frames, dtype=np.int64)

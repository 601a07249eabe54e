"""A track as it is, with differences for derivatives."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.pose import Pose
from flycontrol.vision.smoothed_pose import SmoothedPose
from flycontrol.vision.tracked_frame import Track

FloatArray = NDArray[np.float64]

_ANGLES = slice(3, 12)


def unsmoothed(track: Track, frame_rate: float) -> SmoothedPose:
    """x, (x_{n+1} - x_{n-1}) / 2 h and so on; the uncertainties of derivatives are not known and NaN."""
    X = track.pose.coordinates.copy()
    known = np.all(np.isfinite(X), axis=1)
    X[known, _ANGLES] = np.unwrap(X[known, _ANGLES], axis=0)
    enough = len(X) > 1
    rate = np.gradient(X, 1.0 / frame_rate, axis=0) if enough else np.full_like(X, np.nan)
    again = np.gradient(rate, 1.0 / frame_rate, axis=0) if enough else np.full_like(X, np.nan)
    unknown = np.full_like(X, np.nan)
    return SmoothedPose(
        pose=Pose(coordinates=X, stroke_plane_angle=track.pose.stroke_plane_angle),
        uncertainty=track.uncertainty,
        rate=rate,
        rate_uncertainty=unknown,
        acceleration=again,
        acceleration_uncertainty=unknown,
        angular_velocity_B=_angular_velocity(X, rate),
        angular_velocity_uncertainty=unknown[:, :3],
    )


def _angular_velocity(X: FloatArray, rate: FloatArray) -> FloatArray:
    """w_B = (roll' - yaw' sin, pitch' cos + yaw' sin cos, ...) of yaw, pitch and roll, z down."""
    _, pitch, roll = X[:, 3:6].T
    yaw_rate, pitch_rate, roll_rate = rate[:, 3:6].T
    return np.stack([
        roll_rate - yaw_rate * np.sin(pitch),
        pitch_rate * np.cos(roll) + yaw_rate * np.sin(roll) * np.cos(pitch),
        yaw_rate * np.cos(roll) * np.cos(pitch) - pitch_rate * np.sin(roll),
    ], axis=1)  # fmt: skip

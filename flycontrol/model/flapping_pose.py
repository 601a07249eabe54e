"""Poses of a fly whose body moves as told while its wings beat a given stroke."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.pose import Pose
from flycontrol.model.stroke_kinematics import StrokeKinematics

FloatArray = NDArray[np.float64]


def flapping_pose(
    stroke: StrokeKinematics,
    time: ArrayLike,
    *,
    right_base_B: ArrayLike,
    stroke_plane_angle: float,
    position_W: ArrayLike = (0.0, 0.0, 0.0),
    attitude: ArrayLike = (0.0, 0.0, 0.0),
) -> Pose:
    """Pose at instants (N,) [s] of a body with a mirror-symmetric pair of wing bases.

    Parameters
    ----------
    stroke : what the wings do
    time : (N,) [s]
    right_base_B : (3,) base of the right wing from the body's centre, body axes [m]
    stroke_plane_angle : v_S = Ry(angle) v_B [rad]
    position_W : (3,) or (N, 3) [m]
    attitude : yaw, pitch, roll, (3,) or (N, 3) [rad]
    """
    t = np.asarray(time, dtype=np.float64)
    right = np.asarray(right_base_B, dtype=np.float64)
    if t.ndim != 1 or right.shape != (3,):
        raise InvalidParameterError(f"flapping_pose needs times (N,) and a base (3,), got {t.shape} and {right.shape}.")
    phase = stroke.frequency * t
    columns = [position_W, attitude, stroke.left(phase).angles, stroke.right(phase).angles, right * [1, -1, 1], right]
    wide = [np.broadcast_to(np.asarray(column, dtype=np.float64), (len(t), 3)) for column in columns]
    return Pose(coordinates=np.hstack(wide), stroke_plane_angle=stroke_plane_angle)

"""A wingbeat of a fly that is held at its centre of mass and turned about an axis, as a trajectory."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.state_vector import LEVEL
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import Trajectory

FloatArray = NDArray[np.float64]


def steady_turn(
    kinematics: StrokeKinematics,
    angular_velocity: FloatArray,
    instants: int,
    angular_acceleration: FloatArray | None = None,
) -> Trajectory:
    """Instants (k + 1/2) / n of a wingbeat, between those where strokes turn; heading and place stay as they are.

    Parameters
    ----------
    kinematics : a periodic stroke
    angular_velocity : (3,) of the body at all instants, frame S [rad/s]
    instants : n
    angular_acceleration : (3,) of the body at all instants; none by default [rad/s^2]
    """
    phase = (np.arange(instants) + 0.5) / instants
    (left, left_acceleration), (right, right_acceleration) = (
        kinematics.motion(phase, side) for side in ("left", "right")
    )
    still = np.zeros((instants, 3))
    accelerated = np.zeros(3) if angular_acceleration is None else angular_acceleration
    return Trajectory(
        time=phase / kinematics.frequency,
        phase=phase,
        frequency=kinematics.frequency,
        position_W=still,
        q_WS=np.tile(LEVEL, (instants, 1)),
        velocity_S=still,
        angular_velocity_S=np.tile(angular_velocity, (instants, 1)),
        acceleration_S=still,
        angular_acceleration_S=np.tile(accelerated, (instants, 1)),
        left=left,
        right=right,
        left_acceleration=left_acceleration,
        right_acceleration=right_acceleration,
        wingbeats=1,
        samples_per_wingbeat=instants,
        status="complete",
    )

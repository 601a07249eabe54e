"""FlightState and Trajectory to and from the march's arrays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.kernels.march import (
    LEFT,
    LEFT_RATE,
    QUATERNION,
    RIGHT,
    RIGHT_RATE,
    SPIN,
    STATES,
    VELOCITY,
)
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState, Trajectory, wing_angles, wing_motion_of, wing_rates

FloatArray = NDArray[np.float64]

#: Stroke plane level, heading along the world's x: half a turn about x, since z of S points down.
LEVEL = (0.0, 1.0, 0.0, 0.0)

AT_REST = FlightState(
    position_W=np.zeros(3),
    q_WS=np.array(LEVEL),
    velocity_S=np.zeros(3),
    angular_velocity_S=np.zeros(3),
    left_angles=np.zeros(3),
    left_rates=np.zeros(3),
    right_angles=np.zeros(3),
    right_rates=np.zeros(3),
)


def level_start(stroke: StrokeKinematics, velocity_S: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> FlightState:
    """A body at the origin, stroke plane level, heading along x, wings where the stroke begins."""
    left, right = (stroke.wing(side)(np.zeros(1)) for side in ("left", "right"))
    return replace(
        AT_REST,
        velocity_S=np.array(velocity_S, dtype=np.float64),
        left_angles=left.angles[0],
        left_rates=left.first[0] * stroke.frequency,
        right_angles=right.angles[0],
        right_rates=right.first[0] * stroke.frequency,
    )


def packed(state: FlightState) -> FloatArray:
    """(25,) state as the march keeps it."""
    y = np.concatenate(
        [
            state.position_W, state.q_WS, state.velocity_S, state.angular_velocity_S,
            state.left_angles, state.right_angles, state.left_rates, state.right_rates,
        ]
    )  # fmt: skip
    length = float(np.linalg.norm(y[QUATERNION:VELOCITY]))
    if y.shape != (STATES,) or not np.all(np.isfinite(y)) or abs(length - 1.0) > 1e-6:
        raise InvalidParameterError(
            "A FlightState needs finite vectors of three and a unit quaternion of four, scalar first; "
            f"got {y.size} numbers and a quaternion of length {length:.6g}."
        )
    y[QUATERNION:VELOCITY] /= length
    return y


def unpacked(y: FloatArray) -> FlightState:
    """The state kept in (25,)."""
    return FlightState(
        position_W=y[:QUATERNION].copy(),
        q_WS=y[QUATERNION:VELOCITY].copy(),
        velocity_S=y[VELOCITY:SPIN].copy(),
        angular_velocity_S=y[SPIN:LEFT].copy(),
        left_angles=y[LEFT:RIGHT].copy(),
        left_rates=y[LEFT_RATE:RIGHT_RATE].copy(),
        right_angles=y[RIGHT:LEFT_RATE].copy(),
        right_rates=y[RIGHT_RATE:STATES].copy(),
    )


def samples_of(trajectory: Trajectory) -> FloatArray:
    """(N, 37) states and accelerations of a trajectory, simulated or measured."""
    t = trajectory
    return np.ascontiguousarray(np.hstack([
        t.position_W, t.q_WS, t.velocity_S, t.angular_velocity_S, wing_angles(t.left), wing_angles(t.right),
        wing_rates(t.left), wing_rates(t.right), t.acceleration_S, t.angular_acceleration_S,
        t.left_acceleration, t.right_acceleration,
    ]))  # fmt: skip


def first_wingbeat(samples: FloatArray, frequency: float, samples_per_wingbeat: int) -> Trajectory:
    """What was stored of it, (n, 37) with n at most `samples_per_wingbeat`; its end is not a part."""
    phase = np.arange(len(samples)) / samples_per_wingbeat
    return trajectory_of(samples, phase, frequency, samples_per_wingbeat)


def trajectory_of(samples: FloatArray, phase: FloatArray, frequency: float, samples_per_wingbeat: int) -> Trajectory:
    """Trajectory from the march's samples (N, 37) at phases (N,) [wingbeats]."""
    s = samples
    return Trajectory(
        time=phase / frequency,
        frequency=frequency,
        phase=phase,
        position_W=s[:, :QUATERNION],
        q_WS=s[:, QUATERNION:VELOCITY],
        velocity_S=s[:, VELOCITY:SPIN],
        angular_velocity_S=s[:, SPIN:LEFT],
        acceleration_S=s[:, STATES : STATES + 3],
        angular_acceleration_S=s[:, STATES + 3 : STATES + 6],
        left=wing_motion_of(s[:, LEFT:RIGHT], s[:, LEFT_RATE:RIGHT_RATE]),
        right=wing_motion_of(s[:, RIGHT:LEFT_RATE], s[:, RIGHT_RATE:STATES]),
        left_acceleration=s[:, STATES + 6 : STATES + 9],
        right_acceleration=s[:, STATES + 9 :],
        wingbeats=0,
        samples_per_wingbeat=samples_per_wingbeat,
        status="complete",
    )

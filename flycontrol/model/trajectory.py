"""A simulated flight: body and wings at instants, and how far it can be trusted."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.stroke import Side, WingMotion

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightState:
    """Body and wings at one instant. World W: x and y level, z up; S: the body's stroke-plane frame, z down.

    The body's velocity is that of the centre of mass of the body without its wings.
    """

    position_W: FloatArray  #: (3,) [m]
    q_WS: FloatArray  #: (4,) stroke-plane frame to world, scalar first
    velocity_S: FloatArray  #: (3,) [m/s]
    angular_velocity_S: FloatArray  #: (3,) roll, pitch, yaw rate [rad/s]
    left_angles: FloatArray  #: (3,) stroke, deviation, pitch [rad]
    left_rates: FloatArray  #: (3,) [rad/s]
    right_angles: FloatArray  #: (3,) [rad]
    right_rates: FloatArray  #: (3,) [rad/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class StepError:
    """What Runge-Kutta's steps get wrong in one wingbeat, by repeating it with half as many.

    |x(2 h) - x(h)| / 15: the fourth order's share, an estimate where the motion is smooth. Where lift jumps as a wing
    reverses, the order falls to about one, and the error is some 2 to 30 times this (`analyses/how_many_steps.py`).
    """

    position: float  #: [m]
    velocity: float  #: [m/s]
    attitude: float  #: [rad]
    angular_velocity: float  #: [rad/s]
    wing_angle: float  #: of free wing joints [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class QuadratureError:
    """Of the air's load on both wings in one wingbeat, with few blades less with many: the largest, and of the mean."""

    force: float  #: largest at any instant, over the weight
    torque: float  #: largest at any instant, over weight times wing length
    mean_force: float  #: over the weight
    mean_torque: float  #: over weight times wing length


@dataclass(frozen=True, slots=True, kw_only=True)
class Trajectory:
    """A flight at N instants, evenly spaced: states and accelerations.

    World W: x and y level, z up (as in `Recording`); S: the body's stroke-plane frame, x forward, y right, z down.
    A heading psi > 0 is a turn to the right. Position and velocity are those of the centre of mass of the body without
    its wings.
    """

    time: FloatArray  #: (N,) [s]
    phase: FloatArray  #: (N,) [wingbeats]
    frequency: float  #: wingbeats a second [1/s]
    position_W: FloatArray  #: (N, 3) [m]
    q_WS: FloatArray  #: (N, 4) stroke-plane frame to world, scalar first
    velocity_S: FloatArray  #: (N, 3) [m/s]
    angular_velocity_S: FloatArray  #: (N, 3) roll, pitch, yaw rate [rad/s]
    acceleration_S: FloatArray  #: (N, 3) rate of change of the components of velocity_S [m/s^2]
    angular_acceleration_S: FloatArray  #: (N, 3) [rad/s^2]
    left: WingMotion
    right: WingMotion
    left_acceleration: FloatArray  #: (N, 3) stroke, deviation, pitch [rad/s^2]
    right_acceleration: FloatArray  #: (N, 3) [rad/s^2]
    wingbeats: int  #: whole wingbeats flown
    samples_per_wingbeat: int
    status: str  #: "complete", or a sentence that says at which wingbeat it stopped and why
    step_error: StepError | None = None
    quadrature_error: QuadratureError | None = None

    @property
    def complete(self) -> bool:
        """Whether it flew as many wingbeats as it was asked to."""
        return self.status == "complete"

    @property
    def velocity_W(self) -> FloatArray:
        """(N, 3) [m/s]."""
        return np.einsum("nij,nj->ni", rotation_matrices(self.q_WS), self.velocity_S)

    @property
    def yaw(self) -> FloatArray:
        """(N,) heading of the stroke plane's forward axis, unwrapped, > 0 to the right of the world's x [rad]."""
        ahead = rotation_matrices(self.q_WS)[:, :, 0]
        return np.unwrap(np.arctan2(-ahead[:, 1], ahead[:, 0]))

    @property
    def nose_up(self) -> FloatArray:
        """(N,) elevation of the stroke plane's forward axis above the horizon [rad]."""
        return np.arcsin(np.clip(rotation_matrices(self.q_WS)[:, 2, 0], -1.0, 1.0))

    @property
    def roll(self) -> FloatArray:
        """(N,) turn about the stroke plane's forward axis, > 0 right side down, unwrapped [rad]."""
        down = rotation_matrices(self.q_WS)[:, 2]
        return np.unwrap(np.arctan2(-down[:, 1], -down[:, 2]))

    def wing(self, side: Side) -> WingMotion:
        """Motion of one wing."""
        return self.left if side == "left" else self.right

    def state(self, index: int = -1) -> FlightState:
        """The state at one instant, the last by default."""
        return FlightState(
            position_W=self.position_W[index],
            q_WS=self.q_WS[index],
            velocity_S=self.velocity_S[index],
            angular_velocity_S=self.angular_velocity_S[index],
            left_angles=wing_angles(self.left)[index],
            left_rates=wing_rates(self.left)[index],
            right_angles=wing_angles(self.right)[index],
            right_rates=wing_rates(self.right)[index],
        )


def wing_angles(motion: WingMotion) -> FloatArray:
    """(N, 3) stroke, deviation, pitch [rad]."""
    return np.stack([motion.stroke, motion.deviation, motion.pitch], axis=-1)


def wing_rates(motion: WingMotion) -> FloatArray:
    """(N, 3) rates of stroke, deviation, pitch [rad/s]."""
    return np.stack([motion.stroke_rate, motion.deviation_rate, motion.pitch_rate], axis=-1)


def wing_motion_of(angles: FloatArray, rates: FloatArray) -> WingMotion:
    """Motion from (N, 3) angles [rad] and rates [rad/s]."""
    return WingMotion(
        **{field.name: column for field, column in zip(fields(WingMotion), [*angles.T, *rates.T], strict=True)}
    )


def rotation_matrices(q: FloatArray) -> FloatArray:
    """(N, 3, 3) of unit quaternions (N, 4), scalar first."""
    w, x, y, z = q.T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=-1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=-1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=-2,
    )

"""The body's state in the eight coordinates that flight depends on: velocities, rates, roll and pitch.

    q_WS = level o Rz(psi) o Ry(theta) o Rx(phi)

Level is the stroke plane in the horizon with z down. Position and heading psi are left out: nothing depends on them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.march import LEFT, QUATERNION, VELOCITY
from flycontrol.flight.state_vector import level_start, packed
from flycontrol.model.stroke_kinematics import StrokeKinematics

FloatArray = NDArray[np.float64]

#: u, v, w [m/s], p, q, r [rad/s], frame S; roll phi and pitch theta of the stroke plane [rad].
COORDINATES = ("forward", "sideways", "down", "roll_rate", "pitch_rate", "yaw_rate", "roll", "pitch")
ROLL, PITCH = 6, 7
LONGITUDINAL, LATERAL = (0, 2, 4, 7), (1, 3, 5, 6)  #: what a mirror in the plane of symmetry keeps, and what it turns


def state_at(stroke: StrokeKinematics, x: FloatArray) -> FloatArray:
    """(25,) state at the origin, heading along the world's x, wings where the stroke begins; x is (8,)."""
    y = packed(level_start(stroke))
    y[VELOCITY:LEFT] = x[:ROLL]
    y[QUATERNION:VELOCITY] = attitude(x[ROLL], x[PITCH], np.zeros(()))
    return y


def coordinates_of(y: FloatArray) -> FloatArray:
    """(..., 8) coordinates of states or samples (..., 25 or more)."""
    roll, pitch, _ = attitude_angles(y[..., QUATERNION:VELOCITY])
    return np.concatenate([y[..., VELOCITY:LEFT], roll[..., None], pitch[..., None]], axis=-1)


def attitude(roll: FloatArray, pitch: FloatArray, heading: FloatArray) -> FloatArray:
    """(..., 4) quaternions q_WS from angles [rad]."""
    c, s = np.cos(np.array([roll, pitch, heading]) / 2), np.sin(np.array([roll, pitch, heading]) / 2)
    w = c[2] * c[1] * c[0] + s[2] * s[1] * s[0]
    x = c[2] * c[1] * s[0] - s[2] * s[1] * c[0]
    y = c[2] * s[1] * c[0] + s[2] * c[1] * s[0]
    z = s[2] * c[1] * c[0] - c[2] * s[1] * s[0]
    return np.stack([-x, w, -z, y], axis=-1)  # level = (0, 1, 0, 0) comes first


def attitude_angles(q_WS: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Roll phi, pitch theta, heading psi of quaternions (..., 4) [rad]."""
    a, b, c, d = np.moveaxis(q_WS, -1, 0)
    w, x, y, z = b, -a, d, -c
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    heading = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return roll, pitch, heading


def attitude_rates(x: FloatArray) -> FloatArray:
    """phi' = p + (q sin phi + r cos phi) tan theta, theta' = q cos phi - r sin phi; (..., 2) of (..., 8) [rad/s]."""
    p, q, r, roll, pitch = np.moveaxis(x[..., 3:], -1, 0)
    sin, cos = np.sin(roll), np.cos(roll)
    return np.stack([p + (q * sin + r * cos) * np.tan(pitch), q * cos - r * sin], axis=-1)


def natural_scales(fly: FlappingFly, stroke: StrokeKinematics) -> FloatArray:
    """(8,) wing lengths a wingbeat, radians a wingbeat, radians."""
    speed = fly.morphology.wing_length * stroke.frequency
    return np.array([speed] * 3 + [stroke.frequency] * 3 + [1.0] * 2)

"""Yaw, pitch and roll of a smooth turn with their derivatives, the angular velocity, and what is known of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flycontrol.model.pose import attitude_angles
from flycontrol.vision.smooth.smooth_turn import SmoothTurn

FloatArray = NDArray[np.float64]

_INSTANT = 0.02  #: of a frame, for differences: the turn is known to second order, without noise
_LARGEST = 0.05  #: turn for differences [rad]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AttitudeMotion:
    """N instants."""

    angles: FloatArray  #: (N, 3, 3): yaw, pitch, roll; each with first and second derivative [rad, rad/s, rad/s^2]
    spread: FloatArray  #: (N, 3, 3) their standard deviations
    angular_velocity_B: FloatArray  #: (N, 3) about forward, right, down [rad/s]
    angular_velocity_spread: FloatArray  #: (N, 3)


def attitude_motion(turn: SmoothTurn, frame_rate: float) -> AttitudeMotion:
    """Angles and rates of R(t) = A(t) exp[w(t)]; J C J^T of the covariance C of (w, w', w''), axis by axis."""
    states = turn.states
    here = _outcome(turn, states, frame_rate)
    variance = np.zeros_like(here)
    for axis in range(3):
        C = turn.covariance[:, axis]
        spread = np.sqrt(np.diagonal(C, axis1=1, axis2=2))
        step = spread.copy()
        step[:, 0] = np.minimum(step[:, 0], _LARGEST)
        J = np.stack([_by(turn, states, axis, order, step[:, order], frame_rate) for order in range(3)], axis=-1)
        variance += np.einsum("nabi,nij,nabj->nab", J, C, J)
    spread = np.sqrt(variance)
    return AttitudeMotion(
        angles=here[:, :3],
        spread=spread[:, :3],
        angular_velocity_B=here[:, 3],
        angular_velocity_spread=spread[:, 3],
    )


def _outcome(turn: SmoothTurn, states: FloatArray, frame_rate: float) -> FloatArray:
    """(N, 4, 3): three angles with derivatives (last), and the angular velocity by axes (last)."""
    h = _INSTANT / frame_rate
    before, now, after = (turn.at(offset, states) for offset in (-h, 0.0, h))
    angles = attitude_angles(now)
    back, ahead = (_wrapped(attitude_angles(R) - angles) for R in (before, after))
    omega = Rotation.from_matrix(np.swapaxes(before, 1, 2) @ after).as_rotvec() / (2 * h)
    motion = np.stack([angles, (ahead - back) / (2 * h), (ahead + back) / h**2], axis=2)
    return np.concatenate([motion, omega[:, None]], axis=1)


def _by(turn: SmoothTurn, states: FloatArray, axis: int, order: int, step: FloatArray, frame_rate: float) -> FloatArray:
    """(N, 4, 3) derivative of the outcome by one entry of the states."""
    aside = np.zeros_like(states)
    aside[:, order, axis] = step
    change = _outcome(turn, states + aside, frame_rate) - _outcome(turn, states - aside, frame_rate)
    change[:, :3, 0] = _wrapped(change[:, :3, 0])
    return change / (2 * step[:, None, None])


def _wrapped(angles: FloatArray) -> FloatArray:
    return (angles + np.pi) % (2 * np.pi) - np.pi

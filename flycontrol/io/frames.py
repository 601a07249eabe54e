"""From a file's axes to the package's: body forward-right-down, stroke plane forward-right-down, world z up."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flycontrol.model.morphology import pitch_rotation

FloatArray = NDArray[np.float64]

_HALF_TURN_ABOUT_X = np.diag([1.0, -1.0, -1.0])  #: right and down become left and up, and back


def attitude(quaternion: FloatArray, *, to_world: bool, world_z: Literal["up", "down"], left_up: bool) -> FloatArray:
    """q_WB = Rx(180 deg) q Rx(180 deg), each factor only where world z points down and body axes are left-up.

    Parameters
    ----------
    quaternion : (N, 4) unit quaternions, scalar first
    to_world : whether they turn body axes into world axes; otherwise they are inverted
    world_z : where the file's world z points
    left_up : whether the file's body axes are forward, left, up

    Returns
    -------
    (N, 4) array
        Body to world, scalar first, of unit norm, without jumps of sign.
    """
    rotation = Rotation.from_quat(quaternion, scalar_first=True)
    rotation = rotation if to_world else rotation.inv()
    half_turn = Rotation.from_matrix(_HALF_TURN_ABOUT_X)
    rotation = half_turn * rotation if world_z == "down" else rotation
    rotation = rotation * half_turn if left_up else rotation
    return _without_sign_jumps(rotation.as_quat(scalar_first=True))


def world_z_up(vector: FloatArray, world_z: Literal["up", "down"]) -> FloatArray:
    """v_W, (N, 3): turned by half a turn about x if the file's world z points down."""
    return vector @ _HALF_TURN_ABOUT_X if world_z == "down" else vector


def forward_right_down(vector: FloatArray, *, left_up: bool) -> FloatArray:
    """v_B, (N, 3): turned by half a turn about x if the file's body axes are forward, left, up."""
    return vector @ _HALF_TURN_ABOUT_X if left_up else vector


def world_to_body(vector_W: FloatArray, q_WB: FloatArray) -> FloatArray:
    """v_B = R_WB^T v_W, (N, 3)."""
    return Rotation.from_quat(q_WB, scalar_first=True).apply(vector_W, inverse=True)


def body_to_world(vector_B: FloatArray, q_WB: FloatArray) -> FloatArray:
    """v_W = R_WB v_B, (N, 3)."""
    return Rotation.from_quat(q_WB, scalar_first=True).apply(vector_B)


def body_to_stroke_plane(vector_B: FloatArray, angle: float) -> FloatArray:
    """v_S = Ry(angle) v_B, (N, 3), angle in [rad]."""
    return vector_B @ pitch_rotation(angle).T


def turning_rate(q_WB: FloatArray, rate: float, over: int) -> FloatArray:
    """|w| from the angle between attitudes that lie `over` samples apart, (N - over,) [rad/s]."""
    rotation = Rotation.from_quat(q_WB, scalar_first=True)
    return (rotation[:-over].inv() * rotation[over:]).magnitude() * rate / over


def _without_sign_jumps(q: FloatArray) -> FloatArray:
    flips = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1.0, 1.0)
    return q * np.concatenate([[1.0], np.cumprod(flips)])[:, None]

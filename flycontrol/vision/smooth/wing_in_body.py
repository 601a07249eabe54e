"""A wing that is known in the world, as seen from a body that is known less well."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flycontrol.model.pose import Pose, wing_angles_of
from flycontrol.model.stroke import Side

FloatArray = NDArray[np.float64]

_SMALL_TURN = 1e-4  #: for differences [rad]


def wing_in_body(pose: Pose, side: Side, position_W: FloatArray, body_axes_W: FloatArray) -> FloatArray:
    """(N, 6) stroke, deviation, pitch [rad] and base [m] that a pose's wing has in another body of the same fly.

    Parameters
    ----------
    pose : N instants; its wing's place in the world is kept
    side : which wing
    position_W, body_axes_W : (N, 3) [m] and R_WB (N, 3, 3) of the other body
    """
    angles = wing_angles_of(pose.wing_axes_W(side), body_axes_W, side, pose.stroke_plane_angle)
    base = np.einsum("nji,nj->ni", body_axes_W, pose.base_W(side) - position_W)
    return np.hstack([angles, base])


def by_body_turns(pose: Pose, side: Side) -> FloatArray:
    """(N, 6, 3) derivative of `wing_in_body` by turns of the body about its axes forward, right, down [1, m/rad]."""
    columns = []
    for turn in _SMALL_TURN * np.eye(3):
        ahead, back = (
            wing_in_body(pose, side, pose.position_W, pose.body_axes_W @ Rotation.from_rotvec(sign * turn).as_matrix())
            for sign in (1, -1)
        )
        change = ahead - back
        change[:, :3] = (change[:, :3] + np.pi) % (2 * np.pi) - np.pi
        columns.append(change / (2 * _SMALL_TURN))
    return np.stack(columns, axis=2)


def variance_from_body(by_turns: FloatArray, covariance: FloatArray, frame_rate: float) -> FloatArray:
    """(N, 6, 3) variances of J w, (J w)' = J' w + J w' and (J w)'' that turns w of the body give to a wing.

    Parameters
    ----------
    by_turns : J, (N, 6, 3) of consecutive frames
    covariance : (N, 3, 3, 3) of w, w', w'' for each axis (second)
    frame_rate : [1/s]
    """
    first = np.gradient(by_turns, 1 / frame_rate, axis=0)
    second, none = np.gradient(first, 1 / frame_rate, axis=0), np.zeros_like(first)
    rows = np.array([[by_turns, none, none], [first, by_turns, none], [second, 2 * first, by_turns]])
    return np.einsum("kinpa,naij,kjnpa->npk", rows, covariance, rows)

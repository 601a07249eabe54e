"""Heading of the body and how fast it turns, from the march's samples.

    psi = atan2(-a_y, a_x),    a = R(q) e_x,    a' = R (w x e_x),    a'' = R (w x (w x e_x) + w' x e_x)

a is the stroke plane's forward axis in the world; psi > 0 is a turn to the right.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.kernels.march import LEFT, QUATERNION, SPIN, STATES, VELOCITY
from flycontrol.model.trajectory import rotation_matrices

FloatArray = NDArray[np.float64]

_AHEAD = np.array([1.0, 0.0, 0.0])
_YAW = 2  # of an angular velocity in S


def headings(samples: FloatArray) -> FloatArray:
    """Heading, its rate and its acceleration.

    Parameters
    ----------
    samples : (N, 37) states and accelerations as the march stores them

    Returns
    -------
    (3, N) psi without jumps [rad], psi' [rad/s], psi'' [rad/s^2]
    """
    R = rotation_matrices(samples[:, QUATERNION:VELOCITY])
    w, w_dot = samples[:, SPIN:LEFT], samples[:, STATES + 3 : STATES + 6]
    turned = np.cross(w, _AHEAD)
    x, y = (R[:, row, 0] for row in (0, 1))
    x1, y1, _ = np.einsum("nij,nj->in", R, turned)
    x2, y2, _ = np.einsum("nij,nj->in", R, np.cross(w, turned) + np.cross(w_dot, _AHEAD))
    level = x * x + y * y
    rate = (y * x1 - x * y1) / level
    acceleration = (y * x2 - x * y2 - 2 * rate * (x * x1 + y * y1)) / level
    return np.stack([np.unwrap(np.arctan2(-y, x)), rate, acceleration])


def nose_heading(q_WS: FloatArray, stroke_plane_angle: float) -> FloatArray:
    """(N,) psi = atan2(-n_y, n_x), n = R(q_WS) (cos a, 0, -sin a): heading of the nose, right > 0, unwrapped [rad].

    A roll of the stroke plane moves the nose sideways, since it points up by the stroke plane's angle a [rad].
    """
    nose = rotation_matrices(q_WS) @ np.array([np.cos(stroke_plane_angle), 0.0, -np.sin(stroke_plane_angle)])
    return np.unwrap(np.arctan2(-nose[:, 1], nose[:, 0]))


def yaw_rates(samples: FloatArray) -> FloatArray:
    """(2, N) yaw rate about the stroke plane's normal [rad/s] and its rate of change [rad/s^2]."""
    return np.stack([samples[:, SPIN + _YAW], samples[:, STATES + 3 + _YAW]])

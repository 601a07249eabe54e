"""The attitude of a body as a smooth function of time, on the rotations themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flycontrol.vision.smooth.smooth_curve import BoolArray, SmoothCurve, followed_curve, smooth_curve

FloatArray = NDArray[np.float64]

#: Of what the moving reference follows [rad/s]. On simulated flights less than 100 changes nothing; with 300 it takes
#: in errors of roll, which the bands then miss (C).
_CORNER = 150.0
_UPRIGHT = 0.01  #: cosine of pitch


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SmoothTurn:
    """R(t) = A(t) exp[w(t)] at N frames: a moving reference, and small turns about the body's axes."""

    reference: FloatArray  #: A, (N, 3, 3)
    spin: FloatArray  #: (N, 2, 3) of A: angular velocity and its derivative, in A's own axes [rad/s, rad/s^2]
    turns: tuple[SmoothCurve, SmoothCurve, SmoothCurve]  #: w about forward, right, down [rad]

    @property
    def states(self) -> FloatArray:
        """(N, 3, 3) w, w', w'' (second axis) about the three axes (last) [rad, rad/s, rad/s^2]."""
        return np.stack([turn.value for turn in self.turns], axis=2)

    @property
    def covariance(self) -> FloatArray:
        """(N, 3, 3, 3) of w, w', w'' for each axis (second)."""
        return np.stack([turn.covariance for turn in self.turns], axis=1)

    @property
    def set_aside(self) -> BoolArray:
        """(N,) where a turn about any axis was too far from where the other frames expect it."""
        return np.any([turn.set_aside for turn in self.turns], axis=0)

    @property
    def body_axes_W(self) -> FloatArray:
        """R_WB, (N, 3, 3)."""
        return self.at(0.0, self.states)

    def with_common(self, variance: FloatArray) -> SmoothTurn:
        """The same turn, with errors of a variance (N, 3) [rad^2] about the axes that neighbouring frames share."""
        wider = [curve.with_common(more) for curve, more in zip(self.turns, variance.T, strict=True)]
        return replace(self, turns=(wider[0], wider[1], wider[2]))

    def at(self, offset: float, states: FloatArray) -> FloatArray:
        """R_WB (N, 3, 3) a short time [s] later, w and its derivatives (N, 3, 3) [rad, ...; axis last] given."""
        powers = np.array([1.0, offset, offset**2 / 2])
        w = np.einsum("k,nki->ni", powers, states)
        drift = self.spin[:, 0] * offset + self.spin[:, 1] * offset**2 / 2
        return self.reference @ Rotation.from_rotvec(drift).as_matrix() @ Rotation.from_rotvec(w).as_matrix()


def smooth_turn(body_axes_W: FloatArray, spread_B: FloatArray, runs: Sequence[slice], frame_rate: float) -> SmoothTurn:
    """Smooth w_n = log(A_n^T R_n), axis by axis; A is the curve of quaternions that leaves out what is fast.

    Parameters
    ----------
    body_axes_W : R_WB, (N, 3, 3), NaN where not seen
    spread_B : (N, 3) standard deviations of turns about the body's axes [rad]
    runs, frame_rate : as for `smooth_curve`
    """
    seen = np.isfinite(body_axes_W[:, 0, 0])
    q = np.full((len(seen), 4), np.nan)
    q[seen] = _continued(Rotation.from_matrix(body_axes_W[seen]).as_quat())
    slow = np.stack([followed_curve(column, runs, frame_rate, _CORNER) for column in q.T], axis=2)
    reference, spin = _turning(slow)
    w = np.full((len(seen), 3), np.nan)
    w[seen] = Rotation.from_matrix(np.swapaxes(reference[seen], 1, 2) @ body_axes_W[seen]).as_rotvec()
    right, down, forward = (smooth_curve(w[:, k], spread_B[:, k], runs, frame_rate, lasting=1.0) for k in (1, 2, 0))
    return SmoothTurn(reference=reference, spin=spin, turns=(forward, right, down))


def turn_spread(attitude: FloatArray, spread: FloatArray) -> FloatArray:
    """(N, 3) standard deviations of turns about the body's axes, of those of yaw, pitch, roll (N, 3) [rad].

    With independent turns w about the axes,  var yaw = (w_y^2 sin^2 r + w_z^2 cos^2 r) / cos^2 p,
    var pitch = w_y^2 cos^2 r + w_z^2 sin^2 r  and  var roll = w_x^2 + sin^2 p var yaw; the axes y and z, across the
    body, are taken alike. w_x is taken from the frames around where the body is so upright that roll does not tell it.
    """
    yaw, pitch, roll = (spread**2).T
    across = (yaw * np.cos(attitude[:, 1]) ** 2 + pitch) / 2
    along = np.maximum(roll - np.sin(attitude[:, 1]) ** 2 * yaw, across)
    told = np.flatnonzero(np.cos(attitude[:, 1]) > _UPRIGHT)
    if len(told):
        along = np.interp(np.arange(len(along)), told, along[told])
    return np.sqrt(np.stack([along, across, across], axis=1))


def _continued(q: FloatArray) -> FloatArray:
    """The same rotations, each quaternion (N, 4) on the side of the nearest among the three before."""
    same = q.copy()
    for n in range(1, len(same)):
        cosines = same[max(n - 3, 0) : n] @ same[n]
        same[n] *= np.copysign(1.0, cosines[np.argmax(np.abs(cosines))])
    return same


def _turning(slow: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A (N, 3, 3) and its angular velocity and acceleration (N, 2, 3) of a curve of quaternions (N, 3, 4), scalar last.

    Omega = 2 vec(q* q') / |q|^2 and its derivative.
    """
    q, rate, acceleration = slow[:, 0], slow[:, 1], slow[:, 2]
    square = np.sum(q**2, axis=1, keepdims=True)
    omega = 2 * _vector(q, rate) / square
    change = 2 * _vector(q, acceleration) / square - omega * 2 * np.sum(q * rate, axis=1, keepdims=True) / square
    inside = np.isfinite(square[:, 0])
    A = np.full((len(q), 3, 3), np.nan)
    A[inside] = Rotation.from_quat(q[inside]).as_matrix()
    return A, np.stack([omega, change], axis=1)


def _vector(q: FloatArray, p: FloatArray) -> FloatArray:
    """(N, 3) vector part of q* p, scalar last."""
    return q[:, 3:] * p[:, :3] - p[:, 3:] * q[:, :3] - np.cross(q[:, :3], p[:, :3])

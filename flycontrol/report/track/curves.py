"""The coordinates of a tracked flight as they are drawn: in mm and deg, and angles without jumps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flycontrol.model.pose import ANGLES as WING_ANGLES
from flycontrol.model.pose import BASE, Pose
from flycontrol.units import deg, mm, ms
from flycontrol.vision.stance import SIDES
from flycontrol.vision.tracked_flight import TrackedFlight
from flycontrol.vision.tracked_frame import Track

FloatArray = NDArray[np.float64]

ANGLES = slice(3, 12)  #: columns of a pose
_TURNING = (3, 5)  #: those that may go round: yaw and roll
_MIDDLES = np.deg2rad([0, 0, 0, 0, 0, 90, 0, 0, 90])  #: about which the angles are written otherwise [rad]
UNITS = np.concatenate([np.full(3, mm), np.full(9, deg), np.full(6, mm)])  #: that the columns are shown in
TURN = 2 * np.pi
SIGMAS = 1.959964  #: standard deviations on each side of a 95 % band


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curves:
    """N instants [ms] of 18 coordinates [mm, deg]."""

    time: FloatArray  #: (N,)
    raw: FloatArray  #: (N, 18) what was seen, NaN elsewhere
    smooth: FloatArray  #: (N, 18)
    half_band: FloatArray  #: (N, 18) of the smoothed ones, 95 %
    truth: FloatArray | None  #: (N, 18)


def curves(flight: TrackedFlight) -> Curves:
    """Yaw and roll go on where they were, and may pass 180 deg; wing angles are written within half a turn."""
    smooth = continued(flight.smoothed.pose.coordinates)
    raw = continued(np.where(coordinates_seen(flight.track), flight.track.pose.coordinates, np.nan))
    truth = None if flight.truth is None else beside(continued(flight.truth.coordinates), smooth) / UNITS
    return Curves(
        time=flight.time / ms,
        raw=beside(raw, smooth) / UNITS,
        smooth=smooth / UNITS,
        half_band=SIGMAS * flight.smoothed.uncertainty / UNITS,
        truth=truth,
    )


def coordinates_seen(track: Track) -> NDArray[np.bool_]:
    """(N, 18) whether a coordinate was seen: the fly was, and its wing is believed."""
    seen = np.repeat(track.believed[:, None], 18, axis=1)
    for k, (_, left, right) in enumerate(track.doubts):
        for side in SIDES:
            if left if side == "left" else right:
                seen[k, WING_ANGLES[side]] = seen[k, BASE[side]] = False
    return seen


def continued(coordinates: FloatArray) -> FloatArray:
    """(N, 18) with whole turns added to the angles: yaw and roll without jumps, the others about their middles."""
    X = coordinates.copy()
    X[:, ANGLES] = (X[:, ANGLES] - _MIDDLES + np.pi) % TURN - np.pi + _MIDDLES
    for j in _TURNING:
        known = np.isfinite(X[:, j])
        X[known, j] = np.unwrap(X[known, j])
    return X


def beside(coordinates: FloatArray, guide: FloatArray) -> FloatArray:
    """(N, 18) with as many whole turns added to yaw and to roll as bring them next to a guide on the whole."""
    X = coordinates.copy()
    for j in _TURNING:
        away = guide[:, j] - X[:, j]
        away = away[np.isfinite(away)]
        X[:, j] += TURN * np.rint(np.median(away) / TURN) if len(away) else 0.0
    return X


def true_rates(truth: Pose, time: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Velocity in the world (N, 3) [m/s] and angular velocity in body axes (N, 3) [rad/s], by central differences."""
    if len(time) < 3:
        return np.full((len(time), 3), np.nan), np.full((len(time), 3), np.nan)
    R = Rotation.from_matrix(truth.body_axes_W)
    turn, velocity = np.full((len(time), 3), np.nan), np.gradient(truth.position_W, time, axis=0)
    turn[1:-1] = (R[:-2].inv() * R[2:]).as_rotvec() / (time[2:] - time[:-2])[:, None]
    return np.asarray(velocity, dtype=np.float64), turn

"""A measured flight as a trajectory: noisy poses and wing angles become smooth velocities and accelerations.

Channels are low-passed without delay (Butterworth of fourth order, forward and backward: the gain at f is
1 / (1 + (f / f_c)^8)) and splines of fifth order through them are differentiated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline
from scipy.spatial.transform import Rotation

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.stroke import WingMotion, both_wings
from flycontrol.model.trajectory import Trajectory, rotation_matrices, wing_motion_of
from flycontrol.model.wingbeats import Wingbeats, low_passed, segment_wingbeats

FloatArray = NDArray[np.float64]

#: Wingbeats at either end that a filter's edge spoils.
EDGE = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayBandwidth:
    """Cutoffs of the smoother in wingbeat frequencies.

    Below one wingbeat frequency the body keeps its manoeuvres and loses the shaking by its own wings; wing angles need
    several harmonics, and tracking noise asks for few.
    """

    body: float = 0.6  #: position and attitude
    wings: float = 4.5  #: stroke, deviation, pitch

    def __post_init__(self) -> None:
        if not (self.body > 0 and self.wings > 0):
            raise InvalidParameterError(
                f"ReplayBandwidth.body and .wings must be > 0 wingbeat frequencies, got {self.body!r}, {self.wings!r}."
            )


def replayed(
    recording: Recording,
    beats: Wingbeats | None = None,
    bandwidth: ReplayBandwidth | None = None,
    stroke_plane_angle: float | None = None,
) -> Trajectory:
    """Body and wing motion of a recording with all rates and accelerations.

    Velocity, rotation and their rates follow from position and attitude, w = 2 vec(q* q'), w' = 2 vec(q* q''), so that
    all belong to one motion; recorded velocities are not used. Within `EDGE` wingbeats of either end the filter has no
    samples beyond: compare `inner_wingbeats` only.

    Parameters
    ----------
    recording
        Position, attitude and the angles of both wings.
    beats
        Its wingbeats; by default `segment_wingbeats`.
    bandwidth
        Cutoffs of the smoother.
    stroke_plane_angle
        v_S = Ry(angle) v_B; by default the recording's own [rad].

    Returns
    -------
    Trajectory
        At the recording's N samples; the position is that of the tracked point of the body, wherever that is.

    Raises
    ------
    InvalidInputError
        Position, attitude, a wing or the stroke plane's angle is not known.
    """
    left, right = both_wings(recording)
    beats, bandwidth = beats or segment_wingbeats(recording), bandwidth or ReplayBandwidth()
    position_W, q_WS = _pose(recording, stroke_plane_angle)
    time, frequency = recording.time, beats.mean_frequency
    path = _smooth(position_W, recording, bandwidth.body * frequency)
    body = _body_motion(path, _smooth(_unit(q_WS), recording, bandwidth.body * frequency), time)
    left_motion, left_acceleration = _wing(left, recording, bandwidth.wings * frequency)
    right_motion, right_acceleration = _wing(right, recording, bandwidth.wings * frequency)
    return Trajectory(
        time=time,
        phase=(time - time[0]) * frequency,
        frequency=frequency,
        position_W=_at(path, time, 0),
        q_WS=body.q_WS,
        velocity_S=body.velocity,
        angular_velocity_S=body.spin,
        acceleration_S=body.acceleration,
        angular_acceleration_S=body.spin_rate,
        left=left_motion,
        right=right_motion,
        left_acceleration=left_acceleration,
        right_acceleration=right_acceleration,
        wingbeats=beats.count,
        samples_per_wingbeat=round(recording.rate / frequency),
        status="complete",
    )


def inner_wingbeats(beats: Wingbeats, edge: int = EDGE) -> Wingbeats:
    """Those that are far enough from the ends of the recording for the smoother."""
    if not beats.count > 2 * edge:
        raise InvalidInputError(
            f"{beats.count} wingbeats are too few to leave out {edge} at either end; use a longer recording."
        )
    return replace(beats, reversals=beats.reversals[edge : len(beats.reversals) - edge])


def _pose(recording: Recording, angle: float | None) -> tuple[FloatArray, FloatArray]:
    """Position, and attitude q_WS = q_WB q_BS without jumps of sign."""
    angle = recording.stroke_plane_angle if angle is None else angle
    if recording.position_W is None or recording.q_WB is None or angle is None:
        raise InvalidInputError(
            f"{recording.name}: a replay needs the body's position, its quaternion and the stroke plane's angle; map "
            "them, or give the angle."
        )
    body_from_stroke_plane = Rotation.from_euler("y", -angle)
    q = (Rotation.from_quat(recording.q_WB[:, [1, 2, 3, 0]]) * body_from_stroke_plane).as_quat()[:, [3, 0, 1, 2]]
    turned = np.sum(q[1:] * q[:-1], axis=1) < 0
    sign = np.concatenate([[1.0], np.cumprod(np.where(turned, -1.0, 1.0))])
    return recording.position_W, sign[:, None] * q


def _smooth(samples: FloatArray, recording: Recording, cutoff: float) -> BSpline:
    filtered = np.stack([low_passed(column, recording.rate, cutoff) for column in samples.T], axis=1)
    return make_interp_spline(recording.time, filtered, k=5)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Body:
    q_WS: FloatArray
    velocity: FloatArray
    spin: FloatArray
    acceleration: FloatArray
    spin_rate: FloatArray


def _body_motion(path: BSpline, attitude: BSpline, time: FloatArray) -> _Body:
    """Components in S: v = R^T p', v' = R^T p'' - w x v."""
    norm = np.linalg.norm(attitude(time), axis=1, keepdims=True)  # 1 but for what filtering the components takes away
    q, q_rate, q_acceleration = (_at(attitude, time, order) / norm for order in range(3))
    world_to_S = rotation_matrices(q).transpose(0, 2, 1)
    spin = 2 * _conjugate_product(q, q_rate)
    velocity = np.einsum("nij,nj->ni", world_to_S, _at(path, time, 1))
    acceleration = np.einsum("nij,nj->ni", world_to_S, _at(path, time, 2)) - np.cross(spin, velocity)
    return _Body(
        q_WS=q,
        velocity=velocity,
        spin=spin,
        acceleration=acceleration,
        spin_rate=2 * _conjugate_product(q, q_acceleration),
    )


def _conjugate_product(q: FloatArray, p: FloatArray) -> FloatArray:
    """vec(q* p) of quaternions (N, 4), scalar first."""
    return q[:, :1] * p[:, 1:] - p[:, :1] * q[:, 1:] - np.cross(q[:, 1:], p[:, 1:])


def _wing(angles: WingAngles, recording: Recording, cutoff: float) -> tuple[WingMotion, FloatArray]:
    spline = _smooth(np.stack([angles.stroke, angles.deviation, angles.pitch], axis=1), recording, cutoff)
    at, rate, acceleration = (_at(spline, recording.time, order) for order in range(3))
    return wing_motion_of(at, rate), acceleration


def _at(spline: BSpline, time: FloatArray, order: int) -> FloatArray:
    return np.asarray(spline(time, order), dtype=np.float64)


def _unit(q: FloatArray) -> FloatArray:
    return q / np.linalg.norm(q, axis=1, keepdims=True)

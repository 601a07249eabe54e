"""A simulated flight as cameras would have recorded it: a `Recording` of body and wings, or a `Trial` for a fit.

measured = true + e,    e white, normal, of a given deviation, drawn apart for every channel
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flycontrol.errors import InvalidParameterError
from flycontrol.model.morphology import pitch_rotation
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.stroke import WingMotion
from flycontrol.model.trajectory import Trajectory
from flycontrol.model.trial import Pulse, Trial

FloatArray = NDArray[np.float64]

_SIMULATED = {"source": "simulated, not measured"}


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraNoise:
    """Standard deviations of what cameras get wrong in every frame."""

    yaw: float = 0.0  #: and the other two angles of the body's attitude [rad]
    wing_angle: float = 0.0  #: stroke, deviation, pitch [rad]
    position: float = 0.0  #: along each axis [m]

    def __post_init__(self) -> None:
        for name, unit in (("yaw", "rad"), ("wing_angle", "rad"), ("position", "m")):
            if not (getattr(self, name) >= 0 and np.isfinite(getattr(self, name))):
                raise InvalidParameterError(f"CameraNoise.{name} must be >= 0 {unit}, got {getattr(self, name)!r}.")


PERFECT = CameraNoise()


def simulated_recording(
    flight: Trajectory,
    name: str,
    *,
    stroke_plane_angle: float,
    noise: CameraNoise = PERFECT,
    rng: np.random.Generator | None = None,
) -> Recording:
    """Body and wings at the flight's own instants.

    Parameters
    ----------
    flight
        Its sampling is the cameras' frame rate.
    name
        Of the recording.
    stroke_plane_angle
        v_S = Ry(angle) v_B [rad].
    noise
        Of attitude (about the body's axes), position, yaw and wing angles; velocities are left out where it is not
        zero, since cameras know them by differences only.
    rng
        Needed where there is noise.
    """
    if not np.isfinite(stroke_plane_angle):
        raise InvalidParameterError(
            f"simulated_recording needs a finite stroke plane angle in rad, got {stroke_plane_angle!r}."
        )
    attitude = Rotation.from_quat(flight.q_WS, scalar_first=True)
    attitude = attitude * Rotation.from_rotvec(_drawn(rng, noise.yaw, (len(flight.time), 3)))
    body = attitude * Rotation.from_matrix(pitch_rotation(stroke_plane_angle))
    ahead = attitude.as_matrix()[:, :, 0]
    exact = noise == PERFECT
    return Recording(
        name=name,
        rate=flight.frequency * flight.samples_per_wingbeat,
        time=flight.time,
        source_sha256=_hash(flight),
        yaw=np.unwrap(np.arctan2(-ahead[:, 1], ahead[:, 0])),
        position_W=flight.position_W + _drawn(rng, noise.position, flight.position_W.shape),
        velocity_S=flight.velocity_S if exact else None,
        angular_velocity_S=flight.angular_velocity_S if exact else None,
        q_WB=np.asarray(body.as_quat(scalar_first=True), dtype=np.float64),
        stroke_plane_angle=stroke_plane_angle,
        left=_seen(flight.left, noise, rng),
        right=_seen(flight.right, noise, rng),
        notes=_SIMULATED,
    )


def simulated_trial(
    flight: Trajectory,
    name: str,
    pulse: Pulse,
    *,
    fly: str = "",
    noise: CameraNoise = PERFECT,
    rng: np.random.Generator | None = None,
) -> Trial:
    """Yaw at the flight's own instants, paddling once a wingbeat, and the pulse.

    Parameters
    ----------
    flight
        Its sampling is the cameras' frame rate, an even number of frames a wingbeat.
    name, fly
        Of trial and fly.
    pulse
        On the flight's clock.
    noise
        Of yaw and wing angles; d_alpha has that of all its wingbeat's frames.
    rng
        Needed where there is noise.
    """
    frames = flight.samples_per_wingbeat
    if frames % 2:
        raise InvalidParameterError(f"A trial needs an even number of frames a wingbeat, got {frames}.")
    left, right = _seen(flight.left, noise, rng), _seen(flight.right, noise, rng)
    beats = (len(flight.time) - 1) // frames
    weight = 0.5 * (flight.left.stroke_rate**2 + flight.right.stroke_rate**2)[: beats * frames].reshape(beats, frames)
    apart = 0.5 * (right.pitch - left.pitch)[: beats * frames].reshape(beats, frames)
    paddling = np.full(len(flight.time), np.nan)
    paddling[frames // 2 : beats * frames : frames] = (weight * apart).sum(axis=1) / weight.sum(axis=1)
    return Trial(
        name=name,
        fly=fly,
        time=flight.time,
        yaw=flight.yaw + _drawn(rng, noise.yaw, flight.time.shape),
        rate=flight.frequency * frames,
        perturbation=pulse,
        paddling=paddling,
        source_sha256=_hash(flight),
        notes=_SIMULATED,
    )


def _seen(wing: WingMotion, noise: CameraNoise, rng: np.random.Generator | None) -> WingAngles:
    angles = (angle + _drawn(rng, noise.wing_angle, angle.shape) for angle in (wing.stroke, wing.deviation, wing.pitch))
    stroke, deviation, pitch = angles
    return WingAngles(stroke=stroke, deviation=deviation, pitch=pitch)


def _drawn(rng: np.random.Generator | None, deviation: float, shape: tuple[int, ...]) -> FloatArray:
    if deviation == 0:
        return np.zeros(shape)
    if rng is None:
        raise InvalidParameterError("Camera noise needs a random generator; give rng, or no noise.")
    return deviation * rng.standard_normal(shape)


def _hash(flight: Trajectory) -> str:
    states = (flight.time, flight.position_W, flight.q_WS, flight.left.pitch, flight.right.pitch)
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in states)).hexdigest()

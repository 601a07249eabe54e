"""Wing angles in the stroke-plane frame, their rates, the wing's axes and its attack angle.

The package's signs, for both wings alike: stroke phi > 0 is forward (ventral) of the lateral axis, so phi' > 0 on the
forward stroke; deviation theta > 0 is above the stroke plane (dorsal); pitch eta is the angle from the forward
direction of the stroke up to the chord, drawn from trailing to leading edge: 90 deg is a vertical chord.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from flycontrol.errors import InvalidInputError
from flycontrol.model.recording import Recording, WingAngles

FloatArray = NDArray[np.float64]
Side = Literal["left", "right"]
Angle = Literal["stroke", "deviation", "pitch"]

ANGLES: tuple[Angle, ...] = ("stroke", "deviation", "pitch")

FEWEST_SAMPLES = 5  #: five-point differences need as many


@dataclass(frozen=True, slots=True, kw_only=True)
class WingMotion:
    """Angles of one wing [rad] and their rates [rad/s], each of shape (N,)."""

    stroke: FloatArray  #: phi, > 0 forward [rad]
    deviation: FloatArray  #: theta, > 0 dorsal [rad]
    pitch: FloatArray  #: eta, 90 deg = vertical chord [rad]
    stroke_rate: FloatArray  #: phi' [rad/s]
    deviation_rate: FloatArray  #: theta' [rad/s]
    pitch_rate: FloatArray  #: eta' [rad/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class WingAxes:
    """Unit vectors of one wing along forward, right, down of the stroke-plane frame, each of shape (N, 3)."""

    span: FloatArray  #: from the hinge to the tip
    forward: FloatArray  #: d span / d phi: the way of the forward stroke
    upward: FloatArray  #: d span / d theta: the way of rising deviation
    chord: FloatArray  #: from the trailing to the leading edge
    normal: FloatArray  #: perpendicular to span and chord


def derivative(samples: FloatArray, rate: float) -> FloatArray:
    """x'_i = (x_{i-2} - 8 x_{i-1} + 8 x_{i+1} - x_{i+2}) / 12 dt: error (w dt)^4 / 30, 1.6e-3 at 40 samples/3 periods.

    Parameters
    ----------
    samples : (N,) or (N, k) array, any unit
    rate : samples a second [1/s]
    """
    if len(samples) < FEWEST_SAMPLES:
        raise InvalidInputError(f"A rate of change needs at least {FEWEST_SAMPLES} samples, got {len(samples)}.")
    return np.asarray(savgol_filter(samples, FEWEST_SAMPLES, FEWEST_SAMPLES - 1, deriv=1, delta=1.0 / rate, axis=0))


def wing_motion(angles: WingAngles, rate: float) -> WingMotion:
    """Angles of one wing with their rates, differentiated at `rate` [1/s]."""
    return WingMotion(
        stroke=angles.stroke,
        deviation=angles.deviation,
        pitch=angles.pitch,
        stroke_rate=derivative(angles.stroke, rate),
        deviation_rate=derivative(angles.deviation, rate),
        pitch_rate=derivative(angles.pitch, rate),
    )


def both_wings(recording: Recording) -> tuple[WingAngles, WingAngles]:
    """Left and right wing angles, or a sentence when one of them was not measured."""
    if recording.left is None or recording.right is None:
        raise InvalidInputError(
            f"{recording.name}: what a flight says of Eq. 3 needs stroke, deviation and pitch of both wings, but the "
            f"mapping reads {_held(recording)}; map the wings if the file has them, pitch being the angle between "
            "chord and stroke plane and not an attack angle."
        )
    return recording.left, recording.right


def _held(recording: Recording) -> str:
    wings = [side for side, wing in (("left", recording.left), ("right", recording.right)) if wing is not None]
    return f"the {wings[0]} wing alone" if wings else "the body's motion alone"


def wing_axes(motion: WingMotion | WingAngles, side: Side) -> WingAxes:
    """Span e = (sin phi cos theta, +-cos phi cos theta, -sin theta), chord = cos eta forward + sin eta upward.

    The left wing is the mirror image of the right one in the plane y = 0.
    """
    mirror = 1.0 if side == "right" else -1.0
    sin_phi, cos_phi = np.sin(motion.stroke), np.cos(motion.stroke)
    sin_theta, cos_theta = np.sin(motion.deviation), np.cos(motion.deviation)
    sin_eta, cos_eta = np.sin(motion.pitch)[:, None], np.cos(motion.pitch)[:, None]
    span = np.stack([sin_phi * cos_theta, mirror * cos_phi * cos_theta, -sin_theta], axis=1)
    forward = np.stack([cos_phi, -mirror * sin_phi, np.zeros_like(sin_phi)], axis=1)
    upward = np.stack([-sin_phi * sin_theta, -mirror * cos_phi * sin_theta, -cos_theta], axis=1)
    return WingAxes(
        span=span,
        forward=forward,
        upward=upward,
        chord=cos_eta * forward + sin_eta * upward,
        normal=cos_eta * upward - sin_eta * forward,
    )


def attack_angle(pitch: FloatArray, stroke_rate: FloatArray) -> FloatArray:
    """Alpha = eta on the forward stroke, 180 deg - eta on the backward stroke.

    The geometric angle between chord and stroke, without deviation or the body's own motion.

    Parameters
    ----------
    pitch : (N,) eta [rad]
    stroke_rate : (N,) phi' [rad/s]
    """
    return np.where(stroke_rate >= 0.0, pitch, np.pi - pitch)

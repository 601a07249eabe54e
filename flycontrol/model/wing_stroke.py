"""Wing angles over the phase of the wingbeat: Berman & Wang's family, Fourier series, samples; and their modulation.

Phase counts wingbeats: 0 is the dorsal reversal, the forward stroke comes first. Angles are those of
`flycontrol.model.stroke`: (stroke, deviation, pitch), forward, dorsal, 90 deg = vertical chord.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import make_interp_spline

from flycontrol.errors import InvalidInputError, InvalidParameterError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class PhasedAngles:
    """Stroke, deviation and pitch with their derivatives by phase, each (N, 3)."""

    angles: FloatArray  #: [rad]
    first: FloatArray  #: [rad/wingbeat]
    second: FloatArray  #: [rad/wingbeat^2]


class WingStroke(Protocol):
    """Anything that tells the wing's angles at a phase."""

    @property
    def periodic(self) -> bool:
        """Whether every wingbeat is like the first."""
        ...

    def __call__(self, phase: FloatArray) -> PhasedAngles:
        """Angles and derivatives at phases (N,) [wingbeats]."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class BermanWangStroke:
    """phi = phi_0 - phi_m asin(K cos 2 pi p) / asin K, eta = 90 deg + eta_0 - eta_m tanh(C sin(2 pi p + e)) / tanh C.

    theta = theta_0 + theta_m cos(2 pi N p + d).  Berman & Wang 2007, in this package's angles. K -> 0 is a cosine and
    K -> 1 a triangle wave, C -> 0 a sine and large C a square wave.
    """

    stroke_amplitude: float  #: phi_m, half of peak to peak [rad]
    stroke_shape: float = 0.01  #: K, between 0 and 1
    stroke_offset: float = 0.0  #: phi_0, > 0 forward [rad]
    pitch_amplitude: float = np.pi / 4  #: eta_m: mid-stroke chords stand at 90 deg -+ eta_m [rad]
    pitch_shape: float = 0.01  #: C > 0
    pitch_lead: float = 0.0  #: e, > 0: the wing flips before the stroke turns [rad]
    pitch_offset: float = 0.0  #: eta_0 [rad]
    deviation_amplitude: float = 0.0  #: theta_m [rad]
    deviation_order: int = 2  #: N, oscillations a wingbeat
    deviation_phase: float = 0.0  #: d [rad]
    deviation_offset: float = 0.0  #: theta_0 [rad]

    def __post_init__(self) -> None:
        if not 0 < self.stroke_shape < 1:
            raise InvalidParameterError(f"BermanWangStroke.stroke_shape must lie in 0..1, got {self.stroke_shape!r}.")
        if not self.pitch_shape > 0:
            raise InvalidParameterError(f"BermanWangStroke.pitch_shape must be > 0, got {self.pitch_shape!r}.")

    @property
    def periodic(self) -> bool:
        """Every wingbeat is like the first."""
        return True

    def __call__(self, phase: FloatArray) -> PhasedAngles:
        """Angles and derivatives at phases (N,) [wingbeats]."""
        turn = 2 * np.pi
        p = np.asarray(phase, dtype=np.float64)
        stroke = _arcsine(self.stroke_shape, turn * p)
        pitch = _hyperbolic(self.pitch_shape, turn * p + self.pitch_lead)
        beat = turn * self.deviation_order
        swing = beat * p + self.deviation_phase
        a, b, c = -self.stroke_amplitude, self.deviation_amplitude, -self.pitch_amplitude
        return PhasedAngles(
            angles=np.stack(
                [
                    self.stroke_offset + a * stroke[0],
                    self.deviation_offset + b * np.cos(swing),
                    np.pi / 2 + self.pitch_offset + c * pitch[0],
                ],
                axis=-1,
            ),
            first=np.stack([a * turn * stroke[1], -b * beat * np.sin(swing), c * turn * pitch[1]], axis=-1),
            second=np.stack([a * turn**2 * stroke[2], -b * beat**2 * np.cos(swing), c * turn**2 * pitch[2]], axis=-1),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class FourierStroke:
    """x(p) = sum over k of a_k cos 2 pi k p + b_k sin 2 pi k p, for each angle; a_0 is the mean."""

    cosine: FloatArray  #: a_k, (3, K + 1): stroke, deviation, pitch [rad]
    sine: FloatArray  #: b_k, (3, K + 1) [rad]

    def __post_init__(self) -> None:
        if not (self.cosine.shape == self.sine.shape and self.cosine.ndim == 2 and len(self.cosine) == 3):
            raise InvalidParameterError(
                "FourierStroke needs cosine and sine coefficients of equal shape (3, K + 1), "
                f"got {self.cosine.shape} and {self.sine.shape}."
            )

    @property
    def periodic(self) -> bool:
        """Every wingbeat is like the first."""
        return True

    def __call__(self, phase: FloatArray) -> PhasedAngles:
        """Angles and derivatives at phases (N,) [wingbeats]."""
        beat = 2 * np.pi * np.arange(self.cosine.shape[1])
        turn = np.multiply.outer(np.asarray(phase, dtype=np.float64), beat)
        cos, sin = np.cos(turn), np.sin(turn)
        a, b = self.cosine.T, self.sine.T
        return PhasedAngles(
            angles=cos @ a + sin @ b,
            first=cos @ (beat[:, None] * b) - sin @ (beat[:, None] * a),
            second=-cos @ (beat[:, None] ** 2 * a) - sin @ (beat[:, None] ** 2 * b),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class SampledStroke:
    """Quintic splines through samples, so that accelerations are twice differentiable; periodic, or as measured."""

    phase: FloatArray  #: (M,) rising [wingbeats]; a periodic one spans exactly one, its last sample repeats the first
    samples: FloatArray  #: (M, 3) stroke, deviation, pitch [rad]
    periodic: bool = True
    _spline: Any = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        phase, samples = self.phase, self.samples
        if samples.shape != (len(phase), 3) or len(phase) < 6 or not np.all(np.diff(phase) > 0):
            raise InvalidInputError(
                f"SampledStroke needs at least 6 rising phases (M,) and samples (M, 3), got {phase.shape} and "
                f"{samples.shape}."
            )
        if self.periodic:
            jump = float(np.max(np.abs(samples[-1] - samples[0])))
            if not (abs(phase[-1] - phase[0] - 1.0) < 1e-9 and jump < 1e-9):
                raise InvalidInputError(
                    f"A periodic stroke must span one wingbeat and end where it began; it spans "
                    f"{phase[-1] - phase[0]:.6g} and ends {jump:.3g} rad away. Close it, or say periodic=False."
                )
        kind = "periodic" if self.periodic else None
        object.__setattr__(self, "_spline", make_interp_spline(phase, samples, k=5, bc_type=kind))

    def __call__(self, phase: FloatArray) -> PhasedAngles:
        """Angles and derivatives at phases (N,) [wingbeats]; InvalidInputError outside what was measured."""
        p = np.asarray(phase, dtype=np.float64)
        first, last = self.phase[0], self.phase[-1]
        if self.periodic:
            p = first + np.mod(p - first, 1.0)
        elif p.size and not (first - 1e-9 <= p.min() and p.max() <= last + 1e-9):
            raise InvalidInputError(
                f"The stroke was measured from {first:.6g} to {last:.6g} wingbeats and asked for from {p.min():.6g} to "
                f"{p.max():.6g}; ask for less, or give a periodic one."
            )
        return PhasedAngles(angles=self._spline(p), first=self._spline(p, 1), second=self._spline(p, 2))


@dataclass(frozen=True, slots=True, kw_only=True)
class Modulation:
    """What steering changes of one wing's stroke."""

    stroke_gain: float = 0.0  #: relative change of the stroke amplitude
    stroke_offset: float = 0.0  #: > 0: mean stroke position forward [rad]
    deviation_offset: float = 0.0  #: > 0: stroke above the plane [rad]
    pitch_offset: float = 0.0  #: +d_alpha on the forward stroke, -d_alpha on the backward one [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModulatedStroke:
    """A stroke that passes from one modulation to another by 10 s^3 - 15 s^4 + 6 s^5, smooth to the acceleration.

    The stroke amplitude changes about the stroke's mean position.
    """

    stroke: WingStroke
    before: Modulation = Modulation()
    after: Modulation = Modulation()
    ramp: tuple[float, float] = (0.0, 1.0)  #: from where to where on the phase it passes [wingbeats]

    def __post_init__(self) -> None:
        start, end = self.ramp
        if not (np.isfinite(start) and np.isfinite(end) and start < end):
            raise InvalidParameterError(
                f"ModulatedStroke.ramp must end after it starts, both in wingbeats, got {self.ramp!r}."
            )

    @property
    def periodic(self) -> bool:
        """Whether every wingbeat is like the first."""
        return self.before == self.after and self.stroke.periodic

    def __call__(self, phase: FloatArray) -> PhasedAngles:
        """Angles and derivatives at phases (N,) [wingbeats]."""
        p = np.asarray(phase, dtype=np.float64)
        plain = self.stroke(p)
        start, end = self.ramp
        s = np.clip((p - start) / (end - start), 0.0, 1.0)
        passed = np.stack(
            [
                s**3 * (10 - 15 * s + 6 * s**2),
                30 * s**2 * (1 - s) ** 2 / (end - start),
                60 * s * (1 - s) * (1 - 2 * s) / (end - start) ** 2,
            ],
        )
        change = _offsets(self.after) - _offsets(self.before)
        offset = passed[:, :, None] * change
        offset[0] += _offsets(self.before)
        gain = passed * (self.after.stroke_gain - self.before.stroke_gain)
        gain[0] += self.before.stroke_gain
        swing = plain.angles[:, 0] - _mean_stroke(self.stroke)
        first, second = plain.first[:, 0], plain.second[:, 0]
        offset[0, :, 0] += gain[0] * swing
        offset[1, :, 0] += gain[0] * first + gain[1] * swing
        offset[2, :, 0] += gain[0] * second + 2 * gain[1] * first + gain[2] * swing
        return PhasedAngles(
            angles=plain.angles + offset[0], first=plain.first + offset[1], second=plain.second + offset[2]
        )


def paddling(angle: float) -> tuple[Modulation, Modulation]:
    """Modulations of the left and the right wing: right alpha_0 + d_alpha, left alpha_0 - d_alpha going forward.

    Parameters
    ----------
    angle : d_alpha, > 0 turns right [rad]
    """
    return Modulation(pitch_offset=-angle), Modulation(pitch_offset=angle)


def fourier_stroke(phase: FloatArray, samples: ArrayLike, harmonics: int) -> FourierStroke:
    """Least-squares Fourier series through samples of one or more wingbeats.

    Parameters
    ----------
    phase : (M,) [wingbeats]
    samples : (M, 3) stroke, deviation, pitch [rad]
    harmonics : K
    """
    turn = 2 * np.pi * np.multiply.outer(phase, np.arange(harmonics + 1))
    design = np.hstack([np.cos(turn), np.sin(turn[:, 1:])])
    if len(phase) < design.shape[1]:
        raise InvalidInputError(f"{harmonics} harmonics need {design.shape[1]} samples or more, got {len(phase)}.")
    solution = np.linalg.lstsq(design, np.asarray(samples, dtype=np.float64), rcond=None)[0]
    found = np.asarray(solution.T, dtype=np.float64)
    cosine, sine = found[:, : harmonics + 1], found[:, harmonics + 1 :]
    return FourierStroke(cosine=cosine, sine=np.hstack([np.zeros((3, 1)), sine]))


def _arcsine(shape: float, turn: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """asin(K cos x) / asin K and its first two derivatives by x."""
    cos, sin = shape * np.cos(turn), shape * np.sin(turn)
    root = np.sqrt(1 - cos**2)
    scale = 1 / np.arcsin(shape)
    return scale * np.arcsin(cos), -scale * sin / root, -scale * cos * (1 - shape**2) / root**3


def _hyperbolic(shape: float, turn: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """tanh(C sin x) / tanh C and its first two derivatives by x."""
    sin, cos = shape * np.sin(turn), shape * np.cos(turn)
    value = np.tanh(sin)
    slope = 1 - value**2
    scale = 1 / np.tanh(shape)
    return scale * value, scale * slope * cos, -scale * slope * (sin + 2 * value * cos**2)


def _offsets(modulation: Modulation) -> FloatArray:
    return np.array([modulation.stroke_offset, modulation.deviation_offset, modulation.pitch_offset])


def _mean_stroke(stroke: WingStroke) -> float:
    return float(stroke(np.arange(64) / 64).angles[:, 0].mean())

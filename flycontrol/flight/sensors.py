"""What a fly senses of its turning.

An ideal sensor knows heading and rate of heading. A haltere is a gyroscope: it feels the yaw rate r about the stroke
plane's normal, as a low-pass filter after a delay, and what follows it integrates that to an angle:

    tau y' = r(t - delay) - y,    angle' = y

so that PD on that angle is PI on the sensed rate, its integrator started at the heading error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.signal
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyMotion:
    """Turning of the body at N instants, one step apart."""

    heading: FloatArray  #: (3, N) less the heading to hold: angle [rad], rate [rad/s], acceleration [rad/s^2]
    yaw_rate: FloatArray  #: (2, N) about the stroke plane's normal [rad/s], and its rate of change [rad/s^2]


class Sensor(Protocol):
    """Turns motion into a sensed angle, rate and acceleration, (3, N)."""

    @property
    def delay(self) -> float:
        """How late it is, beside its filter's lag [s]."""
        ...

    def sensed(self, motion: BodyMotion, before: FloatArray | None, step: float) -> FloatArray:
        """Sensed angle, rate, acceleration (3, N), undelayed.

        Parameters
        ----------
        motion : at N instants
        before : (3,) what was sensed at the first of them; None at the beginning of a flight
        step : between instants [s]
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class IdealSensor:
    """Heading and its rate as they are."""

    delay: float = 0.0  #: [s]

    def __post_init__(self) -> None:
        _refuse_negative("IdealSensor.delay", self.delay)

    def sensed(self, motion: BodyMotion, before: FloatArray | None, step: float) -> FloatArray:
        """The heading's rows."""
        return motion.heading


@dataclass(frozen=True, slots=True, kw_only=True)
class Haltere:
    """tau y' = r - y, begun settled, and its integral, begun at the heading error."""

    time_constant: float = 0.0  #: tau; 0: the yaw rate as it is [s]
    delay: float = 0.0  #: [s]

    def __post_init__(self) -> None:
        _refuse_negative("Haltere.time_constant", self.time_constant)
        _refuse_negative("Haltere.delay", self.delay)

    def sensed(self, motion: BodyMotion, before: FloatArray | None, step: float) -> FloatArray:
        """Filter and integral of piecewise cubic rates by Simpson's rule: error step^4."""
        r, r_dot = motion.yaw_rate
        start = np.array([motion.heading[0, 0], r[0], 0.0]) if before is None else before
        y, y_dot = (r, r_dot) if self.time_constant == 0 else self._filtered(r, r_dot, start[1], step)
        return np.stack([integrated(y, y_dot, start[0], step), y, y_dot])

    def _filtered(self, r: FloatArray, r_dot: FloatArray, start: float, step: float) -> tuple[FloatArray, FloatArray]:
        """y_{k+1} = E y_k + h / (6 tau) (E r_k + 4 sqrt(E) r_{k+1/2} + r_{k+1}),  E = exp(-h / tau)."""
        tau = self.time_constant
        E = np.exp(-step / tau)
        middle = 0.5 * (r[:-1] + r[1:]) + step / 8 * (r_dot[:-1] - r_dot[1:])
        weights = np.array([E, 4 * np.sqrt(E), 1.0])
        gain = (1 - E) / weights.sum()  # step / (6 tau), but a constant rate is sensed as it is
        driven = gain * (weights @ np.stack([r[:-1], middle, r[1:]]))
        y = np.empty(len(r))
        y[0] = start
        y[1:], _ = scipy.signal.lfilter([1.0], [1.0, -E], driven, zi=[E * start])
        return y, (r - y) / tau


def integrated(values: FloatArray, rates: FloatArray, start: float, step: float) -> FloatArray:
    """(N,) integral of a piecewise cubic of given values (N,) and rates (N,), from `start` on."""
    pieces = step / 2 * (values[:-1] + values[1:]) + step**2 / 12 * (rates[:-1] - rates[1:])
    return start + np.concatenate([[0.0], np.cumsum(pieces)])


def _refuse_negative(name: str, value: float) -> None:
    if not (value >= 0 and np.isfinite(value)):
        raise InvalidParameterError(f"{name} must be >= 0 s, got {value!r}.")

"""A fly's own yaw control at the wing level: what it senses, how often, how late, and what it asks its wings for.

    d_alpha(t) = -(k_P psi + k_I z + k_D psi')(t - T),    z' = psi

or the same for a bias d_eta_0 of the hinges' rest angles: whichever the pitch joints take. Gains are in radians of
paddling or bias; restoring ones are positive, as in `YawLoop`, whose torque gains are gamma or gamma mu times these.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.delay_line import DelayLine
from flycontrol.flight.sensors import IdealSensor, Sensor, integrated
from flycontrol.model.yaw import PDController, PIDController

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampling:
    """The command is taken so often a wingbeat and held; a wing passes to a new one smoothly."""

    per_wingbeat: int  #: how often
    first: float = 0.0  #: phase at which it is taken first [wingbeats]
    ramp: float = 0.5  #: share of the interval that passing to a new command takes

    def __post_init__(self) -> None:
        if not self.per_wingbeat >= 1:
            raise InvalidParameterError(f"Sampling.per_wingbeat must be at least 1, got {self.per_wingbeat!r}.")
        if not (0 < self.ramp <= 1 and 0 <= self.first < 1):
            raise InvalidParameterError(
                f"Sampling needs 0 < ramp <= 1 and 0 <= first < 1, got {self.ramp!r} and {self.first!r}."
            )

    def held(self, line: DelayLine, phase: FloatArray, frequency: float) -> FloatArray:
        """Command and its derivatives by phase, (3, N), at phases (N,) less the delay [wingbeats]."""
        n = self.per_wingbeat
        at = (phase - self.first) * n
        number = np.floor(at)
        new, old = (line.read((self.first + k / n) / frequency)[0] for k in (number, number - 1))
        s = np.clip((at - number) / self.ramp, 0.0, 1.0)
        over = n / self.ramp
        passed = np.stack([
            s**3 * (10 - 15 * s + 6 * s**2),
            30 * s**2 * (1 - s) ** 2 * over,
            60 * s * (1 - s) * (1 - 2 * s) * over**2,
        ])  # fmt: skip
        command = passed * (new - old)
        command[0] += old
        return command


@dataclass(frozen=True, slots=True, kw_only=True)
class YawFeedback:
    """P, PD, PI or PID control of the sensed yaw angle."""

    gains: PDController | PIDController  #: of paddling or hinge bias, in rad for N m: [1], [1/s], [s]
    delay: float  #: T, beside the sensor's own [s]
    sensor: Sensor = field(default_factory=IdealSensor)
    sampling: Sampling | None = None  #: None: continuous
    limit: float | None = None  #: of the command, reached smoothly as tanh [rad]

    def __post_init__(self) -> None:
        if not isinstance(self.gains, PDController | PIDController):
            raise InvalidParameterError(
                f"YawFeedback.gains must be a PDController or a PIDController, got {self.gains!r}; write "
                "PDController(proportional=..., derivative=...)."
            )
        if not (self.delay >= 0 and np.isfinite(self.delay)):
            raise InvalidParameterError(f"YawFeedback.delay must be >= 0 s, got {self.delay!r}.")
        if self.limit is not None and not (self.limit > 0 and np.isfinite(self.limit)):
            raise InvalidParameterError(f"YawFeedback.limit must be > 0 rad, or None, got {self.limit!r}.")

    @property
    def total_delay(self) -> float:
        """Of sensor and all that follows [s]."""
        return self.delay + self.sensor.delay

    def demand(self, sensed: FloatArray, integral: float, step: float) -> tuple[FloatArray, FloatArray, float]:
        """Command before the delay (N,) [rad], its rate (N,) [rad/s], and the integral z at the end [rad s].

        Parameters
        ----------
        sensed : (3, N) angle, rate, acceleration, one step apart
        integral : z at the first instant [rad s]
        step : [s]
        """
        angle, rate, acceleration = sensed
        command = -(self.gains.proportional * angle + self.gains.derivative * rate)
        slope = -(self.gains.proportional * rate + self.gains.derivative * acceleration)
        if isinstance(self.gains, PIDController):
            z = integrated(angle, rate, integral, step)
            command, slope, integral = command - self.gains.integral * z, slope - self.gains.integral * angle, z[-1]
        if self.limit is not None:
            command = self.limit * np.tanh(command / self.limit)
            slope = slope * (1 - (command / self.limit) ** 2)
        return command, slope, float(integral)

    def command(self, line: DelayLine, phase: FloatArray, frequency: float) -> FloatArray:
        """(3, N) what the wings are asked for [rad] and its derivatives by phase, at phases (N,) [wingbeats]."""
        sensed_at = phase - self.total_delay * frequency
        if self.sampling is not None:
            return self.sampling.held(line, sensed_at, frequency)
        return line.read(sensed_at / frequency) / frequency ** np.arange(3)[:, None]

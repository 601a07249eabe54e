"""The fall of a plate over time."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from flycontrol.errors import InvalidInputError
from flycontrol.flight.falling_plate import FallingPlate, effective_inertias, plate_acceleration

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateMotion:
    """Where a plate is and how it moves at one instant."""

    angle: float  #: theta, the major axis above the horizontal [rad]
    rate: float = 0.0  #: theta' [rad/s]
    velocity: tuple[float, float] = (0.0, 0.0)  #: along the major and the minor axis [m/s]
    position: tuple[float, float] = (0.0, 0.0)  #: x and y of the centre, y up [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlateFall:
    """A fall, sample by sample."""

    plate: FallingPlate
    time: FloatArray  #: (N,) [s]
    velocity: FloatArray  #: (N, 2) along the major and the minor axis [m/s]
    rate: FloatArray  #: (N,) theta' [rad/s]
    angle: FloatArray  #: (N,) theta, not wrapped [rad]
    position: FloatArray  #: (N, 2) x and y of the centre, y up [m]

    def after(self, time: float) -> PlateFall:
        """The samples from a time on [s]."""
        late = self.time >= time
        return PlateFall(
            plate=self.plate,
            time=self.time[late],
            velocity=self.velocity[late],
            rate=self.rate[late],
            angle=self.angle[late],
            position=self.position[late],
        )

    @property
    def turns(self) -> float:
        """Net rotation from the first sample to the last, > 0 from the horizontal upward [turns]."""
        return float(self.angle[-1] - self.angle[0]) / (2 * pi)

    @property
    def swing(self) -> float:
        """Largest less smallest angle: under half a turn and a bit for flutter, without bound for tumbling [rad]."""
        return float(np.ptp(self.angle))

    @property
    def descent_speed(self) -> float:
        """Mean over all samples, > 0 downward [m/s]."""
        return -float((self.position[-1, 1] - self.position[0, 1]) / (self.time[-1] - self.time[0]))

    @property
    def level_times(self) -> FloatArray:
        """When the major axis passes the horizontal: twice a swing or a turn (M,), between samples by chords [s]."""
        height = np.sin(self.angle)
        before = np.nonzero(np.signbit(height[:-1]) != np.signbit(height[1:]))[0]
        part = height[before] / (height[before] - height[before + 1])
        return self.time[before] + part * (self.time[before + 1] - self.time[before])

    @property
    def energy(self) -> FloatArray:
        """Energy of motion, carried fluid included, and of height (N,), over pi rho_f a^2 U^2 a unit of span."""
        along, across, about = effective_inertias(self.plate)
        u, v = self.velocity.T / self.plate.speed
        moving = along * u**2 + across * v**2 + about * (self.rate * self.plate.time) ** 2
        return moving / 2 + self.position[:, 1] / self.plate.half_width


def plate_fall(
    plate: FallingPlate, start: PlateMotion, duration: float, *, samples: int = 2001, tolerance: float = 1e-9
) -> PlateFall:
    """Follow a plate from a start.

    Parameters
    ----------
    duration : [s]; dimensionless for a plate of half width and speed 1
    samples : evenly spaced, first and last instant among them
    tolerance : relative error of a step of DOP853

    Raises
    ------
    InvalidInputError
        No duration, fewer than two samples, or a fall that the integrator could not follow.
    """
    if not (0 < duration < np.inf and samples >= 2):
        raise InvalidInputError(f"A fall needs a duration > 0 s and 2 samples, got {duration!r} s and {samples!r}.")
    u, v = (speed / plate.speed for speed in start.velocity)
    x, y = (place / plate.half_width for place in start.position)
    first = np.array([u, v, start.rate * plate.time, start.angle, x, y])
    time, states = _integrated(plate, first, duration / plate.time, samples, tolerance)
    return PlateFall(
        plate=plate,
        time=time * plate.time,
        velocity=states[:, :2] * plate.speed,
        rate=states[:, 2] / plate.time,
        angle=states[:, 3],
        position=states[:, 4:] * plate.half_width,
    )


def _integrated(
    plate: FallingPlate, first: FloatArray, end: float, samples: int, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """Times (N,) and u, v, w, theta, x, y (N, 6), dimensionless."""

    def change(_: float, state: FloatArray) -> tuple[float, ...]:
        u, v, w, theta = state[:4].tolist()
        c, s = cos(theta), sin(theta)
        return (*plate_acceleration(plate, u, v, w, theta), w, u * c - v * s, u * s + v * c)

    instants = np.linspace(0.0, end, samples)
    found = cast(Any, solve_ivp(change, (0.0, end), first, "DOP853", instants, rtol=tolerance, atol=1e-3 * tolerance))
    if not found.success:
        raise InvalidInputError(f"The fall could not be followed to its end: {found.message}")
    return found.t, found.y.T

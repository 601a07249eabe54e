"""Forces and torques on the body from outside: a magnetic coil, a gust, a finger."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError

FloatArray = NDArray[np.float64]
Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyPulse:
    """A constant force and torque on the body, frame S, from `start` for `duration`."""

    start: float  #: [s]
    duration: float  #: [s]
    torque_S: Vector = (0.0, 0.0, 0.0)  #: about forward, right, down; [2] > 0 turns right [N m]
    force_S: Vector = (0.0, 0.0, 0.0)  #: at the body's centre of mass [N]

    def __post_init__(self) -> None:
        if not (self.duration > 0 and np.isfinite(self.start + self.duration)):
            raise InvalidParameterError(
                f"BodyPulse needs a finite start and a duration > 0 s, got {self.start!r} and {self.duration!r}."
            )
        if not np.all(np.isfinite([*self.torque_S, *self.force_S])):
            raise InvalidParameterError("BodyPulse needs finite forces and torques.")


def refuse_idle_pulses(pulses: Sequence[BodyPulse], wingbeats: int, frequency: float) -> None:
    """InvalidParameterError where a pulse never acts in a flight of so many wingbeats at a frequency [1/s]."""
    end = wingbeats / frequency
    for pulse in pulses:
        if pulse.start + pulse.duration <= 0 or pulse.start >= end:
            raise InvalidParameterError(
                f"A pulse must act during the flight of {wingbeats} wingbeats, 0 to {end:.6g} s, got one from "
                f"{pulse.start:.6g} to {pulse.start + pulse.duration:.6g} s; move it (times are in seconds), or fly on."
            )


def outside_loads(pulses: Sequence[BodyPulse], start: float, step: float, steps: int) -> FloatArray:
    """(steps, 6) force and torque during each step, frame S [N, N m].

    A step that a pulse covers in part has its share of it: the impulse is exact whether or not edges lie on the grid.
    """
    edges = start + step * np.arange(steps + 1)
    loads = np.zeros((steps, 6))
    for pulse in pulses:
        inside = np.clip(edges, pulse.start, pulse.start + pulse.duration)
        loads += np.multiply.outer(np.diff(inside) / step, np.array([*pulse.force_S, *pulse.torque_S]))
    return loads

"""What a hover trim may move: parameters of a symmetric stroke, its frequency, the pitch that the body is flown at.

A stroke's own parameters are replaced; what it has no parameter for is a modulation of it, so that measured strokes can
be trimmed too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import ModulatedStroke, Modulation, WingStroke
from flycontrol.units import deg

FloatArray = NDArray[np.float64]
Limits = Mapping[str, tuple[float, float]]

FREQUENCY, BODY_PITCH = "frequency", "body_pitch"

#: Least and largest value [rad; the gain relative]; that of the frequency is half and twice what it was.
LIMITS: Limits = {
    "stroke_amplitude": (5 * deg, 90 * deg),
    "stroke_offset": (-45 * deg, 45 * deg),
    "pitch_amplitude": (5 * deg, 85 * deg),
    "pitch_offset": (-45 * deg, 45 * deg),
    "pitch_lead": (-60 * deg, 60 * deg),
    "deviation_offset": (-45 * deg, 45 * deg),
    "stroke_gain": (-0.5, 1.0),
    BODY_PITCH: (-80 * deg, 80 * deg),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class FlownStroke:
    """A stroke, and the mean pitch of the stroke plane that it is flown at."""

    kinematics: StrokeKinematics
    body_pitch: float  #: > 0 nose up [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class TrimParameters:
    """Three named numbers of a flown stroke, in units in which all are of the order of 1."""

    names: tuple[str, ...]
    start: FlownStroke
    limits: Limits

    def __post_init__(self) -> None:
        known = (FREQUENCY, *LIMITS)
        if len(set(self.names)) != 3 or not set(self.names) <= set(known):
            raise InvalidParameterError(
                f"A trim moves three different ones of {', '.join(known)}, got {', '.join(self.names) or 'none'}."
            )
        if unknown := set(self.limits) - set(known):
            raise InvalidParameterError(f"No trim moves {sorted(unknown)}; limits are given to {', '.join(known)}.")
        if missing := [name for name in self.names if name not in (*self._movable, FREQUENCY, BODY_PITCH)]:
            raise InvalidParameterError(
                f"A {type(self.stroke).__name__} has no {' and no '.join(missing)} to move; choose from "
                f"{', '.join((FREQUENCY, BODY_PITCH, *self._movable))}."
            )
        for name, value in zip(self.names, self.guess * self.units, strict=True):
            low, high = self.limit(name)
            if not low < value < high:
                raise InvalidParameterError(
                    f"The trim begins with {name} = {value:.6g}, which is not within its limits {low:.6g} to "
                    f"{high:.6g}; begin between them, or widen them."
                )

    @property
    def stroke(self) -> WingStroke:
        """Of both wings, where the search begins."""
        left, right = self.start.kinematics.left, self.start.kinematics.right
        phase = np.arange(64) / 64
        if left is not right and not np.array_equal(left(phase).angles, right(phase).angles):
            raise InvalidParameterError(
                "Hover is trimmed with the same stroke for both wings, and these two differ; give one of them to both "
                "(StrokeKinematics.symmetric), or seek a periodic_orbit of the stroke as it is."
            )
        return right

    @property
    def _movable(self) -> tuple[str, ...]:
        """Parameters of the stroke, then what a modulation of it can move."""
        return tuple(name for name in LIMITS if name in {*_own(self.stroke), *(f.name for f in fields(Modulation))})

    @property
    def units(self) -> FloatArray:
        """(3,) of the scaled numbers."""
        frequency = self.start.kinematics.frequency
        return np.array([frequency if name == FREQUENCY else 1.0 for name in self.names])

    @property
    def guess(self) -> FloatArray:
        """(3,) where the search begins, scaled."""
        now = {FREQUENCY: self.start.kinematics.frequency, BODY_PITCH: self.start.body_pitch, **_own(self.stroke)}
        return np.array([now.get(name, 0.0) for name in self.names]) / self.units

    def limit(self, name: str) -> tuple[float, float]:
        """Least and largest value [rad, 1/s]."""
        frequency = self.start.kinematics.frequency
        return self.limits.get(name) or LIMITS.get(name) or (0.5 * frequency, 2 * frequency)

    @property
    def bounds(self) -> FloatArray:
        """(2, 3) least and largest scaled values."""
        return np.array([self.limit(name) for name in self.names]).T / self.units

    def values(self, scaled: FloatArray) -> dict[str, float]:
        """By name [rad, 1/s]."""
        return {name: float(value) for name, value in zip(self.names, scaled * self.units, strict=True)}

    def scaled(self, values: Mapping[str, float]) -> FloatArray:
        """(3,) of values by name."""
        return np.array([values[name] for name in self.names]) / self.units

    def at(self, scaled: FloatArray) -> FlownStroke:
        """The stroke with these numbers in place."""
        values = self.values(scaled)
        pitch = values.pop(BODY_PITCH, self.start.body_pitch)
        frequency = values.pop(FREQUENCY, self.start.kinematics.frequency)
        kinematics = StrokeKinematics.symmetric(_moved(self.stroke, values), frequency)
        return FlownStroke(kinematics=kinematics, body_pitch=pitch)


def _own(stroke: WingStroke) -> dict[str, Any]:
    """The stroke's parameters by name."""
    return {f.name: getattr(stroke, f.name) for f in fields(stroke)} if is_dataclass(stroke) else {}


def _moved(stroke: WingStroke, values: Mapping[str, float]) -> WingStroke:
    """The stroke with its own parameters replaced and the others as a modulation."""
    own = {name: value for name, value in values.items() if name in _own(stroke)}
    steered = Modulation(**{name: value for name, value in values.items() if name not in own})
    moved: Any = replace(stroke, **own) if own and is_dataclass(stroke) else stroke
    return moved if steered == Modulation() else ModulatedStroke(stroke=moved, before=steered, after=steered)

"""What a hover trim may move: parameters of a symmetric stroke, its frequency, the pitch that the body is flown at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import BermanWangStroke
from flycontrol.units import deg

FloatArray = NDArray[np.float64]
Limits = Mapping[str, tuple[float, float]]

FREQUENCY, BODY_PITCH = "frequency", "body_pitch"

#: Least and largest value [rad]; that of the frequency is half and twice what it was.
LIMITS: Limits = {
    "stroke_amplitude": (5 * deg, 90 * deg),
    "stroke_offset": (-45 * deg, 45 * deg),
    "pitch_amplitude": (5 * deg, 85 * deg),
    "pitch_offset": (-45 * deg, 45 * deg),
    "pitch_lead": (-60 * deg, 60 * deg),
    "deviation_offset": (-45 * deg, 45 * deg),
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
        for name, value in zip(self.names, self.guess * self.units, strict=True):
            low, high = self.limit(name)
            if not low < value < high:
                raise InvalidParameterError(
                    f"The trim begins with {name} = {value:.6g}, which is not within its limits {low:.6g} to "
                    f"{high:.6g}; begin between them, or widen them."
                )

    @property
    def stroke(self) -> BermanWangStroke:
        """Of both wings, where the search begins."""
        left, right = self.start.kinematics.left, self.start.kinematics.right
        if not (isinstance(right, BermanWangStroke) and left == right):
            raise InvalidParameterError(
                "Hover is trimmed with one BermanWangStroke for both wings; fit that family to the stroke that you "
                "have, or trim the built-in one."
            )
        return right

    @property
    def units(self) -> FloatArray:
        """(3,) of the scaled numbers."""
        frequency = self.start.kinematics.frequency
        return np.array([frequency if name == FREQUENCY else 1.0 for name in self.names])

    @property
    def guess(self) -> FloatArray:
        """(3,) where the search begins, scaled."""
        now = {FREQUENCY: self.start.kinematics.frequency, BODY_PITCH: self.start.body_pitch}
        values = [now[name] if name in now else getattr(self.stroke, name) for name in self.names]
        return np.array(values) / self.units

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
        kinematics = StrokeKinematics.symmetric(replace(self.stroke, **values), frequency)
        return FlownStroke(kinematics=kinematics, body_pitch=pitch)

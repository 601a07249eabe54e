"""A stroke steered by any number of changes, each smooth to the acceleration, added to one another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.wing_stroke import Modulation, PhasedAngles, WingStroke

FloatArray = NDArray[np.float64]

_SAMPLES = 64  #: of a wingbeat, for its mean


@dataclass(frozen=True, slots=True, kw_only=True)
class StrokeChange:
    """What is added to a stroke, from nothing at `start` to all of it at `end`."""

    change: Modulation
    start: float  #: [wingbeats]
    end: float  #: [wingbeats]

    def __post_init__(self) -> None:
        if not self.end > self.start:
            raise InvalidParameterError(
                f"A change of the stroke takes time: it must end after it starts, got {self.start!r} to {self.end!r} "
                "wingbeats."
            )

    def passed(self, phase: FloatArray) -> FloatArray:
        """10 s^3 - 15 s^4 + 6 s^5 and its first two derivatives by phase, (3, N)."""
        over = self.end - self.start
        s = np.clip((phase - self.start) / over, 0.0, 1.0)
        return np.stack([
            s**3 * (10 - 15 * s + 6 * s**2),
            30 * s**2 * (1 - s) ** 2 / over,
            60 * s * (1 - s) * (1 - 2 * s) / over**2,
        ])  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class SteeredStroke:
    """x(p) + sum of s_k(p) dx_k; a stroke gain g swings about the plain stroke's mean: g s_k (phi - mean phi)."""

    stroke: WingStroke
    changes: tuple[StrokeChange, ...]

    @property
    def periodic(self) -> bool:
        """Whether every wingbeat is like the first."""
        return not self.changes and self.stroke.periodic

    def __call__(self, phase: FloatArray) -> PhasedAngles:
        """Angles and derivatives at phases (N,) [wingbeats]."""
        p = np.asarray(phase, dtype=np.float64)
        plain = self.stroke(p)
        motion = np.stack([plain.angles, plain.first, plain.second])
        swing = motion[:, :, 0].copy()
        swing[0] -= self._mean_stroke
        for each in self.changes:
            s = each.passed(p)
            offset = [each.change.stroke_offset, each.change.deviation_offset, each.change.pitch_offset]
            motion += s[:, :, None] * np.array(offset)
            gain = each.change.stroke_gain * s
            motion[0, :, 0] += gain[0] * swing[0]
            motion[1, :, 0] += gain[0] * swing[1] + gain[1] * swing[0]
            motion[2, :, 0] += gain[0] * swing[2] + 2 * gain[1] * swing[1] + gain[2] * swing[0]
        return PhasedAngles(angles=motion[0], first=motion[1], second=motion[2])

    @property
    def _mean_stroke(self) -> float:
        return float(self.stroke(np.arange(_SAMPLES) / _SAMPLES).angles[:, 0].mean())

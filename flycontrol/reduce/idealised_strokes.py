"""Strokes with a part of their motion taken away, to see what that part does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.wing_stroke import PhasedAngles, WingStroke

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelStroke:
    """The stroke without its deviation."""

    stroke: WingStroke

    @property
    def periodic(self) -> bool:
        """Whether every wingbeat is like the first."""
        return self.stroke.periodic

    def __call__(self, phase: FloatArray) -> PhasedAngles:
        """Angles and derivatives at phases (N,) [wingbeats]."""
        kept = np.array([1.0, 0.0, 1.0])
        full = self.stroke(phase)
        return PhasedAngles(angles=full.angles * kept, first=full.first * kept, second=full.second * kept)


@dataclass(frozen=True, slots=True, kw_only=True)
class SquareStroke:
    """The stroke at one attack angle throughout: eta = alpha_0 forward, 180 deg - alpha_0 back.

    The pitch switches at reversal and has no rate.
    """

    stroke: WingStroke
    attack: float  #: alpha_0 [rad]

    @property
    def periodic(self) -> bool:
        """Whether every wingbeat is like the first."""
        return self.stroke.periodic

    def __call__(self, phase: FloatArray) -> PhasedAngles:
        """Angles and derivatives at phases (N,) [wingbeats]."""
        full = self.stroke(phase)
        kept = np.array([1.0, 1.0, 0.0])
        angles = full.angles * kept
        angles[:, 2] = np.where(full.first[:, 0] >= 0, self.attack, np.pi - self.attack)
        return PhasedAngles(angles=angles, first=full.first * kept, second=full.second * kept)

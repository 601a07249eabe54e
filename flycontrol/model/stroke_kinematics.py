"""The stroke of both wings at a wingbeat frequency."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.stroke import Side, WingMotion
from flycontrol.model.wing_stroke import BermanWangStroke, ModulatedStroke, Modulation, PhasedAngles, WingStroke
from flycontrol.units import deg

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class StrokeKinematics:
    """What both wings do, against phase [wingbeats]; phase = frequency * time."""

    frequency: float  #: [1/s]
    left: WingStroke
    right: WingStroke

    def __post_init__(self) -> None:
        if not (self.frequency > 0 and np.isfinite(self.frequency)):
            raise InvalidParameterError(f"StrokeKinematics.frequency must be > 0 1/s, got {self.frequency!r}.")

    @classmethod
    def symmetric(cls, stroke: WingStroke, frequency: float) -> StrokeKinematics:
        """Both wings in step, mirror images of one another."""
        return cls(frequency=frequency, left=stroke, right=stroke)

    def modulated(self, left: Modulation, right: Modulation) -> StrokeKinematics:
        """The same stroke, steered from its first wingbeat on."""
        return replace(
            self,
            left=ModulatedStroke(stroke=self.left, before=left, after=left),
            right=ModulatedStroke(stroke=self.right, before=right, after=right),
        )

    def wing(self, side: Side) -> WingStroke:
        """The stroke of one wing."""
        return self.left if side == "left" else self.right

    def motion(self, phase: FloatArray, side: Side) -> tuple[WingMotion, FloatArray]:
        """Angles and rates of one wing at phases (N,), and the angles' accelerations (N, 3) [rad/s^2]."""
        at: PhasedAngles = self.wing(side)(np.asarray(phase, dtype=np.float64))
        first = at.first * self.frequency
        motion = WingMotion(
            stroke=at.angles[:, 0],
            deviation=at.angles[:, 1],
            pitch=at.angles[:, 2],
            stroke_rate=first[:, 0],
            deviation_rate=first[:, 1],
            pitch_rate=first[:, 2],
        )
        return motion, at.second * self.frequency**2


def hover_stroke(frequency: float = 220.0) -> StrokeKinematics:
    """A stroke near hover of the published *D. melanogaster*: amplitude as published, shape by calibration (C).

    70 deg to either side, chords 45 deg at mid-stroke, a flip slightly before the turn. It is not trimmed: a trim moves
    frequency, stroke offset and pitch offset until forces and torques balance.
    """
    return StrokeKinematics.symmetric(
        BermanWangStroke(
            stroke_amplitude=70 * deg,
            stroke_shape=0.7,
            pitch_amplitude=45 * deg,
            pitch_shape=2.0,
            pitch_lead=5 * deg,
        ),
        frequency,
    )

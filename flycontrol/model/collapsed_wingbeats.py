"""The wingbeats of a turn laid over one another: what both wings do over the phase, and how it scatters."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from flycontrol.errors import InvalidInputError
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.stroke import ANGLES, Side, both_wings
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import FourierStroke, fourier_stroke
from flycontrol.model.wingbeats import Wingbeats, phase_average

FloatArray = NDArray[np.float64]

PHASES = 100  #: points a wingbeat
HARMONICS = 6  #: of the mean wingbeat; more would follow the noise of tracked wings


@dataclass(frozen=True, slots=True, kw_only=True)
class CollapsedWingbeats:
    """n wingbeats of both wings on their own phase; angles are stroke, deviation, pitch."""

    phase: FloatArray  #: (m,) 0 is the dorsal reversal, 1 (not included) the next [wingbeats]
    durations: FloatArray  #: (n,) [s]
    left: FloatArray  #: (n, m, 3) [rad]
    right: FloatArray  #: (n, m, 3) [rad]
    left_drift: FloatArray  #: (n, 3) by how much a wingbeat ends above where it began [rad]
    right_drift: FloatArray  #: (n, 3) [rad]

    @property
    def count(self) -> int:
        """Wingbeats."""
        return len(self.durations)

    @property
    def asymmetry(self) -> FloatArray:
        """Half of right less left, (n, m, 3) [rad]; that of pitch is the paddling angle."""
        return 0.5 * (self.right - self.left)

    def wing(self, side: Side) -> FloatArray:
        """Angles of one wing, (n, m, 3) [rad]."""
        return self.left if side == "left" else self.right

    def mean(self, side: Side) -> FloatArray:
        """Phase average of one wing, (m, 3) [rad]."""
        return self.wing(side).mean(axis=0)

    def spread(self, side: Side) -> FloatArray:
        """Standard deviation over the wingbeats, (m, 3) [rad]; not a number of a single one."""
        return self.wing(side).std(axis=0, ddof=1) if self.count > 1 else np.full(self.left.shape[1:], np.nan)

    def drawn(self, picks: NDArray[np.intp]) -> CollapsedWingbeats:
        """Some of the wingbeats, some perhaps more than once."""
        names = ("durations", "left", "right", "left_drift", "right_drift")
        return replace(self, **{name: getattr(self, name)[picks] for name in names})

    def mean_stroke(self, harmonics: int = HARMONICS) -> StrokeKinematics:
        """The mean wingbeat as a stroke that repeats: Fourier series of the means less their drift over the beat."""
        return StrokeKinematics(
            frequency=1.0 / float(self.durations.mean()),
            left=self._closed(self.left, self.left_drift, harmonics),
            right=self._closed(self.right, self.right_drift, harmonics),
        )

    def _closed(self, angles: FloatArray, drift: FloatArray, harmonics: int) -> FourierStroke:
        line = np.multiply.outer(self.phase - 0.5, drift.mean(axis=0))
        return fourier_stroke(self.phase, angles.mean(axis=0) - line, harmonics)


def collapsed_wingbeats(recording: Recording, beats: Wingbeats, samples: int = PHASES) -> CollapsedWingbeats:
    """Collapse the wingbeats of a recording, or those of one of its turns (`wingbeats_between`).

    Parameters
    ----------
    recording : angles of both wings
    beats : wingbeats to collapse
    samples : points a wingbeat

    Raises
    ------
    InvalidInputError
        A wing was not measured, or there is no wingbeat.
    """
    if beats.count < 1:
        raise InvalidInputError(f"{recording.name}: no wingbeat to collapse; give two reversals or more.")
    left, right = both_wings(recording)

    def angles(wing: WingAngles) -> FloatArray:
        channels = [phase_average(getattr(wing, name), recording.time, beats, samples).beats for name in ANGLES]
        return np.stack(channels, axis=-1)

    def drift(wing: WingAngles) -> FloatArray:
        channels = np.stack([getattr(wing, name) for name in ANGLES], axis=1)
        return np.diff(CubicSpline(recording.time, channels)(beats.reversals), axis=0)

    return CollapsedWingbeats(
        phase=np.arange(samples) / samples,
        durations=beats.durations,
        left=angles(left),
        right=angles(right),
        left_drift=drift(left),
        right_drift=drift(right),
    )


def wingbeats_between(beats: Wingbeats, first: int, last: int) -> Wingbeats:
    """Wingbeats `first` to `last`, both included, counted from 0."""
    if not 0 <= first <= last < beats.count:
        raise InvalidInputError(f"Wingbeats {first} to {last} are not among 0 to {beats.count - 1}.")
    return replace(beats, reversals=beats.reversals[first : last + 2])

"""How far a track of a simulated flight is from its truth, coordinate by coordinate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.pose import Pose
from flycontrol.report.track.curves import ANGLES, SIGMAS, UNITS, coordinates_seen
from flycontrol.vision.tracked_flight import TrackedFlight

FloatArray = NDArray[np.float64]

NAMES = (
    "x", "y", "z", "Yaw", "Pitch", "Roll", "Left stroke", "Left deviation", "Left wing pitch", "Right stroke",
    "Right deviation", "Right wing pitch", "Left base, forward", "Left base, right", "Left base, down",
    "Right base, forward", "Right base, right", "Right base, down",
)  # fmt: skip
#: Root-mean-square errors that the fitted fly shall not exceed at 35 px/mm and three orthogonal views [deg].
AIMS = {3: 1.0, 4: 1.0, 5: 3.0, 6: 2.0, 7: 2.0, 8: 5.0, 9: 2.0, 10: 2.0, 11: 5.0}


@dataclass(frozen=True, slots=True, kw_only=True)
class CoordinateError:
    """One coordinate, over the frames in which the fly was seen, and a wing's as it was itself seen [mm, deg]."""

    name: str
    unit: str
    raw: float  #: root mean square, of what was seen
    smoothed: float
    in_band: float  #: share of frames whose truth is in the smoothed curve's 95 % band
    aim: float | None


def coordinate_errors(flight: TrackedFlight, truth: Pose) -> list[CoordinateError]:
    """All coordinates, in the order of the pose's columns; NaN where the fly was never seen."""
    raw, smooth = _differences(flight, truth)
    seen = flight.track.believed
    inside = np.abs(smooth) <= SIGMAS * flight.smoothed.uncertainty[seen]
    known = np.all(np.isfinite(smooth), axis=1)
    return [
        CoordinateError(
            name=name,
            unit="deg" if j in range(ANGLES.start, ANGLES.stop) else "mm",
            raw=_rms(raw[:, j]) / UNITS[j],
            smoothed=_rms(smooth[:, j]) / UNITS[j],
            in_band=float(np.mean(inside[known, j])) if np.any(known) else np.nan,
            aim=AIMS.get(j),
        )
        for j, name in enumerate(NAMES)
    ]


def rms_errors(flight: TrackedFlight, truth: Pose) -> tuple[FloatArray, FloatArray]:
    """(18,) root mean squares of `coordinate_errors`, raw and smoothed [m, rad]."""
    raw, smooth = (np.array([_rms(away) for away in each.T]) for each in _differences(flight, truth))
    return raw, smooth


def _differences(flight: TrackedFlight, truth: Pose) -> tuple[FloatArray, FloatArray]:
    """(M, 18) of the frames in which the fly was seen, raw and smoothed; NaN where a wing was not, raw."""
    seen = flight.track.believed
    raw, smooth = (
        _apart(pose.coordinates, truth.coordinates)[seen] for pose in (flight.track.pose, flight.smoothed.pose)
    )
    return np.where(coordinates_seen(flight.track)[seen], raw, np.nan), smooth


def _apart(pose: FloatArray, truth: FloatArray) -> FloatArray:
    """Differences, those of angles within half a turn."""
    away = pose - truth
    away[:, ANGLES] = (away[:, ANGLES] + np.pi) % (2 * np.pi) - np.pi
    return away


def _rms(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(np.square(known)))) if len(known) else np.nan

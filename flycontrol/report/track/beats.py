"""How fast tracked wings beat, and which piece of a flight shows them closely."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from flycontrol.model.wingbeats import SMALLEST_STROKE
from flycontrol.vision.tracked_flight import TrackedFlight

FloatArray = NDArray[np.float64]

CLOSELY = 4  #: wingbeats of the piece that is shown closely
_SHORT = 7  #: wingbeats that can be read without
_UNEVEN = 0.4  #: of the mean period, from the shortest to the longest
_FRAMES_CLOSELY = 150  #: of the piece where the wings' rhythm is not known


@dataclass(frozen=True, slots=True, kw_only=True)
class StrokeReversals:
    """Where the mean stroke angle of both wings turns round, in the longest piece of a flight without a gap."""

    ventral: FloatArray  #: foremost [s]
    dorsal: FloatArray  #: backmost [s]

    @property
    def periods(self) -> FloatArray:
        """From each reversal to the next of its kind [s]."""
        return np.concatenate([np.diff(self.ventral), np.diff(self.dorsal)])

    @property
    def frequency(self) -> float | None:
        """Wingbeats a second; None where no whole one was seen, or where they are too uneven to be wingbeats."""
        if not len(self.periods) or np.ptp(self.periods) > _UNEVEN * np.mean(self.periods):
            return None
        return 1 / float(np.mean(self.periods))


def stroke_reversals(flight: TrackedFlight) -> StrokeReversals:
    """Extremes of the smoothed stroke angle, by the parabola through three samples; none in wings that hardly move."""
    pose = flight.smoothed.pose
    stroke = (pose.wing("left").stroke + pose.wing("right").stroke) / 2
    rows = _longest_run(np.isfinite(stroke))
    time, stroke = flight.time[rows], stroke[rows]
    if len(stroke) < 5 or float(np.ptp(stroke)) < SMALLEST_STROKE:
        return StrokeReversals(ventral=np.empty(0), dorsal=np.empty(0))
    return StrokeReversals(ventral=_peaks(time, stroke), dorsal=_peaks(time, -stroke))


def piece_shown_closely(flight: TrackedFlight, reversals: StrokeReversals) -> tuple[int, int] | None:
    """First and last frame of the wingbeats over which the heading changes most; None where the whole is short."""
    count, period = len(flight.time), reversals.frequency
    frames = _FRAMES_CLOSELY
    if period is not None and count > 1:
        frames = round(CLOSELY / period / float(flight.time[1] - flight.time[0]))
    if count < frames * (_SHORT / CLOSELY):
        return None
    yaw = flight.smoothed.pose.yaw
    change = np.abs(np.angle(np.exp(1j * (yaw[frames:] - yaw[:-frames]))))
    first = 0 if np.all(np.isnan(change)) else int(np.nanargmax(change))
    return first, first + frames


def _longest_run(good: NDArray[np.bool_]) -> slice:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(np.int8), [0]])))
    if not len(edges):
        return slice(0, 0)
    starts, ends = edges[::2], edges[1::2]
    longest = int(np.argmax(ends - starts))
    return slice(int(starts[longest]), int(ends[longest]))


def _peaks(time: FloatArray, values: FloatArray) -> FloatArray:
    at, _ = find_peaks(values, prominence=0.4 * float(np.ptp(values)))
    before, here, after = values[at - 1], values[at], values[at + 1]
    shift = (after - before) / (2 * (2 * here - before - after))
    return np.asarray(time[at] + shift * (time[1] - time[0]), dtype=np.float64)

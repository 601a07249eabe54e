"""Which frames of a flight are looked at, each by a rule that the page states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.report.track.beats import StrokeReversals
from flycontrol.report.track.spans import unseen
from flycontrol.vision.tracked_flight import TrackedFlight

FloatArray = NDArray[np.float64]

ANGLES = slice(3, 12)  #: columns of a pose


@dataclass(frozen=True, slots=True, kw_only=True)
class ChosenFrame:
    """A frame and why it is looked at."""

    frame: int
    rules: tuple[str, ...]


def chosen_frames(flight: TrackedFlight, reversals: StrokeReversals) -> list[ChosenFrame]:
    """The frames by each rule that finds one; a frame that several rules find comes once, with all of them."""
    by_frame: dict[int, list[str]] = {}
    for rule, frame in (*_of_the_seen(flight, reversals), *_of_the_unseen(flight)):
        by_frame.setdefault(frame, []).append(rule)
    return [ChosenFrame(frame=frame, rules=tuple(rules)) for frame, rules in sorted(by_frame.items())]


def best_frame(flight: TrackedFlight) -> int | None:
    """The seen frame with the highest overlap in the mean of the views."""
    return _extreme(flight, _mean_overlap(flight))


def worst_frame(flight: TrackedFlight) -> int | None:
    """The seen frame with the lowest overlap in the mean of the views."""
    return _extreme(flight, -_mean_overlap(flight))


def _of_the_seen(flight: TrackedFlight, reversals: StrokeReversals) -> list[tuple[str, int]]:
    seen = np.flatnonzero(flight.track.believed)
    rules: list[tuple[str, int | None]] = [
        ("the first in which the fly was seen", int(seen[0]) if len(seen) else None),
        ("the best overlap of fly and silhouettes", best_frame(flight)),
        ("the worst overlap among the frames in which the fly was seen", worst_frame(flight)),
        ("the largest uncertainty of an angle over that angle’s median", _least_certain(flight)),
        ("nearest to the dorsal reversal in the middle of the flight", _near(flight, reversals.dorsal)),
        ("the first that is partial", _first(flight, "partial")),
    ]
    return [(rule, frame) for rule, frame in rules if frame is not None]


def _of_the_unseen(flight: TrackedFlight) -> list[tuple[str, int]]:
    found: list[tuple[str, int]] = []
    for status, rule in (("bridged", "the middle of the longest bridge"), ("lost", "the middle of the longest loss")):
        runs = [span for span in unseen(flight.track) if span.status == status]
        if runs:
            found.append((rule, max(runs, key=len).middle))
    return found


def _mean_overlap(flight: TrackedFlight) -> FloatArray:
    return np.asarray(flight.track.overlap.mean(axis=1), dtype=np.float64)


def _extreme(flight: TrackedFlight, value: FloatArray) -> int | None:
    """The seen frame at which the value is largest."""
    value = np.where(flight.track.believed, value, np.nan)
    return None if np.all(np.isnan(value)) else int(np.nanargmax(value))


def _least_certain(flight: TrackedFlight) -> int | None:
    seen = flight.track.believed
    if not np.any(seen):
        return None
    spread = flight.track.uncertainty[:, ANGLES]
    usual = np.median(spread[seen], axis=0)
    return _extreme(flight, np.max(spread / np.where(usual > 0, usual, 1.0), axis=1))


def _near(flight: TrackedFlight, instants: FloatArray) -> int | None:
    """The seen frame next to that one of the instants [s] which is next to the middle of the flight."""
    seen = np.flatnonzero(flight.track.believed)
    if not len(instants) or not len(seen):
        return None
    middle = (flight.time[0] + flight.time[-1]) / 2
    instant = instants[np.argmin(np.abs(instants - middle))]
    return int(seen[np.argmin(np.abs(flight.time[seen] - instant))])


def _first(flight: TrackedFlight, status: str) -> int | None:
    return flight.track.status.index(status) if status in flight.track.status else None

"""A flight's frames looked through once more, evenly thinned: what the hull covers in each view."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.report.track.overlays import hull_of
from flycontrol.vision.footage import FilmedFrame
from flycontrol.vision.hull import ViewConsistency
from flycontrol.vision.tracked_flight import TrackedFlight

FloatArray = NDArray[np.float64]

MOST = 120  #: frames that are looked through


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Survey:
    """F of N frames in C views."""

    frames: NDArray[np.int_]  #: (F,)
    covered: FloatArray  #: (F, C) pixels of the silhouette under the hull; NaN where there is no hull
    uncovered: FloatArray  #: (F, C) those that another view contradicts
    beyond: FloatArray  #: (F, C) of the hull off the silhouette: what its tolerance forgave

    @property
    def coverage(self) -> FloatArray:
        """(F, C) share of the silhouette under the hull."""
        return self.covered / (self.covered + self.uncovered)

    @property
    def least_covered(self) -> tuple[int, int] | None:
        """Row and view of the most uncovered pixels; None where none are uncovered."""
        missing = np.where(np.isfinite(self.uncovered), self.uncovered, 0.0)
        if not np.any(missing > 0):
            return None
        row, view = np.unravel_index(int(np.argmax(missing)), missing.shape)
        return int(row), int(view)


def surveyed_frames(count: int) -> NDArray[np.int_]:
    """All of a few frames, or so many evenly spread ones."""
    return np.unique(np.linspace(0, count - 1, min(count, MOST)).round().astype(int)) if count else np.empty(0, int)


def consistency_of(flight: TrackedFlight, frame: FilmedFrame) -> tuple[ViewConsistency, ...]:
    """How the hull of a frame covers its silhouettes; nothing where there is no hull."""
    hull = hull_of(frame, flight.cameras, flight.fly.shape)
    return () if hull is None else hull.views


def survey_of(frames: NDArray[np.int_], found: list[tuple[ViewConsistency, ...]], cameras: int) -> Survey:
    """The consistencies of some frames as arrays."""
    nothing = (np.nan,) * cameras
    columns = {
        name: [tuple(float(getattr(view, name)) for view in views) or nothing for views in found]
        for name in ("covered", "uncovered", "beyond")
    }
    as_array = {name: np.array(rows).reshape(len(found), cameras) for name, rows in columns.items()}
    return Survey(frames=frames, **as_array)

"""What was seen of a track: the frames that belong together, part by part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.pose import Pose
from flycontrol.model.stroke import Side
from flycontrol.vision.tracked_frame import Track

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

FEWEST = 8  #: frames seen in a run; fewer do not tell noise from motion
_SIDES: tuple[Side, Side] = ("left", "right")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sight:
    """N frames that belong to runs, one run after the other; in M of them the body was seen."""

    frames: NDArray[np.int_]  #: (N,) their places in the track
    seen: BoolArray  #: (N,)
    runs: Sequence[slice]
    pose: Pose  #: M
    spread: FloatArray  #: (M, 18)
    wing_seen: dict[Side, BoolArray]  #: (M,) each
    wing_runs: dict[Side, Sequence[slice]]  #: within the runs
    frame_rate: float  #: [1/s]

    def among_all(self, rows: FloatArray) -> FloatArray:
        """(N, ...) of (M, ...); NaN where not seen."""
        out = np.full((len(self.seen), *rows.shape[1:]), np.nan)
        out[self.seen] = rows
        return out

    def bridged(self, rows: FloatArray) -> FloatArray:
        """(N, ...) of (M, ...), interpolated where not seen."""
        at = np.arange(len(self.seen))
        columns = [np.interp(at, at[self.seen], column) for column in rows.reshape(len(rows), -1).T]
        return np.stack(columns, axis=1).reshape(len(at), *rows.shape[1:])


def sight_of(track: Track, frame_rate: float, longest_gap: int) -> Sight:
    """The frames of a track from one that was seen to another, without too long a gap [frames] between."""
    seen = _seen(track)
    runs = _runs(seen, longest_gap)
    frames = np.concatenate([np.zeros(0, dtype=np.int_), *(np.arange(run.start, run.stop) for run in runs)])
    ends = np.cumsum([run.stop - run.start for run in runs], dtype=np.int_).tolist()
    joined = [slice(end - (run.stop - run.start), end) for run, end in zip(runs, ends, strict=True)]
    inside = seen[frames]
    doubted = np.array(
        [[bool(why) for why in doubts] for doubts in track.doubts] or np.zeros((len(seen), 3)), dtype=bool
    )
    wings = {side: inside & ~doubted[frames, 1 + k] for k, side in enumerate(_SIDES)}
    return Sight(
        frames=frames,
        seen=inside,
        runs=joined,
        pose=track.pose[frames][inside],
        spread=track.uncertainty[frames][inside],
        wing_seen={side: wings[side][inside] for side in _SIDES},
        wing_runs={side: _runs_within(joined, wings[side], longest_gap) for side in _SIDES},
        frame_rate=frame_rate,
    )


def seen_together(track: Track, longest_gap: int) -> int:
    """The most frames in which the body is seen without too long a gap [frames] between them."""
    return max(len(part) for part in _parts(_seen(track), longest_gap))


def _seen(track: Track) -> BoolArray:
    known = np.isfinite(track.pose.coordinates) & np.isfinite(track.uncertainty) & (track.uncertainty > 0)
    return np.asarray(track.believed, dtype=np.bool_) & known.all(axis=1)


def _parts(seen: BoolArray, longest_gap: int) -> list[NDArray[np.int_]]:
    at = np.flatnonzero(seen)
    return np.split(at, np.flatnonzero(np.diff(at) > longest_gap + 1) + 1)


def _runs(seen: BoolArray, longest_gap: int) -> list[slice]:
    parts = [part for part in _parts(seen, longest_gap) if len(part) >= FEWEST]
    return [slice(int(part[0]), int(part[-1]) + 1) for part in parts]


def _runs_within(runs: Sequence[slice], seen: BoolArray, longest_gap: int) -> list[slice]:
    return [
        slice(run.start + part.start, run.start + part.stop) for run in runs for part in _runs(seen[run], longest_gap)
    ]

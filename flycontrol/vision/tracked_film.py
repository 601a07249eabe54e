"""A whole film tracked, piece by piece; finished pieces are kept, and an interrupted run goes on after them."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from flycontrol.errors import InvalidInputError, OutputError
from flycontrol.jobs.checkpoint import Checkpoint, ChunkFiles, opened
from flycontrol.jobs.packed import Packing, Result, unpacked
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.model.camera import Camera
from flycontrol.vision.fly_size import SizedFly, sized_fly
from flycontrol.vision.follower import Fly, Follower
from flycontrol.vision.footage import Footage
from flycontrol.vision.kept_state import kept, memory_of, remind, restored
from flycontrol.vision.sighting import Sighting, sighting_of
from flycontrol.vision.track import FIRST, NOWHERE, Pursuit
from flycontrol.vision.tracked_frame import Track, TrackedFrame, gathered

_PIECE = FIRST  #: frames; the first piece is the one in which the first pose is looked for


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackedFilm:
    """N frames, and the fly as large as it was taken."""

    track: Track
    sized: SizedFly


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """How a film shall be tracked."""

    fly: Fly
    fit_sizes: bool = True
    refine: bool = True  #: fit the parametric fly to the silhouettes; without, the hull alone is read


def tracked_film(
    footage: Footage,
    cameras: Sequence[Camera],
    asked: Asked,
    checkpoint: Checkpoint | None = None,
    progress: Progress = no_progress,
) -> TrackedFilm:
    """Follow the fly through a film; memory holds silhouettes of 48 frames, and coordinates of all.

    Parameters
    ----------
    footage : films and how silhouettes are made
    cameras : C cameras; the world's z points up
    asked : which fly, and how
    checkpoint : where finished pieces are kept until `Checkpoint.remove`, those found there are not tracked again
    progress : told after every frame how many there are, and how many of them were not seen

    Raises
    ------
    InvalidInputError
        If images do not fit the cameras, or if no fly is found in any frame.
    OutputError
        If a piece cannot be kept, or the folder holds those of another job.
    """
    with contextlib.ExitStack() as stack:
        pieces = _Pieces(range(len(footage)))
        shelf = stack.enter_context(opened(checkpoint, pieces)) if checkpoint else None
        return _Run(footage, cameras, asked, shelf, progress).whole()


@dataclass(frozen=True, slots=True)
class _Pieces:
    """How the film is divided; the first piece that is kept is the fly's size."""

    items: range
    seed: int = 0
    chunk_size: int = _PIECE


@dataclass(slots=True)
class _Run:
    footage: Footage
    cameras: Sequence[Camera]
    asked: Asked
    shelf: ChunkFiles | None
    progress: Progress

    def whole(self) -> TrackedFilm:
        sized = self._sized()
        pursuit = Pursuit(cameras=self.cameras, fly=sized.fly, refine=self.asked.refine)
        track = gathered(self._frames(pursuit), sized.fly.stroke_plane_angle, len(self.cameras))
        if pursuit.follower is None:
            raise InvalidInputError(NOWHERE)
        return TrackedFilm(track=track, sized=sized)

    def _sized(self) -> SizedFly:
        """The first piece that is kept."""
        as_given = SizedFly(fly=self.asked.fly, sizes=None)
        if not self.asked.fit_sizes:
            return as_given
        if (found := self._taken(0)) is not None:
            return restored(found)
        self.progress(0, len(self.footage), "sizes")
        tries = (sized_fly(list(self._sightings(part)), self.cameras, self.asked.fly) for part in self._parts())
        sized = next((each for each in tries if each.sizes is not None), as_given)
        self._keep(0, kept(sized))
        return sized

    def _frames(self, pursuit: Pursuit) -> Iterator[TrackedFrame]:
        counts: Counter[str] = Counter()
        for number, part in enumerate(self._parts(), start=1):
            found = self._taken(number)
            piece = self._tracked(pursuit, part, counts) if found is None else _recalled(pursuit, found)
            if found is None:
                memory = None if pursuit.follower is None else memory_of(pursuit.follower)
                self._keep(number, {"frames": kept(piece), "memory": memory})
            counts.update(frame.status for frame in piece)
            self.progress(part[-1] + 1, len(self.footage), _counted(counts))
            yield from piece

    def _tracked(self, pursuit: Pursuit, part: range, before: Counter[str]) -> list[TrackedFrame]:
        if pursuit.follower is None:
            return pursuit.begun(list(self._sightings(part)))
        counts, piece = before.copy(), list[TrackedFrame]()
        for done, sighting in zip(part, self._sightings(part), strict=True):
            piece.append(pursuit.followed(sighting))
            counts[piece[-1].status] += 1
            self.progress(done + 1, len(self.footage), _counted(counts))
        return piece

    def _parts(self) -> Iterator[range]:
        frames = range(len(self.footage))
        return (frames[start : start + _PIECE] for start in range(0, len(frames), _PIECE))

    def _sightings(self, part: range) -> Iterator[Sighting]:
        return (sighting_of(self.footage.frame(k), self.cameras) for k in part)

    def _taken(self, number: int) -> Any:
        """A piece that was kept, or None."""
        if self.shelf is not None:
            with contextlib.suppress(OutputError):
                return unpacked(self.shelf.take(number))[0]
        return None

    def _keep(self, number: int, piece: Result) -> None:
        if self.shelf is not None:
            packing = Packing()
            packing.add(piece, f"piece {number} of the film")
            self.shelf.keep(number, packing.to_bytes())


def _recalled(pursuit: Pursuit, piece: dict[str, Any]) -> list[TrackedFrame]:
    """Frames tracked by an earlier run, and the follower as it was after them."""
    if (memory := piece["memory"]) is not None:
        if pursuit.follower is None:
            pursuit.follower = Follower(cameras=pursuit.cameras, fly=pursuit.fly, refine=pursuit.refine, start=None)
        remind(pursuit.follower, memory)
    return list(restored(piece["frames"]))


def _counted(counts: Counter[str]) -> str:
    return f"frames ({counts['bridged']} bridged, {counts['lost']} lost)"

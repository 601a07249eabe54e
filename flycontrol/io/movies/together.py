"""What films of several cameras have in common: their length, their clock."""

from __future__ import annotations

from collections.abc import Sequence

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.recorded import Recorded
from flycontrol.io.movies.sparse_movies import SparseMovie
from flycontrol.io.movies.stills import Stills

_SAME = 1e-6  #: relative difference of frame rates that are one

Span = tuple[int, int]


def shared_spans(cameras: Sequence[Recorded]) -> tuple[list[Span], list[str]]:
    """For each camera the first frame and the number of frames that all have, and sentences about what is left out.

    Raises
    ------
    InvalidInputError
        If films that do not say when they begin differ in length, or if the others share no frame.
    """
    starts = [camera.start for camera in cameras if isinstance(camera, SparseMovie) and camera.start is not None]
    if len(starts) == len(cameras):
        return _by_their_starts(cameras, starts)
    lengths = [len(camera) for camera in cameras]
    if len(set(lengths)) > 1:
        found = ", ".join(f"{camera.name} has {n}" for camera, n in zip(cameras, lengths, strict=True))
        raise InvalidInputError(
            f"The cameras' films must have equally many frames, but {found}; cut them to the frames that all have."
        )
    if not lengths[0]:
        raise InvalidInputError(f"Camera {cameras[0].name} has no frames.")
    return [(0, n) for n in lengths], _numbered_otherwise(cameras)


def distinct_names(names: Sequence[str]) -> list[str]:
    """Count those cameras whose files bear one name."""
    return [
        name if names.count(name) == 1 else f"{name} ({names[: k + 1].count(name)})" for k, name in enumerate(names)
    ]


def one_rate(rates: Sequence[tuple[str, float | None]]) -> float | None:
    """Return the frame rate [1/s] that the files state, None if none does; InvalidInputError if they disagree."""
    stated = [(name, rate) for name, rate in rates if rate is not None]
    if not stated:
        return None
    first, rate = stated[0]
    for name, other in stated[1:]:
        if abs(other - rate) > _SAME * rate:
            raise InvalidInputError(
                f"The cameras' files must state one frame rate, but {first} has {rate:g} and {name} {other:g} frames/s."
            )
    return rate


def _numbered_otherwise(cameras: Sequence[Recorded]) -> list[str]:
    """Say that stills of the same instant bear different numbers, if they do."""
    first = [(camera.name, camera.first_number) for camera in cameras if isinstance(camera, Stills)]
    if len({number for _, number in first}) < 2 or any(number is None for _, number in first):
        return []
    found = ", ".join(f"those of {name} with {number}" for name, number in first)
    return [f"The stills begin with different numbers, {found}; the first of each are taken for the same instant."]


def _by_their_starts(cameras: Sequence[Recorded], starts: Sequence[int]) -> tuple[list[Span], list[str]]:
    begin = max(starts)
    offsets = [begin - start for start in starts]
    count = min(len(camera) - offset for camera, offset in zip(cameras, offsets, strict=True))
    if count < 1:
        found = ", ".join(
            f"{camera.name} {start} to {start + len(camera) - 1}" for camera, start in zip(cameras, starts, strict=True)
        )
        raise InvalidInputError(f"The cameras' films have no frame in common: they hold the frames {found}.")
    left_out = any(len(camera) != count for camera in cameras)
    note = f"The cameras' films are cut to the {count} frames that all have, from frame {begin} by their startFrame."
    return [(offset, count) for offset in offsets], [note] if left_out else []

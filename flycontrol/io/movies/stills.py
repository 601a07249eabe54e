"""Stills of one camera, a file a frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.natural_order import gap, natural_key, numbers, words
from flycontrol.io.movies.picture import read_picture
from flycontrol.model.film import ImageArray


@dataclass(frozen=True, slots=True)
class Stills:
    """PNG, TIFF, BMP or JPEG files in the order of their numbers."""

    name: str
    files: tuple[Path, ...]

    def __len__(self) -> int:
        """Count the files."""
        return len(self.files)

    @property
    def first_number(self) -> int | None:
        """Number of the first file, where only one number in their names counts."""
        columns = [column for column in zip(*map(numbers, self.files), strict=True) if len(set(column)) > 1]
        return columns[0][0] if len(columns) == 1 else None

    def where(self, k: int) -> str:
        """Name the file, which has the number of the frame in it."""
        return str(self.files[k])

    def frame(self, k: int) -> ImageArray:
        """Read file k."""
        return read_picture(self.files[k])


def stills_of(name: str, files: Sequence[Path]) -> Stills:
    """Order the stills of one camera.

    Raises
    ------
    InvalidInputError
        If a file is not named like the others, if two bear one number, or if one is missing in their numbering.
    """
    ordered = sorted(files, key=natural_key)
    kinds = [(*words(file), file.suffix.lower()) for file in ordered]
    usual = max(set(kinds), key=kinds.count)
    odd = next((file for file, kind in zip(ordered, kinds, strict=True) if kind != usual), None)
    if odd is not None:
        like = ordered[kinds.index(usual)].name
        raise InvalidInputError(
            f"{odd}: the stills of camera {name} are numbered as {like} is, this one is not; move it elsewhere or name "
            "the stills by a pattern."
        )
    twice = next((pair for pair in pairwise(ordered) if numbers(pair[0]) == numbers(pair[1])), None)
    if twice is not None:
        raise InvalidInputError(
            f"Camera {name}: {twice[0].name} and {twice[1].name} in {twice[0].parent} bear one number; keep one."
        )
    missing = gap(ordered)
    if missing is not None:
        before, after = missing
        raise InvalidInputError(
            f"Camera {name}: a still is missing in {ordered[0].parent}, {before} is followed by {after}; put the "
            "missing ones back, or name a part of the film without a gap by a pattern."
        )
    return Stills(name, tuple(ordered))

"""Numbered names in the order that a reader expects: frame2 before frame10."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

_NUMBER = re.compile(r"(\d+)")


def natural_key(path: Path) -> tuple[tuple[int, str | int], ...]:
    """Sort numbers in a name by their value, everything else by its letters."""
    return tuple((0, int(part)) if k % 2 else (1, part.lower()) for k, part in enumerate(_parts(path.name)))


def words(path: Path) -> tuple[str, ...]:
    """Return what is no number in a file's name, its ending apart."""
    return tuple(_parts(path.stem)[::2])


def numbers(path: Path) -> tuple[int, ...]:
    """Return the numbers in a file's name, its ending apart."""
    return tuple(int(part) for part in _parts(path.stem)[1::2])


def gap(files: Sequence[Path]) -> tuple[int, int] | None:
    """Two numbers of neighbours, in order, that are farther apart than the others; None where nothing is missing.

    Names of several varying numbers, a date and a counter, are not judged unless one of them counts.
    """
    if len(files) < 3:
        return None
    found: tuple[int, int] | None = None
    for column in zip(*map(numbers, files), strict=True):
        steps = [after - before for before, after in pairwise(column)]
        if min(steps) < 1:  # it does not count
            continue
        usual = min(steps)
        wide = next((k for k, step in enumerate(steps) if step != usual), None)
        if wide is None:
            return None
        found = found or (column[wide], column[wide + 1])
    return found


def _parts(name: str) -> list[str]:
    """Words and numbers in turn, a word first."""
    return _NUMBER.split(name)

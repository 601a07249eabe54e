"""Files and patterns of files as a user names them."""

from __future__ import annotations

import glob
from collections.abc import Sequence
from pathlib import Path

from flycontrol.errors import InvalidInputError


def expanded(paths: Sequence[Path | str]) -> tuple[Path, ...]:
    """Return the files that paths and patterns such as "flies/*.csv" name; a file of just that name goes first.

    Raises
    ------
    InvalidInputError
        If nothing is named, if a pattern matches no file, or if a file is named twice.
    """
    if not paths:
        raise InvalidInputError("No recording is named; name one file or more.")
    files = [file for path in paths for file in _matching(path)]
    seen: dict[Path, Path] = {}
    for file in files:
        real = file.resolve()
        if real in seen:
            raise InvalidInputError(f"{file} is named twice, also as {seen[real]}; a recording counts once.")
        seen[real] = file
    return tuple(files)


def _matching(path: Path | str) -> list[Path]:
    text = str(path)
    if "\0" in text:
        raise InvalidInputError(f"{text!r} is no name of a file.")
    if not glob.has_magic(text) or Path(path).exists():
        return [Path(path)]
    found = [Path(name) for name in sorted(glob.glob(text, recursive=True)) if Path(name).is_file()]  # noqa: PTH207 (a pattern may be absolute)
    if not found:
        raise InvalidInputError(f"No file matches {text!r}; check the folder and the pattern.")
    return found

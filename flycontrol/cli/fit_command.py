"""The command of a fit as it stands in the provenance: what was typed, options left out left out."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

_MOST = 4  #: files named one by one


def typed_command(files: Sequence[str], options: Mapping[str, object], defaults: Mapping[str, object]) -> str:
    """Join files and options.

    Parameters
    ----------
    options
        Values by name without dashes: a text, a number, a flag, or texts given one after the other.
    defaults
        Values that need not be typed.
    """
    words = ["flycontrol fit", *_named(files)]
    for name, value in options.items():
        if value != defaults.get(name):
            words += _typed(f"--{name}", value)
    return " ".join(words)


def _named(files: Sequence[str]) -> list[str]:
    """Files as typed; of many, those that a shell made of a pattern, the first, the last and their number."""
    if len(files) <= _MOST:
        return [_place(name) for name in files]
    return [_place(files[0]), "...", _place(files[-1]), f"({len(files)} files)"]


def _place(name: str) -> str:
    """A path as typed, an absolute one from its last folder on: a report names no machine and no user."""
    path = Path(name)
    return shlex.quote(str(Path(*path.parts[-2:])) if path.is_absolute() else name)


def _typed(option: str, value: object) -> list[str]:
    if isinstance(value, bool):
        return [option if value else f"--no-{option[2:]}"]
    if isinstance(value, Path) or (option in ("--mapping", "--parameters") and isinstance(value, str)):
        return [option, _place(str(value))]
    if isinstance(value, str | int | float):
        return [option, shlex.quote(f"{value:g}" if isinstance(value, float) else str(value))]
    return [word for text in _texts(value) for word in (option, shlex.quote(text))]


def _texts(value: object) -> list[str]:
    return [str(text) for text in value] if isinstance(value, list | tuple) else []

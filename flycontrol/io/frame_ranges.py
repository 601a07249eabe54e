"""Which frames of a film are meant, as a user writes it."""

from __future__ import annotations

import re

from flycontrol.errors import InvalidInputError

_RANGE = re.compile(r"(\d*):(\d*)(?::(\d+))?")


def frame_range(text: str | None, count: int) -> range:
    """Frames FIRST:LAST:STEP of a film of `count` frames, counted from 0, LAST included; None: all.

    Each part may be left out, "100:" or ":499" or "::2".

    Raises
    ------
    InvalidInputError
        If it is written in another way, leaves the film, or names less than one frame.
    """
    if text is None:
        return range(count)
    found = _RANGE.fullmatch(text.strip())
    if found is None:
        raise InvalidInputError(
            f"--frames is '{text}'; FIRST:LAST or FIRST:LAST:STEP is needed, frames counted from 0 and LAST included, "
            "for example 100:499."
        )
    first, last, step = (int(part) if part else otherwise for part, otherwise in zip(
        found.groups(), (0, count - 1, 1), strict=True
    ))  # fmt: skip
    if step < 1 or not 0 <= first <= last < count:
        raise InvalidInputError(
            f"--frames is '{text}', but the films have the frames 0 to {count - 1}: FIRST must not lie behind LAST, "
            "LAST must be one of them, and STEP is at least 1."
        )
    return range(first, last + 1, step)

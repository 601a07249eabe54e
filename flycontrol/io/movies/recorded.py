"""Frames of one camera as their files have them, before anybody asks whether they are silhouettes."""

from __future__ import annotations

from typing import Protocol

from flycontrol.model.film import ImageArray

MOST_PIXELS = 2**26  #: of one image: what no camera at thousands of frames a second has


class Recorded(Protocol):
    """The frames of one camera, read one at a time."""

    @property
    def name(self) -> str:
        """What the camera is called."""
        ...

    def __len__(self) -> int:
        """Count the frames."""
        ...

    def where(self, k: int) -> str:
        """File and frame, for a sentence."""
        ...

    def frame(self, k: int) -> ImageArray:
        """Frame k, counted from 0, (rows, columns); InvalidInputError, which begins with `where`, if it is damaged."""
        ...


def too_large(rows: int, columns: int) -> str:
    """Return why an image of this size is refused, or an empty text."""
    if rows < 1 or columns < 1:
        return f"an image of {rows} x {columns} pixels is empty"
    if rows * columns > MOST_PIXELS:
        return f"{rows} x {columns} pixels are more than an image may have ({MOST_PIXELS:.2g}); is it damaged? cut it"
    return ""

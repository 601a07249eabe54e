"""What one camera saw, frame by frame, whatever file it lies in."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

ImageArray = NDArray[np.bool_] | NDArray[np.uint8] | NDArray[np.uint16] | NDArray[np.float64]


class Film(Protocol):
    """Frames of one camera; any of them may be asked for, in any order, and one at a time is held in memory."""

    @property
    def name(self) -> str:
        """What the camera or its file is called."""
        ...

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of all its frames [px]."""
        ...

    @property
    def binary(self) -> bool:
        """Whether the frames are silhouettes already; grey images otherwise."""
        ...

    def __len__(self) -> int:
        """Count the frames."""
        ...

    def image(self, k: int) -> ImageArray:
        """Frame k, counted from 0, (rows, columns); boolean where `binary`.

        Raises
        ------
        InvalidInputError
            If this frame cannot be read; others may be.
        """
        ...

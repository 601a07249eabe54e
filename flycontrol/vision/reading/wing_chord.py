"""The chord of a wing from the cross-section of its part of the hull."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flycontrol.vision.kernels.convex import corners

FloatArray = NDArray[np.float64]

_SAME_WAY = np.cos(np.radians(30.0))  #: diagonals nearer to each other than this count as one (C)
_FLAT = 1e-9  #: of the longest diagonal: points no farther apart across it lie on a line
_RIVAL = 0.75  #: of the longest diagonal: a shorter one is no chord (C)


def diagonals(section: FloatArray) -> list[FloatArray]:
    """Unit vectors (2,) along the one or two diagonals of points (N, 2) of which one is the chord, the longest first.

    A plate seen by few cameras has a parallelogram for the cross-section of its hull, and the plate is one of the two
    diagonals, mostly the longer one; where both are about as long, it may be either. None if the points lie on a line
    or are too few.
    """
    if len(section) < 4:
        return []
    around = section[corners(section)]
    ways = around[:, None] - around[None]
    lengths = np.sqrt(np.sum(ways**2, axis=2))
    first = np.unravel_index(int(np.argmax(lengths)), lengths.shape)
    if not np.max(np.abs(ways @ [-ways[first][1], ways[first][0]])) > _FLAT * lengths[first] ** 2:
        return []
    best = ways[first] / lengths[first]
    other = np.abs(ways @ best) < _SAME_WAY * lengths
    second = np.unravel_index(int(np.argmax(np.where(other, lengths, 0.0))), lengths.shape)
    if other[second] and lengths[second] > _RIVAL * lengths[first]:
        return [best, ways[second] / lengths[second]]
    return [best]


def diagonal(section: FloatArray, expected: FloatArray) -> FloatArray | None:
    """Unit vector (2,) along the diagonal of points (N, 2) that is the chord, on the side of the expected one (2,).

    Where two diagonals are about as long, the one nearer to the expected chord is taken. None where there is none.
    """
    found = diagonals(section)
    if not found:
        return None
    best = max(found, key=lambda way: abs(way @ expected)) if len(found) > 1 else found[0]
    return best if best @ expected >= 0 else -best

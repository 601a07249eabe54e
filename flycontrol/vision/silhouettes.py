"""Silhouettes from grey frames: background by median, threshold by contrast, dust and legs by parts and opening."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_opening, label

from flycontrol.errors import InvalidInputError, InvalidParameterError

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
GreyArray = NDArray[np.generic]

_NOISE = 6.0  #: standard deviations from the background at which a pixel is surely of the animal
_MAD = 1.4826  #: standard deviation of a normal distribution over its median absolute deviation
_TOUCHING = np.ones((3, 3), dtype=np.bool_)  #: pixels that touch at corners belong together


@dataclass(frozen=True, slots=True, kw_only=True)
class Segmentation:
    """How a silhouette is made; lengths and areas in pixels."""

    contrast: float | None = None  #: from the background, in its grey levels; None: half of the animal's own
    dark: bool = True  #: the animal is darker than the background
    smallest_share: float = 0.02  #: parts below this share of the largest are dust
    rival_share: float = 0.5  #: parts above this share of the largest may be another animal
    leg_radius: float = 1.5  #: an opening by a disc of this radius takes legs away [px]

    def __post_init__(self) -> None:
        if not (0 <= self.smallest_share <= 1 and 0 < self.rival_share <= 1 and self.leg_radius >= 0):
            raise InvalidParameterError(f"Segmentation needs shares in 0..1 and a radius >= 0 px, got {self!r}.")
        if self.contrast is not None and not self.contrast > 0:
            raise InvalidParameterError(f"Segmentation.contrast must be > 0 grey levels, got {self.contrast!r}.")


#: Half the animal's contrast, parts of 2 % and more, legs up to 3 px wide.
USUAL = Segmentation()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Silhouette:
    """One animal in one view, boolean images (rows, columns)."""

    raw: BoolArray  #: as thresholded or as given
    mask: BoolArray  #: without dust: what the hull is carved from
    core: BoolArray  #: opened too, so that legs are gone, and wings seen on edge with them: for the body alone
    animals: int  #: parts large enough to be one: 0 is an empty silhouette, 2 may be two flies


def background_of(frames: Iterable[GreyArray]) -> FloatArray:
    """Median over frames (rows, columns), spread over a recording in which the animal moves on: 20 to 100 will do.

    Raises
    ------
    InvalidInputError
        If there are no frames or their sizes differ.
    """
    stack = [np.asarray(frame) for frame in frames]
    if not stack or any(frame.ndim != 2 or frame.shape != stack[0].shape for frame in stack):
        raise InvalidInputError(
            "A background needs frames of equal rows and columns, grey and not coloured, got "
            f"{sorted({frame.shape for frame in stack}) or 'none'}."
        )
    return np.median(np.stack(stack).astype(np.float64), axis=0)


def silhouette_of(frame: GreyArray, background: FloatArray, how: Segmentation = USUAL) -> Silhouette:
    """Silhouette of a grey frame (rows, columns) before its background.

    Where nothing stands out of the noise the silhouette is empty.

    Raises
    ------
    InvalidInputError
        If frame and background differ in size.
    """
    if np.shape(frame) != np.shape(background):
        raise InvalidInputError(
            f"A frame of {np.shape(frame)} pixels does not fit its background of {np.shape(background)}."
        )
    difference = (background - np.asarray(frame, dtype=np.float64)) * (1.0 if how.dark else -1.0)
    limit = _half_contrast(difference) if how.contrast is None else how.contrast
    return cleaned(difference > limit, how)


def cleaned(raw: BoolArray, how: Segmentation = USUAL) -> Silhouette:
    """A silhouette (rows, columns) that was given or thresholded, without dust, and without legs."""
    parts, count = cast(tuple[NDArray[np.int32], int], label(raw, structure=_TOUCHING))
    if not count:
        empty = np.zeros_like(raw)
        return Silhouette(raw=raw, mask=empty, core=empty, animals=0)
    area = np.bincount(parts.ravel())
    area[0] = 0
    mask = (area >= how.smallest_share * area.max())[parts] & raw
    return Silhouette(
        raw=raw,
        mask=mask,
        core=np.asarray(_opened(mask, how.leg_radius)),
        animals=int(np.count_nonzero(area >= how.rival_share * area.max())),
    )


def _half_contrast(difference: FloatArray) -> float:
    """Half the median difference of the pixels that are no noise; infinite if there are none."""
    middle = float(np.median(difference))
    noise = _MAD * float(np.median(np.abs(difference - middle)))
    animal = difference[difference > middle + max(_NOISE * noise, np.finfo(float).tiny)]
    return float(np.median(animal)) / 2 if len(animal) else np.inf


def _opened(mask: BoolArray, radius: float) -> BoolArray:
    reach = int(radius)
    if not reach:
        return mask
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    near = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
    v, u = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    opened = np.zeros_like(mask)
    opened[near] = binary_opening(mask[near], structure=v**2 + u**2 <= radius**2)
    return opened

"""The empty scene behind a moving animal, for each camera."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.film import Film, ImageArray
from flycontrol.vision.checks.footage_check import spread_frames
from flycontrol.vision.silhouettes import USUAL, Segmentation, background_of, silhouette_of

FloatArray = NDArray[np.float64]

_SPREAD = 41  #: frames of which the median is taken
_OFTEN = 90  #: percentile of grey levels that an animal leaves free where it is for less than nine tenths of the film
_STUCK = 0.15  #: of a silhouette's area: so much of an animal in the background is told (C)


def film_background(film: Film, how: Segmentation = USUAL) -> FloatArray | None:
    """Median over frames spread over a grey film, (rows, columns); None for a film of silhouettes.

    Raises
    ------
    InvalidInputError
        If none of the frames can be read, or if the animal stays in one place for half of the film: then it is itself
        in the median.
    """
    if film.binary:
        return None
    readable = _readable(film)
    background = background_of(readable)
    _refuse_an_animal(film.name, readable, background, how)
    return background


def median_of(film: Film) -> FloatArray:
    """Median over frames of an empty scene, (rows, columns); InvalidInputError if none of them can be read."""
    return background_of(_readable(film))


def _refuse_an_animal(name: str, frames: list[ImageArray], background: FloatArray, how: Segmentation) -> None:
    """Where the median is as far from what is seen at best as the animal is, the animal was there half of the time."""
    freed = np.percentile(np.stack(frames), _OFTEN if how.dark else 100 - _OFTEN, axis=0)
    sign = 1.0 if how.dark else -1.0
    seen = [
        (silhouette_of(frame, freed, how).mask, sign * (freed - frame)) for frame in frames[:: len(frames) // 5 + 1]
    ]
    contrast = [float(np.median(away[mask])) for mask, away in seen if mask.any()]
    if not contrast:
        return
    covered = np.count_nonzero(sign * (freed - background) > np.median(contrast) / 2)
    usual = np.median([np.count_nonzero(mask) for mask, _ in seen if mask.any()])
    if covered > _STUCK * usual:
        raise InvalidInputError(
            f"{name}: the animal stays in one place for half of the film, so that it is in the median of the frames "
            "itself; give films or pictures of the empty scene by --background."
        )


def _readable(film: Film) -> list[ImageArray]:
    """Frames spread over the film, those that are damaged left out."""
    frames: list[ImageArray] = []
    for k in spread_frames(len(film), _SPREAD):
        with suppress(InvalidInputError):
            frames.append(film.image(k))
    if not frames:
        raise InvalidInputError(f"{film.name}: none of the frames for its background can be read.")
    return frames

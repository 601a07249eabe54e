"""The empty scene behind a moving animal, for each camera."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.film import Film, ImageArray
from flycontrol.vision.footage_check import spread_frames
from flycontrol.vision.silhouettes import background_of

FloatArray = NDArray[np.float64]

_SPREAD = 41  #: frames of which the median is taken


def film_background(film: Film) -> FloatArray | None:
    """Median over frames spread over a grey film, (rows, columns); None for a film of silhouettes.

    An animal that stays in one place for half of the film is in it; give a picture of the empty scene then.

    Raises
    ------
    InvalidInputError
        If none of the frames can be read.
    """
    if film.binary:
        return None
    if not (readable := list(_readable(film))):
        raise InvalidInputError(f"{film.name}: none of the frames for its background can be read.")
    return background_of(readable)


def _readable(film: Film) -> Iterator[ImageArray]:
    for k in spread_frames(len(film), _SPREAD):
        try:
            yield film.image(k)
        except InvalidInputError:
            continue

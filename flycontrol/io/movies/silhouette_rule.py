"""Whether the frames of a camera are silhouettes, told by their values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.film import ImageArray

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True)
class MaskRule:
    """The animal is where a pixel lies above a limit, or below it."""

    limit: float  #: grey value between animal and background
    bright: bool  #: whether the animal is what lies above
    values: tuple[float, ...] = ()  #: the only ones that there may be; none: any

    def mask(self, image: ImageArray, where: str) -> BoolArray:
        """Return where the animal is; InvalidInputError if a frame has other values than the film."""
        if self.values:
            strange = image[np.logical_and.reduce([image != value for value in self.values])]
            if strange.size:
                raise InvalidInputError(
                    f"{where} has the value {strange.flat[0]:g}, and the film seemed to be of silhouettes with the "
                    f"values {' and '.join(f'{value:g}' for value in self.values)} alone; say that it is grey, or that "
                    "it is of silhouettes all the same."
                )
        return np.asarray(image > self.limit) == self.bright


TRUE = MaskRule(limit=0.5, bright=True)  #: of boolean arrays


def silhouette_rule(samples: Sequence[ImageArray], binary: bool | None) -> MaskRule | None:
    """Tell from some frames (rows, columns) where the animal is; None if they are grey.

    Boolean frames are silhouettes, true where the animal is. So are frames of two values only: the animal has the one
    that fills less of them. Where it is said that frames of many values are silhouettes, those are split halfway
    between darkest and brightest.
    """
    if binary is False:
        return None
    if all(image.dtype == np.bool_ for image in samples):
        return TRUE
    values = two_values(samples)
    if values is None and not binary:
        return None
    if values == (0.0,):  # nothing in view so far
        return MaskRule(limit=0.0, bright=True)
    low = min(float(image.min()) for image in samples)
    high = max(float(image.max()) for image in samples)
    limit = (low + high) / 2
    above = float(np.mean([np.mean(image > limit) for image in samples]))
    return MaskRule(limit=limit, bright=above <= 0.5, values=values or ())


def two_values(samples: Sequence[ImageArray]) -> tuple[float, ...] | None:
    """Return the one or two values that all samples have; None if there are more, or only a grey one."""
    found: set[float] = set()
    for image in samples:
        low, high = image.min(), image.max()
        if np.any((image != low) & (image != high)):
            return None
        found |= {float(low), float(high)}
    return tuple(sorted(found)) if len(found) == 2 or found == {0.0} else None

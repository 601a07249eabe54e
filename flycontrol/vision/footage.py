"""Films of one animal by several cameras, and the silhouettes in them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.film import Film, ImageArray
from flycontrol.vision.silhouettes import USUAL, Segmentation, Silhouette, cleaned, silhouette_of

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FilmedFrame:
    """One instant, seen by C cameras."""

    images: tuple[ImageArray, ...]  #: as filmed; empty where one of them cannot be read
    silhouettes: tuple[Silhouette, ...]
    fault: str = ""  #: why it cannot be read, or empty


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Footage:
    """C films of equal length; frame by frame, so that memory does not grow with it."""

    films: tuple[Film, ...]
    frame_rate: float  #: [1/s]
    backgrounds: tuple[FloatArray | None, ...]  #: (rows, columns) of each grey film
    how: Segmentation = USUAL

    def __len__(self) -> int:
        return len(self.films[0])

    def __iter__(self) -> Iterator[FilmedFrame]:
        return (self.frame(k) for k in range(len(self)))

    def frame(self, k: int) -> FilmedFrame:
        """Frame k, counted from 0; one that cannot be read has a fault instead of images."""
        try:
            images = tuple(film.image(k) for film in self.films)
        except InvalidInputError as damaged:
            return FilmedFrame(images=(), silhouettes=(), fault=str(damaged))
        pairs = zip(images, self.backgrounds, strict=True)
        return FilmedFrame(images=images, silhouettes=tuple(self._silhouette(*pair) for pair in pairs))

    def _silhouette(self, image: ImageArray, background: FloatArray | None) -> Silhouette:
        if background is None:
            return cleaned(image.astype(np.bool_), self.how)
        return silhouette_of(image, background, self.how)

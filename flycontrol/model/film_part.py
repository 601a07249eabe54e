"""Some frames of a film, as a film."""

from __future__ import annotations

from dataclasses import dataclass

from flycontrol.model.film import Film, ImageArray


@dataclass(frozen=True, slots=True, eq=False)
class FilmPart:
    """Frame k is frame `frames[k]` of the whole film."""

    film: Film
    frames: range

    @property
    def name(self) -> str:
        """What the whole film is called."""
        return self.film.name

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns [px]."""
        return self.film.shape

    @property
    def binary(self) -> bool:
        """Whether the frames are silhouettes already."""
        return self.film.binary

    def __len__(self) -> int:
        return len(self.frames)

    def image(self, k: int) -> ImageArray:
        """Frame k of this part; InvalidInputError if it cannot be read."""
        return self.film.image(self.frames[k])

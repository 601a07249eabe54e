"""A film for the tracker: frames of one camera of which is known whether they are silhouettes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.recorded import Recorded
from flycontrol.io.movies.silhouette_rule import MaskRule, silhouette_rule
from flycontrol.io.movies.stills import Stills
from flycontrol.model.film import ImageArray

_SAMPLES = 9  #: frames that are looked at to tell silhouettes from grey images


@dataclass(frozen=True, slots=True)
class RecordedFilm:
    """Frames of one camera; `model.film.Film` says what may be asked of it."""

    name: str  #: what the camera is called
    recorded: Recorded
    shape: tuple[int, int]  #: rows and columns of all its frames [px]
    rule: MaskRule | None  #: where the animal is; None: the frames are grey
    first: int  #: frame of the file that is frame 0 here
    count: int  #: of frames

    @property
    def note(self) -> str:
        """What was decided about its frames that a user may want to know, or an empty text."""
        if self.rule is None or self.rule.bright:
            return ""
        return (
            f"Camera {self.name}: the animal is taken to be the darker part of the silhouettes, which is the smaller."
        )

    @property
    def binary(self) -> bool:
        """Whether the frames are silhouettes already."""
        return self.rule is not None

    def __len__(self) -> int:
        """Count the frames."""
        return self.count

    def image(self, k: int) -> ImageArray:
        """Frame k, counted from 0, (rows, columns); boolean where `binary`.

        Raises
        ------
        InvalidInputError
            If this frame cannot be read, or is not of the size or the kind of the others.
        """
        if not 0 <= k < len(self):
            raise InvalidInputError(f"{self.name} has the frames 0 to {len(self) - 1}, so there is no frame {k}.")
        where = self._where(k)
        try:
            image = self.recorded.frame(self.first + k)
        except InvalidInputError as damaged:
            folders = self.recorded.where(self.first + k).removesuffix(where)
            raise InvalidInputError(str(damaged).removeprefix(folders)) from damaged
        if image.shape != self.shape:
            raise InvalidInputError(
                f"{where} has {image.shape[0]} x {image.shape[1]} pixels, other frames of camera {self.name} have "
                f"{self.shape[0]} x {self.shape[1]}."
            )
        if self.rule is not None:
            return self.rule.mask(image, where)
        return image.astype(np.uint8) * np.uint8(255) if image.dtype == np.bool_ else image

    def _where(self, k: int) -> str:
        """File and frame without the folders above, which are those of a machine: of a still with its own folder."""
        parts = self.recorded.where(self.first + k).split(os.sep)  # noqa: PTH206 (a Path a frame would take memory)
        return os.sep.join(parts[-2:] if isinstance(self.recorded, Stills) else parts[-1:])  # noqa: PTH118


def film_of(name: str, camera: Recorded, span: tuple[int, int], binary: bool | None) -> RecordedFilm:
    """Look at some frames of a camera and say what its film is.

    Parameters
    ----------
    name
        What it is called.
    camera
        Its frames.
    span
        The first of them that counts, and how many do.
    binary
        Whether they are silhouettes; None: as they look.

    Raises
    ------
    InvalidInputError
        If none of those looked at can be read, or if they differ in size.
    """
    first, count = span
    looked_at = np.unique(np.linspace(first, first + count - 1, _SAMPLES).round().astype(int))
    samples = list(_readable(camera, [int(k) for k in looked_at]))
    shapes: dict[tuple[int, ...], str] = {}
    for k, image in samples:
        shapes.setdefault(image.shape, camera.where(k))
    if len(shapes) > 1:
        sizes = "; ".join(f"{where} has {shape[0]} x {shape[1]}" for shape, where in shapes.items())
        raise InvalidInputError(f"Camera {name}: frames of one camera must have equally many pixels; {sizes}.")
    images = [image for _, image in samples]
    rows, columns = images[0].shape
    return RecordedFilm(name, camera, (int(rows), int(columns)), silhouette_rule(images, binary), first, count)


def _readable(camera: Recorded, looked_at: list[int]) -> Iterator[tuple[int, ImageArray]]:
    """Frames that can be read; what is wrong with the first if none can."""
    failure: InvalidInputError | None = None
    found = False
    for k in looked_at:
        try:
            image = camera.frame(k)
        except InvalidInputError as error:
            failure = failure or error
            continue
        found = True
        yield k, image
    if not found and failure is not None:
        raise failure

"""A TIFF file of many pages: the film of one camera."""

from __future__ import annotations

import weakref
from pathlib import Path

from PIL import Image

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.picture import grey, require_format
from flycontrol.io.movies.refusals import refusing
from flycontrol.model.film import ImageArray


class TiffPages:
    """The pages of a file, which stays open as long as this object lives."""

    def __init__(self, name: str, path: Path) -> None:
        self.name = name
        self._path = path
        with refusing(str(path)):
            require_format(path)
            self._file = path.open("rb")
            weakref.finalize(self, self._file.close)
            self._pages: Image.Image | None = self._opened()
            self._count = int(getattr(self._pages, "n_frames", 1))

    def __len__(self) -> int:
        """Count the pages."""
        return self._count

    def where(self, k: int) -> str:
        """Name file and page."""
        return f"{self._path}, frame {k} (from 0)"

    def frame(self, k: int) -> ImageArray:
        """Read page k."""
        with refusing(self.where(k)):
            pages, self._pages = (
                self._pages or self._opened(),
                None,
            )  # a decoder that fails leaves them in no good state
            pages.seek(k)
            image = grey(pages)
            self._pages = pages
            return image

    def _opened(self) -> Image.Image:
        self._file.seek(0)
        return Image.open(self._file, formats=("TIFF",))


def page_count(path: Path) -> int:
    """Count the pages of a TIFF file; 1 where it is too damaged to tell."""
    try:
        return len(TiffPages(path.stem, path))
    except InvalidInputError:
        return 1

"""Video, through imageio and PyAV where they are installed.

Frames are decoded one after the other, as they were encoded: seeking is only approximate in many files. For a frame
that lies behind, the file is opened again; the last few frames are kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.recorded import too_large
from flycontrol.io.movies.refusals import refusing
from flycontrol.model.film import ImageArray

_KEPT = 8  #: frames that may be asked for again without decoding
_SHOWN = 1000.0  #: rates up to here are those of showing a film, or what Matroska's milliseconds leave of others [1/s]
_WHOLE = 0.9  #: of the frames that a file states; its times are too coarse to tell one or two
_DEEP = ("gray9", "gray10", "gray12", "gray14", "gray16")  #: pixel formats of more than 8 bits


class Video:
    """The frames of a file, decoded in order."""

    def __init__(self, path: Path) -> None:
        self.name = path.stem
        self._path = path
        with refusing(str(path)), _opened(path) as file:
            stated: dict[str, Any] = file.metadata()
        self._format = "gray16le" if str(stated.get("video_format")).startswith(_DEEP) else "gray"
        rate = float(stated.get("fps") or 0.0)
        self.frame_rate = rate if rate > _SHOWN else None  #: [1/s], where it can be that of filming
        self._recent: dict[int, ImageArray] = {}
        self._rewind()
        self._count = self._counted()
        self.notes = tuple(self._notes(rate, float(stated.get("duration") or 0.0)))

    def __len__(self) -> int:
        """Count the frames."""
        return self._count

    def where(self, k: int) -> str:
        """Name file and frame."""
        return f"{self._path}, frame {k} (from 0)"

    def frame(self, k: int) -> ImageArray:
        """Decode up to frame k, from where it stands or from the beginning."""
        if k in self._recent:
            return self._recent[k]
        if k < self._next:
            self._rewind()
        while self._next <= k:
            if not self._advance():
                raise InvalidInputError(f"{self.where(k)} is not there any more; did the file change?")
        return self._recent[k]

    def _notes(self, rate: float, seconds: float) -> Iterator[str]:
        if self.frame_rate is None:
            yield f"{self._path.name}: its {rate:g} frames/s are those of showing it, not taken for those of filming."
        stated = round(rate * seconds)
        if self._count < _WHOLE * stated:
            yield f"{self._path.name} may be cut off: it says about {stated} frames, and {self._count} can be read."

    def _rewind(self) -> None:
        self._next = 0
        self._frames = _decoded(self._path, self._format)

    def _advance(self) -> bool:
        """Decode one more frame; False at the end."""
        with refusing(self.where(self._next)):
            image = next(self._frames, None)
        if image is None:
            return False
        self._recent[self._next] = image
        self._recent.pop(self._next - _KEPT, None)
        self._next += 1
        return True

    def _counted(self) -> int:
        """Count by decoding: what files say of their length is often wrong."""
        while self._advance():
            pass
        count = self._next
        self._recent.clear()
        self._rewind()
        return count


def _decoded(path: Path, form: str) -> Iterator[ImageArray]:
    with _opened(path) as file:
        for image in file.iter(format=form, thread_type="FRAME"):
            grey: NDArray[np.generic] = np.asarray(image)
            if fault := too_large(*grey.shape):
                raise InvalidInputError(fault)
            yield grey.astype(np.uint16) if form == "gray16le" else grey.astype(np.uint8)


def _opened(path: Path) -> Any:
    missing = [name for name, module in (("imageio", "imageio"), ("av", "av")) if find_spec(module) is None]
    if missing:
        raise InvalidInputError(
            f"is a video, which needs {' and '.join(missing)}: run pip install 'flycontrol[video]', or save the film "
            "as stills"
        )
    imageio = import_module("imageio.v3")
    return imageio.imopen(path, "r", plugin="pyav")

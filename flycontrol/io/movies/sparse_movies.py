"""Sparse movies: .mat files that hold a background and, frame by frame, the pixels that differ from it.

The layout is the one that flight laboratories' MATLAB code reads: `frames`, an array of structures with the field
`indIm`, (K, 3), of rows and columns from 1 and grey values; `metaData` with `bg`, `frameSize`, `startFrame` and
`frameRate`. Movies of several cameras are brought together by `startFrame`, counted from the trigger.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.reader import shared_reader
from flycontrol.io.binary.request import Request, Wanted
from flycontrol.io.formats import Layout, binary_file, sniffed_format
from flycontrol.io.movies.recorded import too_large
from flycontrol.io.movies.sparse_pixels import streamed_pixels, unpacked_pixels
from flycontrol.model.film import ImageArray

FloatArray = NDArray[np.float64]

_META = "metaData"
_MOST_16_BIT = np.iinfo(np.uint16).max


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SparseMovie:
    """Frames of one camera as pixels on a background; masks where there is none."""

    name: str
    path: Path
    count: int
    shape: tuple[int, int]  #: rows, columns [px]
    background: NDArray[np.uint16] | FloatArray | None  #: (rows, columns) [grey values]
    start: int | None  #: number of the first frame, counted from the trigger
    frame_rate: float | None  #: [1/s]
    pixels: Callable[[int], FloatArray]  #: (K, 2) or (K, 3) of a frame, counted from 0; (0, 0) where nothing is in view
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Count the frames."""
        return self.count

    def where(self, k: int) -> str:
        """Name file and frame."""
        return f"{self.path}, frame {k} (from 0)"

    def frame(self, k: int) -> ImageArray:
        """Set the pixels of frame k on the background; true in a mask where there is none."""
        try:
            table = self.pixels(k)
        except InvalidInputError as error:
            raise InvalidInputError(f"{self.where(k)}: {error}") from error
        if not table.size:
            table = np.empty((0, 3))
        self._refuse_no_pixels(k, table)
        rows, columns = (table[:, :2].T - 1).astype(np.int64)
        if self.background is None:
            mask = np.zeros(self.shape, dtype=np.bool_)
            mask[rows, columns] = True
            return mask
        if table.shape[1] != 3 or not np.all(np.isfinite(table[:, 2])):
            raise InvalidInputError(f"{self.where(k)}: indIm has no grey values in its third column.")
        values = table[:, 2]
        deep = np.all((values >= 0) & (values <= _MOST_16_BIT) & (values == np.rint(values)))
        image = self.background.copy() if deep else self.background.astype(np.float64)
        image[rows, columns] = values
        return image

    def _refuse_no_pixels(self, k: int, table: FloatArray) -> None:
        if table.ndim != 2 or table.shape[1] not in (2, 3):
            raise InvalidInputError(
                f"{self.where(k)}: indIm must have a row for each pixel, of its row, column and grey value; it is "
                f"{' x '.join(map(str, table.shape))}."
            )
        at = table[:, :2]
        good = np.all((at >= 1) & (at <= self.shape) & (at == np.rint(at)), axis=1)
        if not np.all(good):
            row, column = at[int(np.argmin(good))]
            raise InvalidInputError(
                f"{self.where(k)}: indIm names the pixel in row {row:g}, column {column:g}, which an image of "
                f"{self.shape[0]} x {self.shape[1]} pixels does not have."
            )


def open_sparse_movie(path: Path) -> SparseMovie:
    """Open the sparse movie of one camera, in MATLAB's format 5 to 7.3.

    Frames of version 7.3 are read from the file when they are asked for; older files, which can only be read as a
    whole, are unpacked into a temporary file.

    Raises
    ------
    InvalidInputError
        If the file is damaged, or is no sparse movie.
    """
    if sniffed_format(path) != "mat":
        raise InvalidInputError(f"{path} is no MATLAB file by its first bytes; sparse movies are .mat files.")
    layout = binary_file(path, "mat").layout
    count = _frame_count(path, layout)
    background, size, start, rate, flipped = (
        _meta(path, layout, name) for name in ("bg", "frameSize", "startFrame", "frameRate", "isFlipped")
    )
    shape = _shape(path, background, size)
    note = f"{path.name}: its images were mirrored in place, as its isFlipped says, and are taken as they are stored."
    unpack = streamed_pixels if layout == "matlab 7.3" else unpacked_pixels
    return SparseMovie(
        name=path.stem,
        path=path,
        count=count,
        shape=shape,
        background=_of_16_bit(background),
        start=_whole(path, "startFrame", start),
        frame_rate=_rate(path, rate),
        pixels=unpack(path, layout, count),
        notes=(note,) if flipped is not None and flipped.any() else (),
    )


def _frame_count(path: Path, layout: Layout) -> int:
    request = Request(path=str(path), name=str(path), layout=layout, form="mat", groups=("frames",))
    return len(shared_reader().read(request).groups)


def _meta(path: Path, layout: Layout, name: str) -> FloatArray | None:
    """Read a field of metaData; None if it is not there."""
    wanted = Wanted(path=f"{_META}.{name}", what="array", key="the film")
    request = Request(path=str(path), name=str(path), layout=layout, form="mat", wanted=(wanted,))
    ((_, (found,)),) = shared_reader().read(request).groups
    array = found.array()
    return array if array is not None and array.size else None


def _shape(path: Path, background: FloatArray | None, size: FloatArray | None) -> tuple[int, int]:
    shape = size.reshape(-1)[:2] if size is not None else None if background is None else background.shape
    if shape is None:
        raise InvalidInputError(f"{path}: {_META} has neither frameSize nor bg, so the size of its images is unknown.")
    if size is not None and (size.size < 2 or not np.all(np.isfinite(size)) or np.any(size != np.rint(size))):
        raise InvalidInputError(f"{path}: {_META}.frameSize must be rows and columns, two whole numbers.")
    rows, columns = (int(n) for n in shape)
    if fault := too_large(rows, columns):
        raise InvalidInputError(f"{path}: {fault}.")
    if background is not None and background.shape != (rows, columns):
        found = " x ".join(map(str, background.shape))
        raise InvalidInputError(
            f"{path}: {_META}.bg has {found} pixels and {_META}.frameSize says {rows} x {columns}; they must agree."
        )
    if background is not None and not np.all(np.isfinite(background)):
        raise InvalidInputError(f"{path}: {_META}.bg has pixels that are no finite numbers.")
    return rows, columns


def _of_16_bit(background: FloatArray | None) -> NDArray[np.uint16] | FloatArray | None:
    if background is None or background.min() < 0 or background.max() > _MOST_16_BIT:
        return background
    return background.astype(np.uint16) if np.array_equal(background, np.rint(background)) else background


def _whole(path: Path, name: str, value: FloatArray | None) -> int | None:
    if value is None:
        return None
    if value.size != 1 or not np.isfinite(value.flat[0]) or value.flat[0] != np.rint(value.flat[0]):
        raise InvalidInputError(f"{path}: {_META}.{name} must be one whole number.")
    return int(value.flat[0])


def _rate(path: Path, value: FloatArray | None) -> float | None:
    if value is None:
        return None
    if value.size != 1 or not (np.isfinite(value.flat[0]) and value.flat[0] > 0):
        raise InvalidInputError(f"{path}: {_META}.frameRate must be one number > 0 frames/s.")
    return float(value.flat[0])

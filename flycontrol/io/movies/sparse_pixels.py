"""The pixels of a sparse movie's frames, through the process that opens binary files."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.reader import shared_reader
from flycontrol.io.binary.request import Request, Wanted
from flycontrol.io.formats import Layout

FloatArray = NDArray[np.float64]
Pixels = Callable[[int], FloatArray]

_AT_ONCE = 250  #: frames whose pixels are held in memory together while a file is unpacked


def streamed_pixels(path: Path, layout: Layout, count: int) -> Pixels:
    """Return what reads the pixels of one frame (K, 3) from the file each time."""

    def pixels(k: int) -> FloatArray:
        return _tables(path, layout, count, range(k, k + 1))[0]

    return pixels


def unpacked_pixels(path: Path, layout: Layout, count: int) -> Pixels:
    """Copy all pixels into a temporary file, which goes with what is returned, and read them from there."""
    shapes: list[tuple[int, ...]] = []
    with tempfile.TemporaryFile(prefix="flycontrol-") as file:
        for first in range(0, count, _AT_ONCE):
            for table in _tables(path, layout, count, range(first, min(first + _AT_ONCE, count))):
                shapes.append(table.shape)
                file.write(table.astype(np.float32).tobytes())  # exact for rows, columns and 16 bit of grey
        file.flush()
        starts = np.cumsum([0, *(int(np.prod(shape)) for shape in shapes)])
        numbers = np.memmap(file, dtype=np.float32, mode="r") if starts[-1] else np.empty(0, dtype=np.float32)

    def pixels(k: int) -> FloatArray:
        return np.array(numbers[starts[k] : starts[k + 1]], dtype=np.float64).reshape(shapes[k])

    return pixels


def _tables(path: Path, layout: Layout, count: int, frames: range) -> list[FloatArray]:
    """`indIm` of some frames; an empty one where nothing is in view."""
    names = ["frames" if count == 1 else f"frames({k + 1})" for k in frames]
    wanted = tuple(Wanted(path=f"{name}.indIm", what="array", key="the film") for name in names)
    request = Request(path=str(path), name=str(path), layout=layout, form="mat", wanted=wanted)
    ((_, found),) = shared_reader().read(request).groups
    tables = [item.array() for item in found]
    for k, table in zip(frames, tables, strict=True):
        if table is None:
            raise InvalidInputError(f"{path}: frame {k} (from 0) has no indIm, the pixels of a sparse movie.")
    return [table for table in tables if table is not None]

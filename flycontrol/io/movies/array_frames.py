"""Frames in an array that lies on disk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.recorded import too_large
from flycontrol.model.film import ImageArray

_MOST_CAMERAS = 16
_KINDS = "biuf"


@dataclass(frozen=True, slots=True)
class ArrayFrames:
    """One camera of an array (N, rows, columns) or (N, C, rows, columns), read frame by frame."""

    name: str
    source: str  #: file, and variable if there are several
    array: NDArray
    camera: int | None  #: its place on the second axis, if there is one
    packed_shape: tuple[int, int] | None  #: rows and columns of masks that are packed into bits

    def __len__(self) -> int:
        """Count the frames."""
        return len(self.array)

    def where(self, k: int) -> str:
        """Name file, camera and frame."""
        place = "" if self.camera is None else f", camera {self.camera + 1}"
        return f"{self.source}{place}, frame {k} (from 0)"

    def frame(self, k: int) -> ImageArray:
        """Copy frame k out of the file."""
        held = np.array(self.array[k] if self.camera is None else self.array[k, self.camera])
        if self.packed_shape is not None:
            rows, columns = self.packed_shape
            bits = np.unpackbits(held, axis=-1)
            whole = bits.ndim == 1  # rows and columns were one axis when they were packed
            return (bits[: rows * columns].reshape(rows, columns) if whole else bits[:, :columns]).astype(np.bool_)
        if held.dtype.kind in ("b", "u") and held.dtype.itemsize <= 2:
            return held.astype(held.dtype.newbyteorder("="), copy=False)
        image = held.astype(np.float64)
        if not np.all(np.isfinite(image)):
            raise InvalidInputError(f"{self.where(k)} has pixels that are no finite numbers.")
        return image


def array_cameras(
    name: str, source: str, array: NDArray, *, packed: bool, packed_shape: tuple[int, int] | None = None
) -> tuple[ArrayFrames, ...]:
    """Return the cameras of an array.

    Parameters
    ----------
    name
        Of the camera, where it is one.
    source
        File and variable, for sentences.
    array
        (N, rows, columns) of one camera or (N, C, rows, columns) of C; packed into bits along the last axis, which
        holds a byte for 8 columns, or for 8 pixels where `packed_shape` is given and rows and columns are one axis.
    packed
        Whether it is packed.
    packed_shape
        Rows and columns of masks that are packed as a whole.

    Raises
    ------
    InvalidInputError
        If it is none of these.
    """
    whole = packed and packed_shape is not None
    axes = array.ndim + whole
    _refuse_other_kinds(source, array, packed=packed)
    if axes not in (3, 4):
        raise InvalidInputError(
            f"{source} has the shape {_shape(array)}; films are (frames, rows, columns) of one camera or (frames, "
            "cameras, rows, columns)."
        )
    if not len(array):
        raise InvalidInputError(f"{source} holds no frames.")
    if packed:
        packed_shape = packed_shape or (int(array.shape[-2]), 8 * int(array.shape[-1]))
    rows, columns = packed_shape or array.shape[-2:]
    if fault := too_large(rows, columns):
        raise InvalidInputError(f"{source}: {fault}.")
    if axes == 3:
        return (ArrayFrames(name, source, array, None, packed_shape),)
    _refuse_other_axes(source, array)
    return tuple(ArrayFrames(f"camera {c + 1}", source, array, c, packed_shape) for c in range(array.shape[1]))


def _refuse_other_kinds(source: str, array: NDArray, *, packed: bool) -> None:
    if packed and array.dtype != np.uint8:
        raise InvalidInputError(f"{source} holds {array.dtype}; packed masks are uint8, as numpy.packbits makes them.")
    if array.dtype.kind not in _KINDS:
        raise InvalidInputError(f"{source} holds {array.dtype}; images are of booleans or real numbers.")


def _refuse_other_axes(source: str, array: NDArray) -> None:
    cameras = array.shape[1]
    if array.shape[-1] in (1, 3, 4) and cameras > _MOST_CAMERAS:
        raise InvalidInputError(
            f"{source} has the shape {_shape(array)}, which looks like coloured images of one camera; save grey ones."
        )
    if not 0 < cameras <= _MOST_CAMERAS:
        raise InvalidInputError(
            f"{source} has the shape {_shape(array)}; its second axis counts the cameras, at most {_MOST_CAMERAS}."
        )


def _shape(array: NDArray) -> str:
    return " x ".join(map(str, array.shape)) or "of a single number"

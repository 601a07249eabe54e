"""Which arrays of a .npy or .npz file are films, and of how many cameras."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.array_frames import ArrayFrames, array_cameras
from flycontrol.io.movies.numpy_files import NpzFile, open_npy

_PACKED = "packed"  #: what the name of an array of packed masks ends with
_RATES = ("fps", "frame_rate", "framerate", "frames_per_second")
_FEWEST_PIXELS = 16  #: along a side of an image; smaller arrays of three axes are calibrations and the like


@dataclass(frozen=True, slots=True)
class NumpyFilms:
    """The cameras of a file."""

    cameras: tuple[ArrayFrames, ...]
    frame_rate: float | None  #: [1/s], where the file says it


def npy_films(path: Path, *, packed: bool | None) -> NumpyFilms:
    """Read the film of one camera or of all from a .npy file, mapped into memory.

    Raises
    ------
    InvalidInputError
        If it is damaged, holds objects, or no array of three or four axes.
    """
    is_packed = path.stem.lower().endswith(_PACKED) if packed is None else packed
    return NumpyFilms(array_cameras(path.stem, str(path), open_npy(path), packed=is_packed), None)


def npz_films(path: Path, *, packed: bool | None, variable: str | None) -> NumpyFilms:
    """Read the films in a .npz file: one array of all cameras, or an array for each.

    Raises
    ------
    InvalidInputError
        If it is damaged, holds objects, or if none or several of its arrays could be meant.
    """
    file = NpzFile(path)
    cameras: list[ArrayFrames] = []
    for name in _films(file, variable):
        is_packed = name.lower().endswith(_PACKED) if packed is None else packed
        shape = _packed_shape(file, name) if is_packed else None
        cameras += array_cameras(name, f"{path}, {name}", file.mapped(name), packed=is_packed, packed_shape=shape)
    return NumpyFilms(tuple(cameras), _frame_rate(file))


def _films(file: NpzFile, variable: str | None) -> list[str]:
    """Names of the variables that are films: the one asked for, packed masks, all cameras in one, or one for each."""
    if variable is not None:
        if variable not in file.shapes:
            raise InvalidInputError(
                f"{file.path} has no variable {variable!r}; it has {', '.join(list(file.shapes)[:20]) or 'none'}."
            )
        return [variable]
    packed = [name for name in file.shapes if name.lower().endswith(_PACKED)]
    images = [name for name in file.shapes if _is_film(file, name)]
    whole = [name for name in images if len(file.shapes[name]) == 4]
    for found in (packed, whole, images):
        if len(found) == 1 or (found and found is not whole and _alike(file, found)):
            return found
        if found:
            raise InvalidInputError(
                f"{file.path}: {', '.join(found[:12])} could be the film; name one by --film-variable."
            )
    raise InvalidInputError(
        f"{file.path} has no film, an array (frames, cameras, rows, columns) or one (frames, rows, columns) for each "
        f"camera; it has {_listed(file)}."
    )


def _is_film(file: NpzFile, name: str) -> bool:
    shape = file.shapes[name]
    return len(shape) in (3, 4) and file.kind(name).kind in "biuf" and min(shape[-2:]) >= _FEWEST_PIXELS


def _alike(file: NpzFile, names: list[str]) -> bool:
    """Whether all have three axes and equally many frames, so that each may be a camera's."""
    shapes = [file.shapes[name] for name in names]
    return all(len(shape) == 3 for shape in shapes) and len({shape[0] for shape in shapes}) == 1


def _packed_shape(file: NpzFile, name: str) -> tuple[int, int] | None:
    """Rows and columns of masks that are packed as a whole, where a variable such as `mask_shape` says them."""
    packed = 8 * file.shapes[name][-1] if file.shapes[name] else 0
    for other in file.shapes:
        if other.lower().endswith("shape") and file.shapes[other] == (2,):
            values = file.small(other)
            if values is not None and values.dtype.kind in "iu" and _holds(packed, values):
                return int(values[0]), int(values[1])
    return None


def _holds(packed: int, shape: np.ndarray) -> bool:
    rows, columns = (int(n) for n in shape)
    return rows > 0 and columns > 0 and packed == 8 * -(-rows * columns // 8)


def _frame_rate(file: NpzFile) -> float | None:
    name = next((name for name in file.shapes if name.lower() in _RATES), None)
    values = None if name is None else file.small(name)
    if values is None or values.size != 1:
        return None
    rate = float(values.reshape(-1)[0])
    return rate if np.isfinite(rate) and rate > 0 else None


def _listed(file: NpzFile) -> str:
    shapes = [f"{name} ({' x '.join(map(str, shape)) or '1'})" for name, shape in file.shapes.items()]
    return ", ".join(shapes[:12]) or "nothing"

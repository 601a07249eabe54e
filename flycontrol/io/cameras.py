"""Calibrated cameras from the files of calibration tools: DLT coefficients, easyWand, matrices, anipose."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.io.anipose import read_anipose
from flycontrol.io.binary.reader import shared_reader
from flycontrol.io.binary.request import Request
from flycontrol.io.formats import binary_file, require_regular_file
from flycontrol.io.tables import read_text_table
from flycontrol.model.camera import Camera
from flycontrol.model.camera_forms import (
    DLT_COEFFICIENTS,
    MATLAB_PIXELS,
    OPENCV_PIXELS,
    PixelConvention,
    camera_from_dlt,
    camera_from_matrix,
    facing_the_scene,
)
from flycontrol.units import mm

FloatArray = NDArray[np.float64]
Shape = tuple[int, int]

_READ_HERE = ".csv and .txt (DLT coefficients or matrices), .mat (easyWand), .npy, .npz and .toml (anipose)"
_OF_VARIABLES = (".npy", ".npz", ".mat")
_FEWEST = 2  #: cameras that tell depth


def read_cameras(
    path: Path | str,
    shapes: Shape | Sequence[Shape] | None = None,
    *,
    unit: float = mm,
    pixels: PixelConvention | None = None,
    variable: str | None = None,
) -> tuple[Camera, ...]:
    """Read all cameras of a calibration.

    Parameters
    ----------
    path
        A table of DLT coefficients (11 rows, a column each camera, as DLTdv writes it) or of 3 x 4 matrices (3 rows
        each camera); an easyWandData.mat; .npy or .npz with (11, C) coefficients or (C, 3, 4) or several (3, 4)
        matrices; an anipose calibration.toml.
    shapes
        Rows and columns of the images, of all cameras or of each; anipose's files say it themselves.
    unit
        Of lengths in the file [m]; DLT coefficients and matrices do not say it.
    pixels
        How the file counts pixels; by default from 1 for DLT coefficients and from 0 for matrices and anipose.
    variable
        Of a .npz or .mat, where more than one could be meant.

    Raises
    ------
    InvalidInputError
        If the file is none of these, or holds a camera that sees nothing.
    """
    file = Path(path)
    if not (unit > 0 and np.isfinite(unit)):
        raise InvalidInputError(f"{file}: the unit of its lengths must be > 0 m, got {unit!r}.")
    try:
        _refuse_a_variable(file, variable)
        if file.suffix.lower() == ".toml":
            cameras = read_anipose(file, unit=unit)
            _refuse_other_shapes(file, cameras, shapes)
        else:
            cameras = _from_numbers(file, _numbers(file, variable), shapes, unit, pixels)
    except InvalidParameterError as error:
        raise InvalidInputError(f"{file}: {error}") from error
    if len(cameras) < _FEWEST:
        raise InvalidInputError(f"{file} holds {len(cameras)} camera; two or more tell where things are.")
    return facing_the_scene(cameras)


def _refuse_a_variable(path: Path, variable: str | None) -> None:
    if variable is not None and path.suffix.lower() not in _OF_VARIABLES:
        raise InvalidInputError(
            f"{path} has no variables from which {variable!r} could be chosen, as {', '.join(_OF_VARIABLES)} have; "
            "leave the variable out."
        )


def _numbers(path: Path, variable: str | None) -> FloatArray:
    """(11, C) coefficients or (C, 3, 4) matrices, as the file has them."""
    kind = path.suffix.lower()
    if kind == ".mat":
        return _from_mat(path, variable)
    if kind in (".npy", ".npz"):
        return _chosen(path, _load(path), variable)
    if kind in (".csv", ".txt"):
        return _from_table(path)
    raise InvalidInputError(f"{path}: cameras are read from {_READ_HERE}, not from {kind or 'a file without ending'}.")


def _from_numbers(
    path: Path,
    numbers: FloatArray,
    shapes: Shape | Sequence[Shape] | None,
    unit: float,
    pixels: PixelConvention | None,
) -> tuple[Camera, ...]:
    if not np.all(np.isfinite(numbers)):
        raise InvalidInputError(f"{path}: a coefficient is not a finite number; calibrate again or repair the file.")
    dlt = numbers.ndim == 2
    rows = numbers.T if dlt else numbers
    counted = pixels or (MATLAB_PIXELS if dlt else OPENCV_PIXELS)
    build = camera_from_dlt if dlt else camera_from_matrix
    sizes = _shapes(path, shapes, len(rows))
    return tuple(
        build(row, shape, unit=unit, pixels=counted, name=f"camera {k}")
        for k, (row, shape) in enumerate(zip(rows, sizes, strict=True), start=1)
    )


def _shapes(path: Path, shapes: Shape | Sequence[Shape] | None, count: int) -> list[Shape]:
    if shapes is None:
        raise InvalidInputError(f"{path} does not say how large the images are; give their rows and columns.")
    sizes = np.array(shapes, dtype=np.int64)
    sizes = np.tile(sizes, (count, 1)) if sizes.shape == (2,) else sizes
    if sizes.shape != (count, 2):
        raise InvalidInputError(
            f"{path} is the calibration of {count} camera{'' if count == 1 else 's'}, but there are images of "
            f"{len(sizes)}; name the images of these cameras, each once."
        )
    return [(int(r), int(c)) for r, c in sizes]


def _refuse_other_shapes(path: Path, cameras: Sequence[Camera], shapes: Shape | Sequence[Shape] | None) -> None:
    if shapes is None:
        return
    for camera, shape in zip(cameras, _shapes(path, shapes, len(cameras)), strict=True):
        if camera.shape != shape:
            raise InvalidInputError(
                f"{path}: {camera.name} was calibrated with images of {camera.shape[0]} x {camera.shape[1]} pixels, "
                f"but these have {shape[0]} x {shape[1]}."
            )


def _from_table(path: Path) -> FloatArray:
    text = path.suffix.lower() == ".csv"
    table = read_text_table(path, "," if text else None, "rows").numbers
    return _as_cameras(path, table)


def _as_cameras(path: Path, table: FloatArray) -> FloatArray:
    if table.ndim == 2 and len(table) == DLT_COEFFICIENTS:
        return table
    if table.ndim == 2 and table.shape[1] == 4 and len(table) % 3 == 0:
        return table.reshape(-1, 3, 4)
    if table.ndim == 3 and table.shape[1:] == (3, 4):
        return table
    raise InvalidInputError(
        f"{path}: cameras are 11 rows of DLT coefficients with a column each camera, or 3 rows of 4 numbers each "
        f"camera; got {' x '.join(map(str, table.shape))} numbers."
    )


def _load(path: Path) -> dict[str, FloatArray]:
    require_regular_file(path)
    try:
        with path.open("rb") as file:
            loaded = np.load(file, allow_pickle=False)
            if isinstance(loaded, np.ndarray):
                return {path.stem: _real(loaded)}
            return {name: _real(loaded[name]) for name in loaded.files}
    except FileNotFoundError as error:
        raise InvalidInputError(f"{path}: there is no such file.") from error
    except (OSError, ValueError, EOFError, MemoryError, zipfile.BadZipFile) as error:
        raise InvalidInputError(f"{path} cannot be read as a NumPy file; it is damaged or no such file.") from error


def _real(values: NDArray) -> FloatArray:
    return values.astype(np.float64) if values.dtype.kind in "iuf" else np.empty(0)


def _chosen(path: Path, arrays: dict[str, FloatArray], variable: str | None) -> FloatArray:
    """The one variable that can be cameras, or several (3, 4) matrices in the order of the file."""
    if variable is not None:
        if variable not in arrays:
            raise InvalidInputError(f"{path} has no variable {variable!r}; it has {', '.join(list(arrays)[:20])}.")
        return _as_cameras(path, arrays[variable])
    if len(arrays) == 1:
        return _as_cameras(path, next(iter(arrays.values())))
    single = {name: array for name, array in arrays.items() if array.shape == (3, 4)}
    whole = {
        name: array
        for name, array in arrays.items()
        if (array.ndim == 2 and len(array) == DLT_COEFFICIENTS) or (array.ndim == 3 and array.shape[1:] == (3, 4))
    }
    if len(whole) + bool(single) != 1:
        raise InvalidInputError(
            f"{path}: {', '.join([*whole, *single]) or 'none of its variables'} could be cameras; "
            "name one by --camera-variable."
        )
    return next(iter(whole.values())) if whole else np.stack(list(single.values()))


def _from_mat(path: Path, variable: str | None) -> FloatArray:
    """The coefficients `coefs` of easyWandData, or another variable of 11 rows."""
    file = binary_file(path, "mat")
    request = Request(path=str(path), name=str(path), layout=file.layout, form="mat", summary=True)
    arrays: dict[str, FloatArray] = {}
    for name, found in shared_reader().read(request).groups:
        values = found[0].numbers
        if values is not None and values.size % DLT_COEFFICIENTS == 0 and values.size:
            arrays[name] = values.reshape((DLT_COEFFICIENTS, -1), order="F")
    wanted = variable or next((name for name in arrays if name.split(".")[-1] == "coefs"), None)
    if wanted is None or wanted not in arrays:
        raise InvalidInputError(
            f"{path} has no {wanted or 'easyWandData.coefs'} of 11 coefficients a camera; it has "
            f"{', '.join(list(arrays)[:12]) or 'nothing of 11 rows'}."
        )
    return arrays[wanted]

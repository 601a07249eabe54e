"""Formats of files, told by their first bytes: a mapping that contradicts them is refused."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Literal

from flycontrol.errors import InvalidInputError

TextFormat = Literal["whitespace", "csv", "tsv"]
BinaryFormat = Literal["mat", "hdf5", "netcdf", "parquet"]
FileFormat = Literal["whitespace", "csv", "tsv", "mat", "hdf5", "netcdf", "parquet"]
Layout = Literal["matlab 5", "matlab 7.3", "hdf5", "netcdf classic", "parquet"]

TEXT_FORMATS: tuple[TextFormat, ...] = ("csv", "tsv", "whitespace")

_HDF5 = b"\x89HDF\r\n\x1a\n"
_USER_BLOCKS = (0, 512, 1024, 2048, 4096)  #: where HDF5's first bytes may stand; MATLAB 7.3 puts its own before them
_WHAT = {
    "matlab 5": "a MATLAB file",
    "matlab 7.3": "a MATLAB 7.3 file",
    "hdf5": "an HDF5 file",
    "netcdf classic": "a netCDF file",
    "parquet": "a Parquet file",
}
_FORMAT: dict[Layout, BinaryFormat] = {
    "matlab 5": "mat",
    "matlab 7.3": "mat",
    "hdf5": "hdf5",
    "netcdf classic": "netcdf",
    "parquet": "parquet",
}
_READABLE: dict[BinaryFormat, tuple[Layout, ...]] = {
    "mat": ("matlab 5", "matlab 7.3"),
    "hdf5": ("hdf5", "matlab 7.3"),
    "netcdf": ("netcdf classic", "hdf5"),  # netCDF-4 is HDF5
    "parquet": ("parquet",),
}
_FOREIGN = {
    b"PK\x03\x04": ("a zip archive or a spreadsheet", "export the sheet as CSV"),
    b"\xd0\xcf\x11\xe0": ("an old spreadsheet", "export the sheet as CSV"),
    b"\x1f\x8b": ("compressed by gzip", "unpack it"),
    b"\x93NUMPY": ("a NumPy file", "save it as CSV, HDF5 or .mat"),
    b"CDF\x05": ("a netCDF file of the 64-bit data kind", "convert it by nccopy -k netCDF-4"),
}


@dataclass(frozen=True, slots=True)
class BinaryFile:
    """A regular file that is no text, what it is by its first bytes, and the hash of its bytes."""

    path: Path
    name: str  #: as the user wrote it
    layout: Layout
    sha256: str


def binary_file(path: Path, form: BinaryFormat) -> BinaryFile:
    """Look at a file's first bytes and hash it.

    Raises
    ------
    InvalidInputError
        If there is no such file, if it is empty or unreadable, or if its first bytes are those of another format.
    """
    require_regular_file(path)
    try:
        with path.open("rb") as file:
            layout = _layout(file, str(path), form)
            file.seek(0)
            sha256 = hashlib.file_digest(file, "sha256").hexdigest()
    except FileNotFoundError as error:
        raise InvalidInputError(f"{path}: there is no such file.") from error
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror or error}.") from error
    return BinaryFile(path, str(path), layout, sha256)


def require_regular_file(path: Path) -> None:
    """Refuse a folder and a device, which may never end."""
    try:
        if path.is_dir():
            raise InvalidInputError(f"{path} is a folder; name a file in it.")
        if path.exists() and not path.is_file():
            raise InvalidInputError(f"{path} is not a regular file; save the data in a file first.")
    except InvalidInputError:
        raise
    except (OSError, ValueError) as error:  # a name too long, a zero byte in it
        raise InvalidInputError(f"{str(path)[:100]!r} cannot be read: {error}.") from error


def refuse_binary(name: str, data: bytes) -> None:
    """Refuse the bytes of a known binary format where a text table was expected, and say which format they are."""
    layout = next(_layouts(data), None)
    if layout is not None:
        raise InvalidInputError(
            f"{name} is {_WHAT[layout]} by its first bytes, no text; say format = '{_FORMAT[layout]}' in the mapping's "
            "[file] and name its variables."
        )
    _refuse_foreign(name, data)


def sniffed_format(path: Path) -> BinaryFormat | None:
    """Tell the binary format of a file by its first bytes; None for text and for what is not known here."""
    require_regular_file(path)
    try:
        with path.open("rb") as file:
            layout = next(_layouts(file.read(_USER_BLOCKS[-1] + len(_HDF5))), None)
    except OSError:
        return None
    return None if layout is None else _FORMAT[layout]


def _layout(file: BinaryIO, name: str, form: BinaryFormat) -> Layout:
    head = file.read(_USER_BLOCKS[-1] + len(_HDF5))
    if not head:
        raise InvalidInputError(f"{name} is empty.")
    layout = next(_layouts(head), None)
    if layout in _READABLE[form]:
        return layout
    if layout is not None:
        raise InvalidInputError(
            f"{name} is {_WHAT[layout]} by its first bytes, but the mapping says format = '{form}'; "
            f"say format = '{_FORMAT[layout]}'."
        )
    _refuse_foreign(name, head)
    what = _WHAT[_READABLE[form][0]]
    raise InvalidInputError(f"{name} is not {what}: it begins with {head[:8]!r}; is file.format in the mapping right?")


def _layouts(head: bytes) -> Iterator[Layout]:
    if any(head[block : block + len(_HDF5)] == _HDF5 for block in _USER_BLOCKS):
        yield "matlab 7.3" if head.startswith(b"MATLAB 7.3") else "hdf5"
    elif head.startswith(b"MATLAB 5.0") or (head[126:128] in (b"IM", b"MI") and head.startswith(b"MATLAB")):
        yield "matlab 5"
    elif head[:4] in (b"CDF\x01", b"CDF\x02"):
        yield "netcdf classic"
    elif head[:4] == b"PAR1":
        yield "parquet"


def _refuse_foreign(name: str, data: bytes) -> None:
    for first, (what, remedy) in _FOREIGN.items():
        if data.startswith(first):
            raise InvalidInputError(f"{name} is {what}, which is not read here; {remedy}.")

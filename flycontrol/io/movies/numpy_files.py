"""Films in NumPy's files, never more than a frame of them in memory."""

from __future__ import annotations

import shutil
import tempfile
import zipfile
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.refusals import refusing

_CHUNK = 2**20  #: bytes that are unpacked at once
_SPARE = 2**28  #: bytes left free on the disk
_MOST_NUMBERS = 1_000  #: of a variable that says something of a film


def open_npy(path: Path) -> NDArray:
    """Map a .npy file; InvalidInputError if it is damaged or holds objects."""
    with refusing(str(path)), path.open("rb") as file:
        shape, dtype, fortran = _header(file)
        if dtype.hasobject:
            raise InvalidInputError("holds pickled objects, which are not read; save a plain array")
        start = file.tell()
        size = path.stat().st_size - start
        if size < _bytes(shape, dtype):
            raise InvalidInputError(f"is cut off: {size} bytes instead of {_bytes(shape, dtype)}")
        return _mapped(path, dtype, shape, start, fortran=fortran)


class NpzFile:
    """The variables of a .npz file: their shapes at once, the numbers of a film through a temporary file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with self._archive() as archive:
            members = [name for name in archive.namelist() if name.endswith(".npy")]
            self._heads = {name.removesuffix(".npy"): self._head(archive, name) for name in members}

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Shapes of the variables, by name."""
        return {name: shape for name, (shape, _, _) in self._heads.items()}

    def kind(self, name: str) -> np.dtype:
        """Return the type of a variable's numbers."""
        return self._heads[name][1]

    def small(self, name: str) -> NDArray | None:
        """Read a variable of a few numbers; None if it is large or no numbers."""
        shape, dtype, _ = self._heads[name]
        if dtype.hasobject or dtype.kind not in "biuf" or _count(shape) > _MOST_NUMBERS:
            return None
        with self._archive() as archive, archive.open(f"{name}.npy") as member:
            return np.lib.format.read_array(member, allow_pickle=False)

    def mapped(self, name: str) -> NDArray:
        """Unpack a variable into a temporary file, which goes with the array, and map it.

        Raises
        ------
        InvalidInputError
            If it is damaged, holds objects, or if the disk has no room for it.
        """
        shape, dtype, fortran = self._heads[name]
        if dtype.hasobject:
            raise InvalidInputError(
                f"{self.path}: {name} holds pickled objects, which are not read; save plain arrays."
            )
        needed = _bytes(shape, dtype)
        self._require_room(name, needed)
        with (
            self._archive() as archive,
            archive.open(f"{name}.npy") as member,
            tempfile.TemporaryFile(prefix="flycontrol-") as unpacked,
        ):
            _header(member)
            copied = 0
            while chunk := member.read(_CHUNK):
                copied += len(chunk)
                if copied > needed:
                    raise InvalidInputError(f"{name} is longer than it says")
                unpacked.write(chunk)
            if copied != needed:
                raise InvalidInputError(f"{name} is cut off")
            unpacked.flush()
            return _mapped(unpacked, dtype, shape, 0, fortran=fortran)

    def _require_room(self, name: str, needed: int) -> None:
        folder = tempfile.gettempdir()
        if needed > (free := shutil.disk_usage(folder).free - _SPARE):
            raise InvalidInputError(
                f"{self.path}: {name} unpacks to {needed / 1e9:.3g} GB and {folder} has room for "
                f"{max(free, 0) / 1e9:.3g} GB; name a larger place in TMPDIR, or save the film as .npy, which is read "
                "where it lies."
            )

    @contextmanager
    def _archive(self) -> Generator[zipfile.ZipFile]:
        with refusing(str(self.path)):
            with self.path.open("rb") as file:
                if not file.read(2).startswith(b"PK"):
                    raise InvalidInputError("is no .npz file by its first bytes")
            with zipfile.ZipFile(self.path) as archive:
                yield archive

    @staticmethod
    def _head(archive: zipfile.ZipFile, name: str) -> tuple[tuple[int, ...], np.dtype, bool]:
        with archive.open(name) as member:
            return _header(member)


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype, bool]:
    """Shape, type of numbers, and whether columns run first."""
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, fortran, dtype = read(file)
    if min(shape, default=0) < 0:
        raise InvalidInputError("declares a negative length")
    return tuple(int(n) for n in shape), dtype, fortran


def _mapped(file: Any, dtype: np.dtype, shape: tuple[int, ...], start: int, *, fortran: bool) -> NDArray:
    if not _bytes(shape, dtype):
        return np.empty(shape, dtype)
    return np.memmap(file, dtype=dtype, mode="r", offset=start, shape=shape, order="F" if fortran else "C")


def _count(shape: tuple[int, ...]) -> int:
    count = 1
    for length in shape:
        count *= length
    return count


def _bytes(shape: tuple[int, ...], dtype: np.dtype) -> int:
    return _count(shape) * dtype.itemsize

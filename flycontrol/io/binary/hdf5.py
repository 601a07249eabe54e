"""HDF5 and netCDF-4 files, through h5py."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.packing import unpacked
from flycontrol.io.binary.source import DEEPEST, MOST_NAMES, numbers, parts, refuse_huge, refuse_unknown


@dataclass(frozen=True, slots=True)
class Hdf5:
    """An open file; `packed` where netCDF's conventions of scale, offset and fill values hold."""

    file: Any
    packed: bool

    def names(self) -> list[str]:
        """Paths of the datasets, as "trial/yaw"."""
        return dataset_names(self.file)

    def value(self, path: str) -> NDArray | str:
        """Read a dataset; netCDF's packed numbers are unpacked, and fill values become NaN."""
        dataset = self._dataset(path)
        array = read_dataset(dataset)
        return unpacked(numbers(array), self._attributes(dataset)) if self.packed and _is_numeric(array) else array

    def unit(self, path: str) -> str:
        """Return the attribute "units" or "unit" of a dataset."""
        attributes = self._attributes(self._dataset(path))
        unit = attributes.get("units", attributes.get("unit", ""))
        return unit if isinstance(unit, str) else ""

    def attribute(self, group: str, name: str) -> object:
        """Return an attribute of a group, else of the file."""
        for place in (find(self.file, group) if group else self.file, self.file):
            if place is not None and name in place.attrs:
                return _plain_attribute(place.attrs[name])
        return None

    def groups(self, pattern: str) -> list[str]:
        """Return groups whose path fits."""
        return group_names(self.file, pattern)

    def _dataset(self, path: str) -> Any:
        found = find(self.file, path)
        if found is None:
            refuse_unknown(path, self.names())
        if not hasattr(found, "shape"):
            raise InvalidInputError(f"is a group with {', '.join(list(found)[:12]) or 'nothing in it'}; name one")
        return found

    def _attributes(self, dataset: Any) -> dict[str, object]:
        return {name: _plain_attribute(dataset.attrs[name]) for name in list(dataset.attrs)[:100]}


@contextmanager
def open_hdf5(path: Path, *, packed: bool) -> Generator[Hdf5]:
    """Open a file for reading; what h5py raises at damaged ones is left to the caller."""
    import h5py

    with h5py.File(path, "r") as file:
        yield Hdf5(file, packed)


def find(file: Any, path: str) -> Any:
    """Return what lies at a path, as it is written or with dots for slashes; None if nothing does."""
    for written in (path, "/".join(parts(path))):
        if written and written in file:
            return file[written]
    return None


def dataset_names(file: Any) -> list[str]:
    """Paths of all datasets, to a depth and a number at which nobody reads on."""
    found: list[str] = []
    _collect(file, "", 0, found)
    return found


def group_names(file: Any, pattern: str) -> list[str]:
    """Paths of the groups directly inside a group that fit a pattern."""
    steps = parts(pattern)
    outer = "/".join(steps[:-1])
    inside = find(file, outer) if outer else file
    if inside is None or hasattr(inside, "shape") or not steps:
        return []
    fitting = [name for name in inside if fnmatchcase(name, steps[-1]) and not name.startswith("#")]
    return [f"{outer}/{name}".lstrip("/") for name in fitting if not hasattr(inside[name], "shape")]


def read_dataset(dataset: Any) -> NDArray | str:
    """Read a dataset after a look at its shape; a single text is returned as such."""
    if dataset.shape is None:
        raise InvalidInputError("is empty")
    refuse_huge(dataset.shape)
    if dataset.dtype.kind in "OS":
        return _texts(dataset)
    value = dataset[()]
    return np.asarray(value)


def _texts(dataset: Any) -> NDArray | str:
    import h5py

    if dataset.dtype.kind == "O" and h5py.check_string_dtype(dataset.dtype) is None:
        raise InvalidInputError("holds references or lists; numbers or texts are needed")
    value = dataset.asstr(errors="replace")[()]
    return value if isinstance(value, str) else np.asarray(value, dtype=np.str_)


def _collect(group: Any, path: str, depth: int, found: list[str]) -> None:
    for name in group:
        if len(found) >= MOST_NAMES or depth > DEEPEST:
            return
        if name.startswith("#"):  # MATLAB's own
            continue
        item = group.get(name)
        if hasattr(item, "shape"):
            found.append(f"{path}{name}")
        elif item is not None:
            _collect(item, f"{path}{name}/", depth + 1, found)


def _is_numeric(array: NDArray | str) -> bool:
    return not isinstance(array, str) and array.dtype.kind in "biufc"


def _plain_attribute(value: Any) -> object:
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    if isinstance(value, np.ndarray):
        return _plain_attribute(value.reshape(-1)[0]) if value.size == 1 else None
    return value.item() if isinstance(value, np.generic) else value

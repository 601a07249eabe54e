"""Classic netCDF files, through scipy."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.io.binary.packing import unpacked
from flycontrol.io.binary.source import MOST_NAMES, numbers, refuse_unknown


@dataclass(frozen=True, slots=True)
class ClassicNetcdf:
    """An open file; its variables have no groups."""

    file: Any

    def names(self) -> list[str]:
        """Names of the variables."""
        return list(self.file.variables)[:MOST_NAMES]

    def value(self, path: str) -> NDArray | str:
        """Read a variable; packed numbers are unpacked, fill values become NaN, characters a text."""
        variable = self._variable(path)
        data = np.array(variable[:] if variable.shape else variable.getValue())
        if data.dtype.kind == "S":
            return _text(data)
        return unpacked(numbers(data.astype(data.dtype.newbyteorder("="))), self._attributes(variable))

    def unit(self, path: str) -> str:
        """Return the attribute "units" of a variable."""
        unit = self._attributes(self._variable(path)).get("units", "")
        return unit if isinstance(unit, str) else ""

    def attribute(self, group: str, name: str) -> object:
        """Return an attribute of the file."""
        del group
        return _plain(self.file._attributes.get(name))  # the reader's own; attributes as such may hide its methods

    def groups(self, pattern: str) -> list[str]:
        """Classic files have no groups."""
        del pattern
        return []

    def _variable(self, path: str) -> Any:
        found = self.file.variables.get(path.strip("/"))
        if found is None:
            refuse_unknown(path, self.names())
        return found

    def _attributes(self, variable: Any) -> dict[str, object]:
        return {name: _plain(value) for name, value in variable._attributes.items()}


@contextmanager
def open_netcdf3(path: Path) -> Generator[ClassicNetcdf]:
    """Open a file for reading; what scipy raises at damaged ones is left to the caller."""
    from scipy.io import netcdf_file

    with path.open("rb") as file:
        yield ClassicNetcdf(netcdf_file(file, "r", mmap=False))


def _text(data: NDArray) -> NDArray | str:
    if data.ndim <= 1:
        return data.tobytes().rstrip(b"\0").decode("utf-8", "replace")
    rows = data.reshape(-1, data.shape[-1])
    return np.array([row.tobytes().rstrip(b"\0").decode("utf-8", "replace") for row in rows], dtype=np.str_)


def _plain(value: Any) -> object:
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    if isinstance(value, np.ndarray | np.generic):
        return value.reshape(-1)[0].item() if value.size == 1 else None
    return value

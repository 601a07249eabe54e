"""MATLAB files up to version 7, through scipy."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.source import DEEPEST, MOST_NAMES, parts, refuse_huge, refuse_unknown

_STEP = re.compile(r"(?P<name>[^(){}]*)(?:[({](?P<element>\d{1,6})[)}])?")


@dataclass(frozen=True, slots=True)
class Matlab5:
    """The variables of a file by name, as scipy reads them: structures are record arrays, cells object arrays."""

    variables: dict[str, Any]
    others: tuple[str, ...] = ()  #: names of variables that nobody asked for

    def names(self) -> list[str]:
        """Paths of the variables, those inside structures as "trial.yaw" and "trials(2).yaw"."""
        found: list[str] = []
        for name, value in self.variables.items():
            for path in _leaves(name, value, 0):
                found.append(path)
                if len(found) == MOST_NAMES:
                    return found
        return found + list(self.others)

    def value(self, path: str) -> NDArray | str:
        """Follow a path: fields by . or /, elements of an array of structures or of a cell by (k) or {k}, from 1."""
        inner: Any = _Workspace(self.variables)
        for step in parts(path):
            inner = _inside(inner, step)
            if inner is None:
                refuse_unknown(path, self.names())
        return _plain(inner)

    def unit(self, path: str) -> str:
        """MATLAB's files state no units."""
        del path
        return ""

    def attribute(self, group: str, name: str) -> object:
        """MATLAB's files have no attributes."""
        del group, name

    def groups(self, pattern: str) -> list[str]:
        """Return structures whose name fits, one path for each element of an array of structures."""
        outer, _, last = pattern.rpartition(".")
        inside: Any = self.variables if not outer else self._fields(outer)
        found: list[str] = []
        for name, value in inside.items():
            if fnmatchcase(name, last) and _is_structure(value):
                path = f"{outer}.{name}" if outer else name
                found += [path] if value.size == 1 else [f"{path}({k + 1})" for k in range(value.size)]
        return found

    def _fields(self, path: str) -> dict[str, Any]:
        inner: Any = _Workspace(self.variables)
        for step in parts(path):
            inner = _inside(inner, step)
        return {name: inner[name].flat[0] for name in inner.dtype.names} if _is_structure(inner) else {}


def open_matlab5(path: Path, wanted: Iterable[str] | None) -> Matlab5:
    """Read the variables in which the wanted paths begin, or all: a film in the same file costs nothing.

    What scipy raises at damaged files is left to the caller.
    """
    from scipy.io import loadmat, whosmat

    names = None
    if wanted is not None and not any("*" in path for path in wanted):
        names = {re.split(r"[({]", parts(path)[0])[0] for path in wanted if parts(path)}
    with path.open("rb") as file:
        variables = loadmat(file, spmatrix=False, verify_compressed_data_integrity=True, variable_names=names)
        others = () if names is None else tuple(name for name, _, _ in whosmat(file) if name not in names)
    return Matlab5({name: value for name, value in variables.items() if not name.startswith("__")}, others)


@dataclass(frozen=True, slots=True)
class _Workspace:
    variables: dict[str, Any]


def _inside(value: Any, step: str) -> Any:
    parsed = _STEP.fullmatch(step)
    if parsed is None:
        return None
    inner = _field(value, parsed["name"])
    return inner if parsed["element"] is None or inner is None else _element(inner, int(parsed["element"]))


def _field(value: Any, name: str) -> Any:
    if isinstance(value, _Workspace):
        return value.variables.get(name)
    if not _is_structure(value) or name not in value.dtype.names:
        return None
    if value.size != 1:
        raise InvalidInputError(
            f"passes through an array of {value.size} structures; choose one, as in trials(1).yaw, or name the "
            "array in [trial] groups"
        )
    return value[name].flat[0]


def _element(value: Any, element: int) -> Any:
    if not isinstance(value, np.ndarray) or not 1 <= element <= value.size:
        raise InvalidInputError(f"has no element {element}, counted from 1")
    flat = value.reshape(-1, order="F")
    return flat[element - 1] if value.dtype.kind == "O" else flat[element - 1 : element]


def _is_structure(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.names is not None and type(value).__name__ == "ndarray"


def _plain(value: Any) -> NDArray | str:
    from scipy.sparse import issparse

    if issparse(value):
        return _dense(value)
    if type(value).__name__ in ("MatlabOpaque", "MatlabObject", "MatlabFunction"):
        raise InvalidInputError("is a MATLAB object (a table, a datetime, a string); save plain arrays or structures")
    if not isinstance(value, np.ndarray):
        raise InvalidInputError("is neither numbers nor text")
    if _is_structure(value):
        raise InvalidInputError(f"is a structure with the fields {', '.join(value.dtype.names or ())[:100]}; name one")
    if value.dtype.kind == "O":
        raise InvalidInputError("is a cell array; choose an element, as in c{1}, or save plain arrays")
    if value.dtype.kind == "U" and value.size <= 1:
        return str(value.flat[0]) if value.size else ""
    return value


def _dense(value: Any) -> NDArray:
    """Write out a sparse matrix, after a look at its indices, which C code trusts."""
    refuse_huge(value.shape)
    matrix = value.tocoo() if value.format not in ("csc", "csr") else value
    if matrix.format in ("csc", "csr"):
        matrix.check_format(full_check=True)
    return matrix.toarray()


def _leaves(path: str, value: Any, depth: int) -> Iterator[str]:
    if not _is_structure(value) or depth == DEEPEST:
        yield path
        return
    flat = value.reshape(-1, order="F")
    for k, element in enumerate(flat[:100]):
        inner = path if flat.size == 1 else f"{path}({k + 1})"
        for name in value.dtype.names or ():
            yield from _leaves(f"{inner}.{name}", element[name], depth + 1)

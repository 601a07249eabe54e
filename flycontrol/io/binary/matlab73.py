"""MATLAB files of version 7.3: HDF5 in MATLAB's own dialect, with all arrays transposed."""

from __future__ import annotations

import re
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.hdf5 import dataset_names, group_names, read_dataset
from flycontrol.io.binary.source import parts, refuse_huge, refuse_unknown

_STEP = re.compile(r"(?P<name>[^(){}]*)(?:[({](?P<element>\d{1,6})[)}])?")


@dataclass(frozen=True, slots=True)
class Matlab73:
    """An open file: structures are groups, cells and arrays of structures are datasets of references."""

    file: Any

    def names(self) -> list[str]:
        """Paths of the variables, those inside structures as "trial.yaw"."""
        return [name.replace("/", ".") for name in dataset_names(self.file)]

    def value(self, path: str) -> NDArray | str:
        """Follow a path: fields by . or /, elements of an array of structures or of a cell by (k) or {k}, from 1."""
        inner, element = self.file, None
        for step in parts(path):
            inner, element = self._inside(inner, step, element)
            if inner is None:
                refuse_unknown(path, self.names())
        return _plain(inner) if element is None else _plain(_referred(self.file, inner, element))

    def unit(self, path: str) -> str:
        """MATLAB's files state no units."""
        del path
        return ""

    def attribute(self, group: str, name: str) -> object:
        """MATLAB's files have no attributes of the user's."""
        del group, name

    def groups(self, pattern: str) -> list[str]:
        """Return structures whose name fits, one path for each element of an array of structures."""
        found: list[str] = []
        for path in group_names(self.file, pattern):
            count = _elements(self.file[path])
            name = path.replace("/", ".")
            found += [name] if count == 1 else [f"{name}({k + 1})" for k in range(count)]
        return found

    def _inside(self, outer: Any, step: str, element: int | None) -> tuple[Any, int | None]:
        """Return a field, and the element still to be chosen from its references where it is an array's."""
        parsed = _STEP.fullmatch(step)
        if parsed is None or not hasattr(outer, "keys") or parsed["name"] not in outer:
            return None, None
        inner = outer[parsed["name"]]
        if element is not None:  # of an array of structures, whose fields hold one reference for each element
            inner = _referred(self.file, inner, element)
        chosen = parsed["element"]
        if chosen is None:
            _refuse_array_of_structures(inner)
            return inner, None
        if hasattr(inner, "keys"):
            return (inner, int(chosen)) if _elements(inner) > 1 else (inner, None)
        return _referred(self.file, inner, int(chosen)), None


@contextmanager
def open_matlab73(path: Path) -> Generator[Matlab73]:
    """Open a file for reading; what h5py raises at damaged ones is left to the caller."""
    import h5py

    with h5py.File(path, "r") as file:
        yield Matlab73(file)


def _elements(group: Any) -> int:
    """Count the elements of a structure: more than one if all its fields hold references, none of them a cell."""
    import h5py

    counts: set[int] = set()
    for name in group:
        field = group[name]
        is_reference = hasattr(field, "shape") and h5py.check_ref_dtype(field.dtype) is not None
        if not is_reference or "MATLAB_class" in field.attrs:
            return 1
        counts.add(int(field.size or 0))
    return counts.pop() if len(counts) == 1 else 1


def _refuse_array_of_structures(value: Any) -> None:
    if hasattr(value, "keys") and (count := _elements(value)) > 1:
        raise InvalidInputError(
            f"passes through an array of {count} structures; choose one, as in trials(1).yaw, or name the array in "
            "[trial] groups"
        )


def _referred(file: Any, dataset: Any, element: int) -> Any:
    import h5py

    if not hasattr(dataset, "shape") or h5py.check_ref_dtype(dataset.dtype) is None:
        raise InvalidInputError("is no cell array and no array of structures, so it has no elements to choose")
    refuse_huge(dataset.shape)
    references = dataset[()].reshape(-1)  # transposed twice: C order of the file is MATLAB's own order
    if not 1 <= element <= references.size:
        raise InvalidInputError(f"has no element {element}, counted from 1")
    return file[references[element - 1]]


def _plain(value: Any) -> NDArray | str:
    if hasattr(value, "keys"):
        return _from_group(value)
    kind = _matlab_class(value)
    if kind in ("cell", "function_handle") or kind.startswith(("table", "datetime", "string", "categorical")):
        raise InvalidInputError(f"is a {kind or 'cell'}; choose an element, as in c{{1}}, or save plain arrays")
    if "MATLAB_empty" in value.attrs:  # what is stored is the shape
        return _empty(value)
    array = read_dataset(value)
    if isinstance(array, str):
        return array
    if array.dtype.names is not None:
        raise InvalidInputError("is complex; real numbers are needed")
    if kind == "char":
        return _characters(array)
    return array.T


def _empty(value: Any) -> NDArray:
    shape = [int(n) for n in np.asarray(read_dataset(value)).reshape(-1)[:32]]
    if not shape or min(shape) != 0:
        raise InvalidInputError("is empty")
    return np.empty(shape)


def _from_group(group: Any) -> NDArray:
    if "MATLAB_sparse" not in group.attrs:
        raise InvalidInputError(f"is a structure with the fields {', '.join(list(group)[:12])}; name one")
    from scipy.sparse import csc_array

    rows = int(group.attrs["MATLAB_sparse"])
    columns = int(group["jc"].size or 1) - 1
    refuse_huge((rows, columns))
    if "data" not in group:  # MATLAB leaves out what an empty matrix would not hold
        return np.zeros((rows, columns))
    data, index, first = (np.asarray(read_dataset(group[name])) for name in ("data", "ir", "jc"))
    if data.dtype.names is not None:
        raise InvalidInputError("is complex; real numbers are needed")
    matrix = csc_array((data, index.astype(np.int64), first.astype(np.int64)), shape=(rows, columns))
    matrix.check_format(full_check=True)
    return matrix.toarray()


def _characters(codes: NDArray) -> str:
    if codes.dtype.kind not in "ui" or codes.size > 100_000:
        raise InvalidInputError("is a text that cannot be read")
    return codes.astype("<u2").tobytes().decode("utf-16-le", "replace")


def _matlab_class(value: Any) -> str:
    name = value.attrs.get("MATLAB_class", b"")
    return name.decode("ascii", "replace") if isinstance(name, bytes) else str(name)

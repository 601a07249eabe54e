"""An open binary file: its variables by path, whatever its format, as numbers, as text, or refused."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches
from typing import NoReturn, Protocol

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError

FloatArray = NDArray[np.float64]

MOST_NUMBERS = 50_000_000  #: of one variable: what fits in memory everywhere
MOST_NAMES = 2_000  #: variables that are listed
DEEPEST = 20  #: groups within groups

_SEPARATOR = re.compile(r"[./]")


class AbsentError(InvalidInputError):
    """Nothing lies at a path."""


class Source(Protocol):
    """A file that is open for reading; its refusals name neither the file nor the mapping: the caller does."""

    def names(self) -> list[str]:
        """Paths of the variables, at most MOST_NAMES."""
        ...

    def value(self, path: str) -> NDArray | str:
        """Return a variable as an array of any type and shape, or as a text; InvalidInputError if it is neither."""
        ...

    def unit(self, path: str) -> str:
        """Return the unit that the file states for a variable, else an empty text."""
        ...

    def attribute(self, group: str, name: str) -> object:
        """Return an attribute of a group, else of the file; None if there is none."""
        ...

    def groups(self, pattern: str) -> list[str]:
        """Paths of the groups that a name, a pattern with *, or an array of structures stands for."""
        ...


def numbers(value: NDArray | str) -> FloatArray:
    """Return an array of real numbers in float64; InvalidInputError for anything else."""
    if isinstance(value, str):
        raise InvalidInputError(f"is the text {value[:40]!r}; numbers are needed")
    refuse_huge(value.shape)
    if value.dtype.kind == "c":
        raise InvalidInputError("is complex; real numbers are needed")
    if value.dtype.kind not in "biuf":
        raise InvalidInputError(f"holds {_kind(value.dtype)}; numbers are needed")
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is refused as infinite, with its sample
        return value.astype(np.float64)


def text(value: NDArray | str) -> str:
    """Return a text, or a whole number as one; InvalidInputError for anything else."""
    if isinstance(value, str):
        return value.strip()
    if value.size == 1:
        item = value.reshape(-1)[0]
        return _scalar_text(item)
    raise InvalidInputError(f"has the shape {shape_text(value.shape)}; one text is needed")


def texts(value: NDArray | str) -> list[str]:
    """Return one text for each sample; InvalidInputError for what is no list of texts or numbers."""
    if isinstance(value, str):
        raise InvalidInputError(f"is the text {value[:40]!r}; one text for each sample is needed")
    flat = np.squeeze(value) if value.size != 1 else value.reshape(-1)
    if flat.ndim != 1 or flat.size > MOST_NUMBERS:
        raise InvalidInputError(f"has the shape {shape_text(value.shape)}; one text for each sample is needed")
    return [_scalar_text(item) for item in flat]


def series(values: FloatArray, row: int | None, column: int | None) -> FloatArray:
    """Return a row or column of a two-dimensional array, counted from 0, or a vector whichever way it lies."""
    if values.size == 0:
        raise InvalidInputError("is empty")
    if row is None and column is None:
        flat = np.squeeze(values) if values.size != 1 else values.reshape(-1)
        if flat.ndim != 1:
            raise InvalidInputError(
                f"has the shape {shape_text(values.shape)}; choose one of its rows or columns, as row = 0 or column = 0"
            )
        return flat
    if values.ndim != 2:
        raise InvalidInputError(f"has the shape {shape_text(values.shape)}, without rows and columns to choose from")
    axis, index, what = (0, row, "row") if row is not None else (1, column, "column")
    if index is None or index >= values.shape[axis]:
        raise InvalidInputError(f"has the shape {shape_text(values.shape)}, so {what} {index} (from 0) is beyond it")
    return values[index] if axis == 0 else values[:, index]


def refuse_huge(shape: Iterable[int]) -> None:
    """Refuse a shape that declares more numbers than a recording holds, before memory is asked for."""
    count = 1
    for length in shape:
        count *= int(length)
    if count > MOST_NUMBERS or count < 0:
        raise InvalidInputError(
            f"has {count:.3g} numbers by its shape; at most {MOST_NUMBERS:.0e} are read: cut the recording"
        )


def refuse_unknown(path: str, names: list[str]) -> NoReturn:
    """Refuse a path that is not there and name the nearest one."""
    near = get_close_matches(path, names, n=1) or [name for name in names if parts(name)[-1:] == parts(path)[-1:]]
    known = f"the nearest is {near[0]!r}" if near else f"there are {', '.join(names[:12]) or 'none'}"
    raise AbsentError(f"is not there; {known}")


def parts(path: str) -> list[str]:
    """Names along a path: "trial.yaw" and "trial/yaw" are the same."""
    return [part for part in _SEPARATOR.split(path) if part]


def shape_text(shape: Iterable[int]) -> str:
    """Write a shape as "3 x 100"."""
    return " x ".join(map(str, shape)) or "of a single number"


def _scalar_text(item: object) -> str:
    if isinstance(item, bytes):
        return item.decode("utf-8", "replace").strip()
    if isinstance(item, str):
        return item.strip()
    if isinstance(item, bool | np.bool_ | int | np.integer):
        return str(int(item))
    if isinstance(item, float | np.floating) and np.isfinite(item):
        return str(int(item)) if float(item).is_integer() else repr(float(item))
    raise InvalidInputError(f"holds {str(item)[:40]!r}; a text or a number is needed")


def _kind(dtype: np.dtype) -> str:
    names = {"O": "objects", "S": "texts", "U": "texts", "V": "structures", "M": "dates", "m": "durations"}
    return names.get(dtype.kind, f"{dtype}")

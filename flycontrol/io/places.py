"""Where numbers and words stand in a file, as a mapping names their places."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from flycontrol.io.quantities import Kind

Orientation = Literal["rows", "columns", "variables"]


@dataclass(frozen=True, slots=True, kw_only=True)
class VariablePlace:
    """A variable by its path, "trial.yaw" or "trial/yaw"; where it has two dimensions, one of its rows or columns."""

    path: str
    row: int | None = None  #: counted from 0
    column: int | None = None

    def __str__(self) -> str:
        part = "" if self.row is None and self.column is None else f", row {self.row}"
        part = part if self.column is None else f", column {self.column}"
        return f"{self.path!r}{part}"


Place = int | str | VariablePlace  #: row or column, counted from 0, or its name; or a variable


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """Value in SI = offset + sign * factor * (number in the file)."""

    key: str  #: its name in the mapping, "left.stroke"
    place: Place
    where: str  #: file and line of the mapping
    kind: Kind
    unit: str = "1"  #: of the numbers in the file
    factor: float = 1.0  #: size of that unit in SI
    sign: int = 1
    offset: float = 0.0  #: [SI unit]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scalar:
    """One number for a whole trial, by its place or as an attribute: value in SI = factor * (number in the file)."""

    key: str
    where: str
    kind: Kind
    unit: str
    factor: float
    place: Place | None = None
    attribute: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Label:
    """A word for a whole trial: by its place, as an attribute, from the file's name or path, or written here."""

    key: str
    where: str
    place: Place | None = None
    attribute: str = ""
    file_name: re.Pattern[str] | None = None  #: its first group, found in the name of the file
    path: re.Pattern[str] | None = None  #: its first group, found in the path of the file, written with /
    text: str = ""

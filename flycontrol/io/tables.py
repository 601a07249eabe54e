"""Text tables of numbers: channels in rows or in columns, separated by white space, commas or tabs."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.formats import TextFormat
from flycontrol.io.places import Orientation
from flycontrol.io.text_files import TextFile, read_text_file

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_LINE_END = re.compile(r"\r\n|\r|\n")
SEPARATORS: dict[TextFormat, str | None] = {"csv": ",", "tsv": "\t", "whitespace": None}


@dataclass(frozen=True, slots=True)
class Line:
    """One line of a table: its number in the file, counting from 1, and its fields."""

    number: int
    fields: list[str]


@dataclass(frozen=True, slots=True, kw_only=True)
class TextTable:
    """Numbers of a text table by channel; NaN where a field is no number, which matters only if the field is mapped."""

    file: TextFile
    orientation: Orientation
    names: tuple[str, ...]  #: of the channels; empty if the file names none
    lines: list[Line]  #: those with numbers
    first_field: int  #: fields before it name the rows
    numbers: FloatArray  #: (channels, samples)

    @property
    def kind(self) -> str:
        """What a channel is here: "row" or "column"."""
        return self.orientation.removesuffix("s")

    def place(self, channel: int, sample: int) -> str:
        """Where a sample stands: "flight.txt, line 3, field 17"."""
        line, field = (channel, sample) if self.orientation == "rows" else (sample, channel)
        return f"{self.file.name}, line {self.lines[line].number}, field {field + self.first_field + 1}"

    def text(self, channel: int, sample: int) -> str:
        """Return the field of a sample as the file writes it."""
        line, field = (channel, sample) if self.orientation == "rows" else (sample, channel)
        return self.lines[line].fields[field + self.first_field]

    def words(self, channel: int) -> list[str]:
        """All fields of a channel, without the white space around them."""
        return [self.text(channel, sample).strip() for sample in range(self.numbers.shape[1])]

    def subset(self, samples: IntArray) -> TextTable:
        """Return the table of some samples; only where channels are columns do the lines say which."""
        if self.orientation == "rows":
            kept = [Line(line.number, _chosen(line.fields, self.first_field, samples)) for line in self.lines]
            return replace(self, lines=kept, numbers=self.numbers[:, samples])
        return replace(self, lines=[self.lines[k] for k in samples], numbers=self.numbers[:, samples])


def read_text_table(
    path: Path, separator: str | None, orientation: Orientation, *, decimal_comma: bool = False
) -> TextTable:
    """Read a table of numbers; a first line (channels in columns) or first field (in rows) without numbers names them.

    Empty lines and lines that begin with # are skipped. Without a separator, white space separates the fields.

    Raises
    ------
    InvalidInputError
        If the file cannot be read, holds no numbers, or its lines differ in length.
    """
    file = read_text_file(path)
    return text_table(file, split_lines(file, separator), orientation, decimal_comma=decimal_comma)


def text_table(
    file: TextFile, lines: list[Line], orientation: Orientation, *, decimal_comma: bool = False
) -> TextTable:
    """Turn split lines into numbers by channel; refused like `read_text_table`."""
    if decimal_comma:
        lines = [Line(line.number, [_with_point(field) for field in line.fields]) for line in lines]
    _refuse_ragged(file, lines)
    names: tuple[str, ...] = ()
    first_field = 0
    if orientation == "columns" and not any(map(is_number, lines[0].fields)):
        names = tuple(field.strip() for field in lines[0].fields)
        lines = lines[1:]
    elif orientation == "rows" and not any(is_number(line.fields[0]) for line in lines):
        names = tuple(line.fields[0].strip() for line in lines)
        first_field = 1
    if not lines or len(lines[0].fields) == first_field:
        raise InvalidInputError(f"{file.name} holds no numbers; a table of numbers is needed.")
    by_line = np.array([_numbers(line.fields[first_field:]) for line in lines], dtype=np.float64)
    return TextTable(
        file=file,
        orientation=orientation,
        names=names,
        lines=lines,
        first_field=first_field,
        numbers=by_line if orientation == "rows" else np.ascontiguousarray(by_line.T),
    )


def split_lines(file: TextFile, separator: str | None) -> list[Line]:
    """Split a file into lines of fields; InvalidInputError if nothing is left."""
    numbered = enumerate(_LINE_END.split(file.text), start=1)
    filled = [(number, text) for number, text in numbered if text.strip() and not text.lstrip().startswith("#")]
    if separator is None:
        lines = [Line(number, text.split()) for number, text in filled]
    else:
        lines = _separated(file, filled, separator)
    if not lines:
        raise InvalidInputError(f"{file.name} holds only comments; a table of numbers is needed.")
    return lines


def is_number(text: str) -> bool:
    """Whether a field reads as a number, NaN and infinity included."""
    return not math.isnan(_number(text)) or text.strip().lower() in {"nan", "-nan", "+nan"}


def _with_point(field: str) -> str:
    """Write a number that has a decimal comma with a point; leave all else as it is, 1.234,5 too, which is refused."""
    pointed = field.replace(",", ".", 1)
    return pointed if "." not in field and is_number(pointed) else field


def _chosen(fields: list[str], first: int, samples: IntArray) -> list[str]:
    return fields[:first] + [fields[first + k] for k in samples]


def _separated(file: TextFile, filled: list[tuple[int, str]], delimiter: str) -> list[Line]:
    try:
        rows = list(csv.reader((text for _, text in filled), delimiter=delimiter))
    except csv.Error as error:
        raise InvalidInputError(f"{file.name} is not a readable table: {error}.") from error
    if len(rows) != len(filled):
        raise InvalidInputError(f"{file.name}: a quoted field runs over several lines; quote no numbers.")
    return [Line(number, row) for (number, _), row in zip(filled, rows, strict=True)]


def _refuse_ragged(file: TextFile, lines: list[Line]) -> None:
    width = len(lines[0].fields)
    for line in lines:
        if len(line.fields) != width:
            raise InvalidInputError(
                f"{file.name}, line {line.number}: {len(line.fields)} fields where line {lines[0].number} has {width}; "
                "every line of a table needs as many; are format, separator and decimal in [file] of the mapping right?"
            )


def _numbers(fields: list[str]) -> list[float]:
    try:
        return [float(field) for field in fields]
    except ValueError:
        return [_number(field) for field in fields]


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan

"""One channel's samples: found in the table by a mapping, checked to be numbers, converted to SI units."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.places import Channel, Place
from flycontrol.io.table_files import Table
from flycontrol.io.tables import TextTable
from flycontrol.io.variable_table import VariableTable

FloatArray = NDArray[np.float64]

_MISSING = {"", "nan", "+nan", "-nan"}  #: what stands where nothing was measured
_LISTED, _LONGEST_NAME = 12, 24  # names in a refusal, and characters of each

LARGEST = 1e30  #: numbers that no file of measurements holds: markers of missing values, and what would overflow


@dataclass(frozen=True, slots=True)
class Samples:
    """A channel in SI units that still knows where each sample stands in the file."""

    table: Table
    channel: Channel
    index: int  #: of the row or column in the table
    values: FloatArray  #: (N,) [SI unit of the channel's kind]

    def refusal(self, sample: int, what: str) -> InvalidInputError:
        """Return an error that names the file, line and field of a sample."""
        end = "" if what.endswith("?") else "."
        return InvalidInputError(f"{self.table.place(self.index, sample)}: {self.channel.key} {what}{end}")


def read_samples(table: Table, channel: Channel, *, missing: bool = False) -> Samples:
    """SI value = offset + sign * factor * number, for every sample of a channel.

    Where samples may be missing, an empty field or NaN becomes NaN.

    Raises
    ------
    InvalidInputError
        If the row, column or variable does not exist, or a sample is no finite number of ordinary size.
    """
    index = index_of(table, channel.place, channel.key, channel.where)
    numbers = table.numbers[index]
    with np.errstate(over="ignore", invalid="ignore"):  # what becomes infinite, or is a NaN that signals, is met below
        values = channel.offset + channel.sign * (channel.factor * numbers)
    samples = Samples(table, channel, index, values)
    for sample in np.flatnonzero(~(np.abs(numbers) < LARGEST)):
        text = table.text(index, int(sample)).strip()
        if not (missing and text.lower() in _MISSING):
            remedy = (
                "mark what is missing with an empty field or nan"
                if missing
                else "cut the recording there or fill the gap"
            )
            raise samples.refusal(int(sample), f'is not a usable number ("{text[:60]}"); {remedy}')
    return samples


def index_of(table: Table, place: Place, key: str, where: str) -> int:
    """Which of a table's channels is at a place; InvalidInputError if it has none there."""
    if isinstance(table, VariableTable):
        return table.index_of(place, key)
    if not isinstance(place, int):
        return _named_index(table, str(place), key, where)
    count = len(table.numbers)
    if place >= count:
        raise InvalidInputError(
            f"{table.file.name} has {count} {table.orientation} (0 to {count - 1}), but {where} maps "
            f"{key} to {table.kind} {place}."
        )
    return place


def _named_index(table: TextTable, name: str, key: str, where: str) -> int:
    found = [index for index, known in enumerate(table.names) if known == name]
    if len(found) == 1:
        return found[0]
    if found:
        fault = f"has {len(found)} {table.orientation} named {name!r}; give the {table.kind}'s number instead"
    elif not table.names:
        fault = f"names no {table.orientation}; give the {table.kind}'s number, counted from 0, instead of {name!r}"
    else:
        near = get_close_matches(name, table.names, n=1)
        known = f"the nearest is {near[0]!r}" if near else f"there are {_listed(table.names)}"
        fault = f"has no {table.kind} named {name!r}; {known}"
    raise InvalidInputError(f"{table.file.name} {fault} ({where}, {key}).")


def _listed(names: tuple[str, ...]) -> str:
    """The first names, cut short: a table without names, split wrongly, passes a whole row of numbers for one."""
    shown = [name if len(name) <= _LONGEST_NAME else f"{name[:_LONGEST_NAME]}..." for name in names[:_LISTED]]
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    unsplit = len(names) == 1 and re.search(r"[;,|\t]", names[0]) is not None
    wrong = unsplit or any(len(name) > _LONGEST_NAME for name in names)
    format_hint = " (is the format in the mapping right?)" if wrong else ""
    return ", ".join(shown) + more + format_hint

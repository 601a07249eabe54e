"""One channel's samples: found in the table by a mapping, checked to be numbers, converted to SI units."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.channels import Channel
from flycontrol.io.tables import TextTable

FloatArray = NDArray[np.float64]

LARGEST = 1e30  #: numbers that no file of measurements holds: markers of missing values, and what would overflow


@dataclass(frozen=True, slots=True)
class Samples:
    """A channel in SI units that still knows where each sample stands in the file."""

    table: TextTable
    channel: Channel
    index: int  #: of the row or column in the table
    values: FloatArray  #: (N,) [SI unit of the channel's kind]

    def refusal(self, sample: int, what: str) -> InvalidInputError:
        """Return an error that names the file, line and field of a sample."""
        return InvalidInputError(f"{self.table.place(self.index, sample)}: {self.channel.key} {what}.")


def read_samples(table: TextTable, channel: Channel) -> Samples:
    """SI value = offset + sign * factor * number, for every sample of a channel.

    Raises
    ------
    InvalidInputError
        If the row or column does not exist, or a sample is no finite number of ordinary size.
    """
    index = _index(table, channel)
    numbers = table.numbers[index]
    samples = Samples(table, channel, index, channel.offset + channel.sign * (channel.factor * numbers))
    bad = np.flatnonzero(~(np.abs(numbers) < LARGEST))
    if bad.size:
        text = table.text(index, int(bad[0]))
        raise samples.refusal(
            int(bad[0]), f'is not a usable number ("{text}"); cut the recording there or fill the gap'
        )
    return samples


def _index(table: TextTable, channel: Channel) -> int:
    if isinstance(channel.place, str):
        return _named_index(table, channel, channel.place)
    count = len(table.numbers)
    if channel.place >= count:
        raise InvalidInputError(
            f"{table.file.name} has {count} {table.orientation} (0 to {count - 1}), but {channel.where} maps "
            f"{channel.key} to {table.kind} {channel.place}."
        )
    return channel.place


def _named_index(table: TextTable, channel: Channel, name: str) -> int:
    found = [index for index, known in enumerate(table.names) if known == name]
    if len(found) == 1:
        return found[0]
    if found:
        fault = f"has {len(found)} {table.orientation} named {name!r}; give the {table.kind}'s number instead"
    elif not table.names:
        fault = f"names no {table.orientation}; give the {table.kind}'s number, counted from 0, instead of {name!r}"
    else:
        near = get_close_matches(name, table.names, n=1)
        known = f"the nearest is {near[0]!r}" if near else f"there are {', '.join(table.names[:12])}"
        fault = f"has no {table.kind} named {name!r}; {known}"
    raise InvalidInputError(f"{table.file.name} {fault} ({channel.where}, {channel.key}).")

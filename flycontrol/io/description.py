"""What a file holds, for a user who has no mapping yet: its channels, a mapping to edit, a shipped one that fits."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.reader import shared_reader
from flycontrol.io.binary.request import Found, Request
from flycontrol.io.formats import (
    TEXT_FORMATS,
    BinaryFile,
    BinaryFormat,
    FileFormat,
    TextFormat,
    binary_file,
    sniffed_format,
)
from flycontrol.io.mapping import known_mapping, shipped_mappings
from flycontrol.io.places import Orientation
from flycontrol.io.recordings import read_recording
from flycontrol.io.tables import SEPARATORS, Line, TextTable, is_number, split_lines, text_table
from flycontrol.io.text_files import TextFile, read_text_file

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelSummary:
    """One row or column of a file, in the file's own numbers."""

    index: int  #: counted from 0
    name: str  #: empty if the file names none
    count: int  #: of samples
    first: str  #: as written
    smallest: float  #: NaN if there are no numbers
    largest: float
    not_numbers: int  #: samples that are no finite numbers
    counts_up: bool  #: by one: frame numbers
    increases_evenly: bool  #: times, perhaps
    shape: str = ""  #: of a variable with rows and columns
    unit: str = ""  #: as the file states it


@dataclass(frozen=True, slots=True, kw_only=True)
class FileSummary:
    """Layout of a file as it looks, and its channels."""

    name: str
    format: FileFormat
    orientation: Orientation
    channels: tuple[ChannelSummary, ...]


def describe_columns(path: Path | str) -> FileSummary:
    """Find out how a file is laid out and what its rows, columns or variables hold.

    Parameters
    ----------
    path
        A text table, whose channels are taken to be rows where there are over three times as many fields as lines; or a
        MATLAB, HDF5, netCDF or Parquet file, known by its first bytes.

    Raises
    ------
    InvalidInputError
        If the file cannot be read, or is no table of numbers.
    """
    form = sniffed_format(Path(path))
    return _described_table(path) if form is None else _described_variables(binary_file(Path(path), form), form)


def _described_table(path: Path | str) -> FileSummary:
    file = read_text_file(Path(path))
    form, lines = _layout(file)
    table = text_table(file, lines, _orientation(lines))
    channels = tuple(_summary(table, index) for index in range(len(table.numbers)))
    return FileSummary(name=file.name, format=form, orientation=table.orientation, channels=channels)


def _described_variables(file: BinaryFile, form: BinaryFormat) -> FileSummary:
    request = Request(path=str(file.path.absolute()), name=file.name, layout=file.layout, form=form, summary=True)
    found = shared_reader().read(request).groups
    channels = tuple(_variable_summary(index, name, values[0]) for index, (name, values) in enumerate(found))
    orientation = "columns" if form == "parquet" else "variables"
    return FileSummary(name=file.name, format=form, orientation=orientation, channels=channels)


def fitting_mappings(path: Path | str) -> tuple[str, ...]:
    """Names of the shipped mappings through which the file reads as a plausible recording."""
    return tuple(name for name in shipped_mappings() if _fits(path, name))


def suggest_mapping(path: Path | str) -> str:
    """Write a mapping in TOML for the user to edit; what the file does not tell is marked ???."""
    summary = describe_columns(path)
    kind = summary.orientation.removesuffix("s")
    lines = [_line(kind, channel) for channel in summary.channels]
    layout = f'format = "{summary.format}"'
    if summary.orientation != "variables":
        layout += f'\nchannels = "{summary.orientation}"'
    if summary.format in TEXT_FORMATS:
        layout += f"\ncount = {len(summary.channels)}"
    counter = next((channel for channel in summary.channels if channel.counts_up), None)
    time = next((channel for channel in summary.channels if channel.increases_evenly and not channel.counts_up), None)
    return _TEMPLATE.format(
        file=_printable(Path(summary.name).name),
        name=json.dumps(Path(summary.name).stem[:100]),
        channels="\n".join(lines),
        layout=layout,
        clock=_clock(kind, counter, time),
        kind=kind,
    )


def _fits(path: Path | str, name: str) -> bool:
    try:
        read_recording(path, known_mapping(name))
    except InvalidInputError:
        return False
    return True


def _layout(file: TextFile) -> tuple[TextFormat, list[Line]]:
    for form in TEXT_FORMATS:
        lines = split_lines(file, SEPARATORS[form])
        widths = {len(line.fields) for line in lines}
        if len(widths) == 1 and widths != {1}:
            return form, lines
    return "whitespace", split_lines(file, None)


def _orientation(lines: list[Line]) -> Orientation:
    if not any(is_number(field) for field in lines[0].fields):
        return "columns"
    return "rows" if len(lines[0].fields) > 3 * len(lines) else "columns"


def _summary(table: TextTable, index: int) -> ChannelSummary:
    name = table.names[index] if table.names else ""
    return _channel_summary(index, name, table.numbers[index], table.text(index, 0))


def _variable_summary(index: int, name: str, found: Found) -> ChannelSummary:
    """Summarise the numbers of a variable, or say why it has none."""
    if found.numbers is None:
        return _channel_summary(index, name, np.empty(0), found.texts[0])
    first = f"{found.numbers[0]:.10g}" if found.numbers.size else "none"
    return replace(_channel_summary(index, name, found.numbers, first), shape=found.texts[0], unit=found.unit)


def _channel_summary(index: int, name: str, samples: FloatArray, first: str) -> ChannelSummary:
    numbers = samples[np.isfinite(samples)]
    with np.errstate(over="ignore", invalid="ignore"):  # infinities are counted among what is no number
        steps = np.diff(samples)
    even = steps.size and bool(np.all(steps > 0) and steps.max() <= 1.02 * steps.min())
    return ChannelSummary(
        index=index,
        name=name,
        count=len(samples),
        first=first,
        smallest=float(numbers.min()) if numbers.size else float("nan"),
        largest=float(numbers.max()) if numbers.size else float("nan"),
        not_numbers=len(samples) - len(numbers),
        counts_up=bool(steps.size and np.all(steps == 1)),
        increases_evenly=bool(even),
    )


def _line(kind: str, channel: ChannelSummary) -> str:
    name = f" {_printable(repr(channel.name))}" if channel.name else ""
    bad = f", {channel.not_numbers} not numbers" if channel.not_numbers else ""
    hint = (
        " (counts up: frames?)"
        if channel.counts_up
        else " (increases evenly: times?)"
        if channel.increases_evenly
        else ""
    )
    if kind == "variable" and not channel.count:
        return f"#   variable{name} {_printable(channel.first)}"
    place = f"variable{name}" if kind == "variable" else f"{kind} {channel.index}{name}"
    shape = f", {channel.shape}" if " x " in channel.shape else ""
    unit = f", in {_printable(channel.unit)}" if channel.unit else ""
    return (
        f"#   {place}: {channel.count} samples{shape}, first {_printable(channel.first)}, "
        f"from {channel.smallest:.6g} to {channel.largest:.6g}{unit}{bad}{hint}"
    )


def _printable(text: str) -> str:
    """Shorten to a line's part that TOML takes in a comment."""
    return (text if text.isprintable() else ascii(text))[:60]


def _clock(kind: str, counter: ChannelSummary | None, time: ChannelSummary | None) -> str:
    if counter is not None:
        return f'frame = {{ {kind} = {_place(kind, counter)} }}\nrate = "??? 1/s" # frames a second'
    if time is not None:
        return f'time = {{ {kind} = {_place(kind, time)}, unit = "{time.unit or "???"}" }}'
    return 'rate = "??? 1/s" # samples a second'


def _place(kind: str, channel: ChannelSummary) -> str:
    return json.dumps(channel.name) if kind == "variable" else str(channel.index)


_TEMPLATE = """\
# A mapping for {file}: replace every ???, uncomment and fill in what the file holds, and save it, say as map.toml.
#
# The file holds (rows and columns count from 0):
{channels}

name = {name}

[file]
{layout}

[clock]
{clock}

# [frames]
# world_z = "???"              # "up" or "down"
# body_axes = "forward right down" # or "forward left up"
# stroke_plane_angle = "??? deg" # the stroke plane is nose down from the body by this angle

# A channel becomes offset + sign * number.
# [yaw]                        # heading, positive to the right
# {kind} = ???
# unit = "deg"
# sign = 1                     # -1 where positive is to the left

# [position]
# {kind}s = [???, ???, ???]
# unit = "mm"

# [quaternion]
# {kind}s = [???, ???, ???, ???]
# order = "scalar last"        # or "scalar first"
# rotation = "body to world"   # or "world to body"

# [velocity]
# {kind}s = [???, ???, ???]
# unit = "mm/s"
# frame = "stroke plane"       # or "body", "world"

# [angular_velocity]           # roll, pitch, yaw rate
# {kind}s = [???, ???, ???]
# unit = "rad/s"
# frame = "stroke plane"

# [left]                       # and [right]
# stroke = {{ {kind} = ???, unit = "deg" }}      # positive forward
# deviation = {{ {kind} = ???, unit = "deg" }}   # positive upward
# pitch = {{ {kind} = ???, unit = "deg" }}       # 90 deg: vertical chord; below it on the forward stroke

# For flycontrol fit:
# [perturbation]               # left out: unknown, to be estimated
# onset = "??? ms"             # or where the file gives it: {{ {kind} = ???, unit = "ms" }}
# duration = "??? ms"
# trace = {{ {kind} = ???, unit = "mA" }} # instead of onset and duration: a coil current or a torque

# [trial]
# fly = {{ file_name = "(fly[0-9]+)" }} # recordings of one fly share this

# [paddling]
# {kind} = ???
# unit = "deg"
# convention = "d_alpha"       # or "right minus left, forward stroke", twice as much
"""

"""Files of any format as tables: one, or one for each trial that is a group of its own."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.reader import BinaryReader
from flycontrol.io.binary.request import Found, Request, Wanted
from flycontrol.io.channels import RecordingMapping
from flycontrol.io.experiment import TraceMapping
from flycontrol.io.formats import BinaryFile, binary_file
from flycontrol.io.places import Channel, Label, Place, Scalar, VariablePlace
from flycontrol.io.quantities import unit_factor
from flycontrol.io.tables import TextTable, read_text_table
from flycontrol.io.variable_table import VariableTable

Table = TextTable | VariableTable

SAME_UNIT = 1e-6  #: relative difference of two factors that are one unit written in two ways


@dataclass(frozen=True, slots=True)
class Contents:
    """What of a file is wanted."""

    channels: tuple[Channel, ...]
    scalars: tuple[Scalar, ...] = ()
    labels: tuple[Label, ...] = ()
    trial: Place | None = None
    groups: tuple[str, ...] = ()


def recording_contents(mapping: RecordingMapping) -> Contents:
    """What a Recording is made of."""
    rate = mapping.clock.rate
    return Contents(tuple(mapping.recording_channels()), (rate,) if isinstance(rate, Scalar) else ())


def trial_contents(mapping: RecordingMapping) -> Contents:
    """What Trials are made of."""
    experiment = mapping.experiment
    return Contents(
        channels=tuple(mapping.trial_channels()),
        scalars=tuple(mapping.scalars()),
        labels=tuple(experiment.labels()),
        trial=experiment.trial,
        groups=experiment.groups,
    )


def read_tables(path: Path, mapping: RecordingMapping, contents: Contents, reader: BinaryReader) -> list[Table]:
    """Read what is wanted of a file.

    Raises
    ------
    InvalidInputError
        If the file cannot be read, is of another format than the mapping says, or lacks what is wanted.
    """
    if mapping.format in ("csv", "tsv", "whitespace"):
        if mapping.orientation == "variables":
            raise InvalidInputError(f"{path}: a text table has rows or columns.")
        table = read_text_table(path, mapping.separator, mapping.orientation, decimal_comma=mapping.decimal_comma)
        _refuse_other_count(table, mapping)
        return [table]
    file = binary_file(path, mapping.format)
    wanted = _wanted(contents)
    request = Request(
        path=str(path.absolute()),
        name=file.name,
        layout=file.layout,
        form=mapping.format,
        wanted=tuple(wanted.values()),
        groups=contents.groups,
    )
    tables: list[Table] = []
    for group, values in reader.read(request).groups:
        found = dict(zip(wanted, values, strict=True))
        tables.append(_variable_table(file, group, mapping, contents, found))
    return tables


def _refuse_other_count(table: TextTable, mapping: RecordingMapping) -> None:
    count = len(table.numbers)
    if mapping.count is not None and count != mapping.count:
        raise InvalidInputError(
            f"{table.file.name} has {count} {table.orientation} where the mapping {mapping.name} expects "
            f"{mapping.count}; another mapping is needed (flycontrol report without --mapping prints one to edit)."
        )


def _wanted(contents: Contents) -> dict[tuple[str, Place | str], Wanted]:
    """What to ask of a file, by what it is and its place."""
    wanted: dict[tuple[str, Place | str], Wanted] = {}
    for item in (*contents.channels, *contents.scalars):
        if item.place is not None:
            wanted["numbers", item.place] = _of_place(item.place, item.key, item.where)
    words = [(label.place, label.key, label.where) for label in contents.labels]
    for place, key, where in [*words, (contents.trial, "trial", "")]:
        if place is not None:
            wanted["texts", place] = _of_place(place, key, where, texts=True)
    for item in (*contents.scalars, *contents.labels):
        if item.attribute:
            wanted["attribute", item.attribute] = Wanted(
                path=item.attribute, what="attribute", key=item.key, where=item.where
            )
    return wanted


def _of_place(place: Place, key: str, where: str, *, texts: bool = False) -> Wanted:
    what = "texts" if texts else "numbers"
    if isinstance(place, VariablePlace):
        return Wanted(path=place.path, row=place.row, column=place.column, what=what, key=key, where=where)
    return Wanted(path=str(place), what=what, key=key, where=where)


def _variable_table(
    file: BinaryFile,
    group: str,
    mapping: RecordingMapping,
    contents: Contents,
    found: dict[tuple[str, Place | str], Found],
) -> VariableTable:
    numbers = [(place, values) for (what, place), values in found.items() if what == "numbers"]
    table = VariableTable(
        file=file,
        orientation=mapping.orientation,
        group=group,
        places={place: index for index, (place, _) in enumerate(numbers)},
        numbers=tuple(values.numbers for _, values in numbers if values.numbers is not None),
        texts={place: values.texts for (what, place), values in found.items() if what == "texts"},
        attributes={str(name): _attribute(values) for (what, name), values in found.items() if what == "attribute"},
    )
    for item in (*contents.channels, *contents.scalars):
        if item.place is not None:
            _refuse_other_unit(file.name, item, found["numbers", item.place].unit)
    _refuse_other_lengths(table, _on_the_trial_s_clock(contents, mapping))
    return table


def _attribute(found: Found) -> float | str:
    return float(found.numbers[0]) if found.numbers is not None else found.texts[0]


def _on_the_trial_s_clock(contents: Contents, mapping: RecordingMapping) -> Iterable[Channel]:
    perturbation = mapping.experiment.perturbation
    apart: tuple[Channel | None, ...] = ()
    if isinstance(perturbation, TraceMapping) and perturbation.time is not None:
        apart = (perturbation.drive, perturbation.time)
    return [channel for channel in contents.channels if channel not in apart]


def _refuse_other_lengths(table: VariableTable, channels: Iterable[Channel]) -> None:
    first: tuple[Channel, int] | None = None
    for channel in channels:
        length = len(table.numbers[table.index_of(channel.place, channel.key)])
        if first is not None and length != first[1]:
            inside = f", {table.group}" if table.group else ""
            raise InvalidInputError(
                f"{table.file.name}{inside}: {channel.key} has {length} samples where {first[0].key} has {first[1]}; "
                f"channels of one trial need as many ({channel.where})."
            )
        first = first or (channel, length)


def _refuse_other_unit(name: str, item: Channel | Scalar, stated: str) -> None:
    """Refuse a unit in the mapping that the file itself contradicts; a unit that is not known here is left alone."""
    if not stated or item.unit == "1":
        return
    try:
        factor = unit_factor(stated, item.kind, key="unit")
    except InvalidInputError:
        return
    if abs(factor - item.factor) > SAME_UNIT * abs(factor):
        raise InvalidInputError(
            f"{name} says that {item.key} is in '{stated}', but the mapping says '{item.unit}' ({item.where})."
        )

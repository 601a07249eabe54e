"""Turns the tables of a mapping file into channels, scalars and labels in SI units."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, cast

from flycontrol.errors import InvalidInputError
from flycontrol.io.channels import Clock, QuaternionChannels, VectorChannels, WingChannels
from flycontrol.io.mapping_file import (
    ChannelTable,
    ClockTable,
    LabelTable,
    PlacesTable,
    PlaceTable,
    PositionTable,
    QuaternionTable,
    ScalarTable,
    VectorTable,
    WingTable,
)
from flycontrol.io.places import Channel, Label, Orientation, Place, Scalar, VariablePlace
from flycontrol.io.quantities import ANGLE, FREQUENCY, NUMBER, TIME, Kind, read_quantity, unit_factor
from flycontrol.io.toml_files import TomlFile, structured

_SCALAR_FIRST = {"scalar first": (0, 1, 2, 3), "scalar last": (3, 0, 1, 2)}


@dataclass(frozen=True, slots=True)
class ChannelReader:
    """Reads the tables of one mapping file; InvalidInputError with file and line for what contradicts its layout."""

    toml: TomlFile
    orientation: Orientation
    has_attributes: bool

    def clock(self, clock: ClockTable) -> Clock:
        """Read the clock."""
        return Clock(
            time=self.channel(clock.time, TIME, "clock.time"),
            frame=self._counter(clock.frame),
            rate=self.scalar(clock.rate, FREQUENCY, "clock.rate"),
            start=self.optional_quantity(clock.start, TIME, "clock.start") or 0.0,
            wingbeat_frequency=self.optional_quantity(clock.wingbeat_frequency, FREQUENCY, "clock.wingbeat_frequency"),
        )

    def channel(self, table: ChannelTable | None, kind: Kind, key: str) -> Channel | None:
        """Read one channel, if it is mapped."""
        return None if table is None else self._channel(table, kind, key)

    def wing(self, table: WingTable | None, side: str) -> WingChannels | None:
        """Read the angles of one wing."""
        if table is None:
            return None
        return WingChannels(
            stroke=self._channel(table.stroke, ANGLE, f"{side}.stroke"),
            deviation=self._channel(table.deviation, ANGLE, f"{side}.deviation"),
            pitch=self._channel(table.pitch, ANGLE, f"{side}.pitch"),
        )

    def vector(self, table: PositionTable | None, kind: Kind, key: str) -> tuple[Channel, ...] | None:
        """Read the components of a vector along x, y, z."""
        if table is None:
            return None
        if len(table.signs) != 3:
            raise self.refusal(f"{key}.signs", f"has {len(table.signs)} values; three are needed, for x, y, z")
        where = self.toml.where(key, "unit")
        factor = unit_factor(table.unit, kind, key=f"{key}.unit", where=where)
        return tuple(
            Channel(key=f"{key}.{axis}", place=place, where=where, kind=kind, unit=table.unit, factor=factor, sign=sign)
            for axis, place, sign in zip("xyz", self._places(table, key, 3), table.signs, strict=True)
        )

    def framed_vector(self, table: VectorTable | None, kind: Kind, key: str) -> VectorChannels | None:
        """Read the components of a vector in a frame."""
        channels = self.vector(table, kind, key)
        return None if table is None or channels is None else VectorChannels(channels=channels, frame=table.frame)

    def quaternion(self, table: QuaternionTable | None) -> QuaternionChannels | None:
        """Read the components w, x, y, z."""
        if table is None:
            return None
        places = self._places(table, "quaternion", 4)
        where = self.toml.where("quaternion")
        channels = tuple(
            Channel(key=f"quaternion.{part}", place=places[index], where=where, kind=NUMBER)
            for part, index in zip("wxyz", _SCALAR_FIRST[table.order], strict=True)
        )
        return QuaternionChannels(channels=channels, rotation=table.rotation)

    def optional_quantity(self, entry: object, kind: Kind, key: str) -> float | None:
        """Read a quantity that may be left out [SI unit of its kind]."""
        return None if entry is None else read_quantity(entry, kind, key=key, where=self.where(key)).value

    def scalar(self, entry: object, kind: Kind, key: str) -> float | Scalar | None:
        """Read a quantity, or where a file gives it."""
        if not isinstance(entry, dict):
            return self.optional_quantity(entry, kind, key)
        table = structured(ScalarTable, cast("dict[str, Any]", entry), self.toml, key)
        self._refuse_attribute(table.attribute, key)
        return Scalar(
            key=key,
            where=self.where(key),
            kind=kind,
            unit=table.unit,
            factor=unit_factor(table.unit, kind, key=f"{key}.unit", where=self.where(key)),
            place=None if table.attribute else self.place(table, key),
            attribute=table.attribute or "",
        )

    def label(self, entry: object, key: str) -> Label | None:
        """Read a word, or where it is found."""
        if entry is None:
            return None
        if isinstance(entry, str) and entry.strip():
            return Label(key=key, where=self.where(key), text=entry.strip())
        if not isinstance(entry, dict):
            raise self.refusal(key, f"is {entry!r}; a text or a table such as {{ column = 'fly' }} is needed")
        table = structured(LabelTable, cast("dict[str, Any]", entry), self.toml, key)
        self._refuse_attribute(table.attribute, key)
        has_place = not (table.attribute or table.file_name or table.path)
        if not has_place and [table.attribute, table.file_name, table.path].count(None) != 2:
            raise self.refusal(key, "names several places; one of attribute, file_name and path is needed")
        return Label(
            key=key,
            where=self.where(key),
            place=self.place(table, key) if has_place else None,
            attribute=table.attribute or "",
            file_name=self._pattern(table.file_name, f"{key}.file_name"),
            path=self._pattern(table.path, f"{key}.path"),
        )

    def place(self, table: PlaceTable, key: str) -> Place:
        """Read where a channel is."""
        if self.orientation == "variables":
            return self._variable(table, key)
        wanted, other = (table.row, table.column) if self.orientation == "rows" else (table.column, table.row)
        kind = self.orientation.removesuffix("s")
        if wanted is None or other is not None or table.variable is not None:
            raise self.refusal(
                key, f"must name its {kind} and nothing else, since file.channels = '{self.orientation}'"
            )
        return wanted

    def where(self, key: str) -> str:
        """Name the file and the line of a key."""
        return self.toml.where(*key.split("."))

    def refusal(self, key: str, what: str) -> InvalidInputError:
        """Return an error that names the file and the line of a key."""
        return InvalidInputError(f"{self.where(key)}: {key} {what}.")

    def _channel(self, table: ChannelTable, kind: Kind, key: str) -> Channel:
        where = self.where(key)
        return Channel(
            key=key,
            place=self.place(table, key),
            where=where,
            kind=kind,
            unit=table.unit,
            factor=unit_factor(table.unit, kind, key=f"{key}.unit", where=where),
            sign=table.sign,
            offset=self.optional_quantity(table.offset, kind, f"{key}.offset") or 0.0,
        )

    def _counter(self, table: PlaceTable | None) -> Channel | None:
        if table is None:
            return None
        place = self.place(table, "clock.frame")
        return Channel(key="clock.frame", place=place, where=self.where("clock.frame"), kind=NUMBER)

    def _variable(self, table: PlaceTable, key: str) -> VariablePlace:
        row, column = table.row, table.column
        if table.variable is None:
            raise self.refusal(key, "must name its variable, such as variable = 'trial.yaw'")
        if (row is not None and column is not None) or isinstance(row, str) or isinstance(column, str):
            raise self.refusal(key, "may name one row or one column of its variable, by its number from 0")
        return VariablePlace(path=table.variable, row=row, column=column)

    def _places(self, table: PlacesTable, key: str, count: int) -> list[Place]:
        if self.orientation == "variables":
            return self._variables(table, key, count)
        wanted, other = (table.rows, table.columns) if self.orientation == "rows" else (table.columns, table.rows)
        if wanted is None or other or table.variable or table.variables or len(wanted) != count:
            raise self.refusal(
                key,
                f"must list {count} {self.orientation} and nothing else, since file.channels = '{self.orientation}'",
            )
        return list(wanted)

    def _variables(self, table: PlacesTable, key: str, count: int) -> list[Place]:
        lists = [given for given in (table.variables, table.rows, table.columns) if given is not None]
        if len(lists) != 1 or len(lists[0]) != count or (table.variables is None) != (table.variable is not None):
            raise self.refusal(
                key, f"must list {count} variables, or name one variable and {count} of its columns or rows"
            )
        if table.variables is not None:
            return [VariablePlace(path=path) for path in table.variables]
        rows, columns = table.rows or [None] * count, table.columns or [None] * count
        return [
            self._variable(PlaceTable(variable=table.variable, row=row, column=column), key)
            for row, column in zip(rows, columns, strict=True)
        ]

    def _refuse_attribute(self, attribute: str | None, key: str) -> None:
        if attribute is not None and not self.has_attributes:
            raise self.refusal(key, "names an attribute, but files of this format have none")

    def _pattern(self, written: str | None, key: str) -> re.Pattern[str] | None:
        if written is None:
            return None
        try:
            pattern = re.compile(written)
        except (re.error, RecursionError, OverflowError) as error:
            raise self.refusal(key, f"is {written!r}, not a regular expression ({error})") from error
        if pattern.groups < 1:
            raise self.refusal(key, f"is {written!r}; what is meant must be in brackets, as in '(fly[0-9]+)_'")
        return pattern

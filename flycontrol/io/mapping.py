"""Mapping files: TOML that says which row or column holds which channel of a recording, in which unit and frame."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from flycontrol.errors import FlycontrolError, InvalidInputError
from flycontrol.io.channels import (
    Channel,
    Clock,
    QuaternionChannels,
    RecordingMapping,
    VectorChannels,
    WingChannels,
)
from flycontrol.io.mapping_file import (
    ChannelTable,
    MappingFile,
    PlacesTable,
    PlaceTable,
    PositionTable,
    QuaternionTable,
    VectorTable,
    WingTable,
)
from flycontrol.io.quantities import (
    ANGLE,
    ANGULAR_VELOCITY,
    FREQUENCY,
    LENGTH,
    NUMBER,
    TIME,
    VELOCITY,
    Kind,
    read_quantity,
    unit_factor,
)
from flycontrol.io.tables import Orientation
from flycontrol.io.text_files import text_file
from flycontrol.io.toml_files import TomlFile, parse_toml, read_toml_file, structured
from flycontrol.model.references import cite

_SHIPPED = files("flycontrol.io").joinpath("mappings")
_SCALAR_FIRST = {"scalar first": (0, 1, 2, 3), "scalar last": (3, 0, 1, 2)}


def shipped_mappings() -> tuple[str, ...]:
    """Names of the mappings that the package ships."""
    return tuple(sorted(path.name.removesuffix(".toml") for path in _SHIPPED.iterdir() if path.name.endswith(".toml")))


def mapping_text(name: str) -> str:
    """Text of a shipped mapping; refused like `known_mapping`."""
    return _shipped(name).file.text


def known_mapping(name: str) -> RecordingMapping:
    """Read a shipped mapping by its name; InvalidInputError if there is none of that name."""
    return _resolved(_shipped(name))


def read_mapping(path: Path | str) -> RecordingMapping:
    """Read a mapping from a TOML file, or a shipped one by its name.

    Raises
    ------
    InvalidInputError
        If a key is unknown, missing, of a wrong unit, or contradicts another.
    """
    if str(path) in shipped_mappings() and not Path(path).exists():
        return known_mapping(str(path))
    return _resolved(read_toml_file(Path(path)))


def _shipped(name: str) -> TomlFile:
    if name not in shipped_mappings():
        raise InvalidInputError(f"No mapping {name!r} is shipped; there are {', '.join(shipped_mappings())}.")
    return parse_toml(text_file(f"{name}.toml", _SHIPPED.joinpath(f"{name}.toml").read_bytes()))


def _resolved(toml: TomlFile) -> RecordingMapping:
    tables = structured(MappingFile, toml.data, toml)
    read = _ChannelReader(toml, tables.file.channels)
    mapping = RecordingMapping(
        name=tables.name,
        format=tables.file.format,
        orientation=tables.file.channels,
        count=tables.file.count,
        clock=read.clock(tables),
        world_z=tables.frames.world_z,
        body_axes=tables.frames.body_axes,
        stroke_plane_angle=read.optional_quantity(tables.frames.stroke_plane_angle, ANGLE, "frames.stroke_plane_angle"),
        yaw=read.channel(tables.yaw, ANGLE, "yaw"),
        position=read.vector(tables.position, LENGTH, "position"),
        quaternion=read.quaternion(tables.quaternion),
        velocity=read.framed_vector(tables.velocity, VELOCITY, "velocity"),
        angular_velocity=read.framed_vector(tables.angular_velocity, ANGULAR_VELOCITY, "angular_velocity"),
        left=read.wing(tables.left, "left"),
        right=read.wing(tables.right, "right"),
        notes=_notes(tables, toml),
        sha256=toml.file.sha256,
    )
    _refuse_contradictions(mapping, toml)
    return mapping


def _notes(tables: MappingFile, toml: TomlFile) -> dict[str, str]:
    head = {"mapping": tables.name, "description": tables.description, "source": tables.source}
    if tables.source:
        try:
            cite(tables.source)
        except FlycontrolError as error:
            raise InvalidInputError(f"{toml.where('source')}: {error}") from error
    return {key: text for key, text in head.items() if text} | tables.notes


@dataclass(frozen=True, slots=True)
class _ChannelReader:
    """Turns the tables of one mapping file into channels in SI units."""

    toml: TomlFile
    orientation: Orientation

    def clock(self, tables: MappingFile) -> Clock:
        clock = tables.clock
        return Clock(
            time=self.channel(clock.time, TIME, "clock.time"),
            frame=self._counter(clock.frame),
            rate=self.optional_quantity(clock.rate, FREQUENCY, "clock.rate"),
            wingbeat_frequency=self.optional_quantity(clock.wingbeat_frequency, FREQUENCY, "clock.wingbeat_frequency"),
        )

    def channel(self, table: ChannelTable | None, kind: Kind, key: str) -> Channel | None:
        return None if table is None else self._channel(table, kind, key)

    def wing(self, table: WingTable | None, side: str) -> WingChannels | None:
        if table is None:
            return None
        return WingChannels(
            stroke=self._channel(table.stroke, ANGLE, f"{side}.stroke"),
            deviation=self._channel(table.deviation, ANGLE, f"{side}.deviation"),
            pitch=self._channel(table.pitch, ANGLE, f"{side}.pitch"),
        )

    def vector(self, table: PositionTable | None, kind: Kind, key: str) -> tuple[Channel, ...] | None:
        if table is None:
            return None
        if len(table.signs) != 3:
            raise self._refusal(f"{key}.signs", f"has {len(table.signs)} values; three are needed, for x, y, z")
        where = self.toml.where(key, "unit")
        factor = unit_factor(table.unit, kind, key=f"{key}.unit", where=where)
        return tuple(
            Channel(key=f"{key}.{axis}", place=place, where=where, kind=kind, unit=table.unit, factor=factor, sign=sign)
            for axis, place, sign in zip("xyz", self._places(table, key, 3), table.signs, strict=True)
        )

    def framed_vector(self, table: VectorTable | None, kind: Kind, key: str) -> VectorChannels | None:
        channels = self.vector(table, kind, key)
        return None if table is None or channels is None else VectorChannels(channels=channels, frame=table.frame)

    def quaternion(self, table: QuaternionTable | None) -> QuaternionChannels | None:
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
        if entry is None:
            return None
        return read_quantity(entry, kind, key=key, where=self.toml.where(*key.split("."))).value

    def _channel(self, table: ChannelTable, kind: Kind, key: str) -> Channel:
        where = self.toml.where(*key.split("."))
        return Channel(
            key=key,
            place=self._place(table, key),
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
        where = self.toml.where("clock", "frame")
        return Channel(key="clock.frame", place=self._place(table, "clock.frame"), where=where, kind=NUMBER)

    def _place(self, table: PlaceTable, key: str) -> int | str:
        wanted, other = (table.row, table.column) if self.orientation == "rows" else (table.column, table.row)
        kind = self.orientation.removesuffix("s")
        if wanted is None or other is not None:
            raise self._refusal(
                key, f"must name its {kind} and nothing else, since file.channels = '{self.orientation}'"
            )
        return wanted

    def _places(self, table: PlacesTable, key: str, count: int) -> list[int | str]:
        wanted, other = (table.rows, table.columns) if self.orientation == "rows" else (table.columns, table.rows)
        if wanted is None or other is not None or len(wanted) != count:
            raise self._refusal(
                key,
                f"must list {count} {self.orientation} and nothing else, since file.channels = '{self.orientation}'",
            )
        return wanted

    def _refusal(self, key: str, what: str) -> InvalidInputError:
        return InvalidInputError(f"{self.toml.where(*key.split('.'))}: {key} {what}.")


def _refuse_contradictions(mapping: RecordingMapping, toml: TomlFile) -> None:
    faults = {
        "clock": _clock_fault(mapping.clock),
        "frames": _frames_fault(mapping),
        "velocity": _frame_fault(mapping, mapping.velocity),
        "angular_velocity": _frame_fault(mapping, mapping.angular_velocity),
        "file": _count_fault(mapping),
        "name": _channels_fault(mapping),
    }
    for key, fault in faults.items():
        if fault:
            raise InvalidInputError(f"{toml.where(key)}: {fault}.")


def _clock_fault(clock: Clock) -> str:
    if clock.time is not None and (clock.rate is not None or clock.frame is not None):
        return "clock.time contradicts clock.rate and clock.frame; keep the times, or the frames and their rate"
    if clock.time is None and clock.rate is None:
        return 'the clock needs a rate, such as rate = "7500 1/s", or a channel of times'
    return ""


def _frames_fault(mapping: RecordingMapping) -> str:
    if (mapping.position or mapping.quaternion) and mapping.world_z is None:
        return 'frames.world_z is missing: say whether z of the world points "up" or "down"'
    return ""


def _frame_fault(mapping: RecordingMapping, vector: VectorChannels | None) -> str:
    if vector is None or vector.frame == "stroke plane":
        return ""
    if mapping.stroke_plane_angle is None:
        return f"a vector in the {vector.frame} frame needs frames.stroke_plane_angle"
    if vector.frame == "world" and mapping.quaternion is None:
        return "a vector in the world frame needs the quaternion"
    return ""


def _count_fault(mapping: RecordingMapping) -> str:
    places = [channel.place for channel in mapping.channels() if isinstance(channel.place, int)]
    if mapping.count is not None and places and max(places) >= mapping.count:
        return f"{mapping.orientation.removesuffix('s')} {max(places)} is beyond file.count = {mapping.count} (from 0)"
    return ""


def _channels_fault(mapping: RecordingMapping) -> str:
    mapped: dict[int | str, str] = {}
    for channel in mapping.channels():
        if channel.place in mapped:
            kind = mapping.orientation.removesuffix("s")
            return f"{kind} {channel.place!r} is mapped both to {mapped[channel.place]} and to {channel.key}"
        mapped[channel.place] = channel.key
    if set(mapped.values()) <= {"clock.time", "clock.frame"}:
        return "the mapping has a clock and nothing else; map at least one channel"
    return ""

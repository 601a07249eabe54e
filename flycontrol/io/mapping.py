"""Mapping files: TOML that says which row or column holds which channel of a recording, in which unit and frame."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from flycontrol.errors import FlycontrolError, InvalidInputError
from flycontrol.io.channel_reader import ChannelReader
from flycontrol.io.channels import Clock, RecordingMapping, VectorChannels
from flycontrol.io.experiment_tables import read_experiment
from flycontrol.io.formats import TEXT_FORMATS
from flycontrol.io.mapping_file import FileTable, MappingFile
from flycontrol.io.places import Orientation, VariablePlace
from flycontrol.io.quantities import ANGLE, ANGULAR_VELOCITY, LENGTH, VELOCITY
from flycontrol.io.text_files import text_file
from flycontrol.io.toml_files import TomlFile, parse_toml, read_toml_file, structured
from flycontrol.model.references import cite

_SHIPPED = files("flycontrol.io").joinpath("mappings")
_WITH_ATTRIBUTES = ("hdf5", "netcdf", "parquet")


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
    if Path(path).name == str(path) and not Path(path).exists():
        raise InvalidInputError(
            f"{path}: there is no such file, and no mapping of that name is shipped; shipped are "
            f"{', '.join(shipped_mappings())}."
        )
    return _resolved(read_toml_file(Path(path)))


def _shipped(name: str) -> TomlFile:
    if name not in shipped_mappings():
        raise InvalidInputError(f"No mapping {name!r} is shipped; there are {', '.join(shipped_mappings())}.")
    return parse_toml(text_file(f"{name}.toml", _SHIPPED.joinpath(f"{name}.toml").read_bytes()))


def _resolved(toml: TomlFile) -> RecordingMapping:
    tables = structured(MappingFile, toml.data, toml)
    if tables.empty:
        raise InvalidInputError(f"{toml.where('empty')}: the file that this maps holds no motion. {tables.empty}")
    orientation = _orientation(tables.file, toml)
    read = ChannelReader(toml, orientation, tables.file.format in _WITH_ATTRIBUTES)
    mapping = RecordingMapping(
        name=tables.name,
        format=tables.file.format,
        orientation=orientation,
        separator=_separator(tables.file, toml),
        decimal_comma=tables.file.decimal == ",",
        count=tables.file.count,
        clock=read.clock(tables.clock),
        world_z=tables.frames.world_z,
        body_axes=tables.frames.body_axes,
        stroke_plane_angle=read.optional_quantity(tables.frames.stroke_plane_angle, ANGLE, "frames.stroke_plane_angle"),
        yaw=read.channel(tables.yaw, ANGLE, "yaw"),
        yaw_is_unwrapped=tables.yaw is not None and tables.yaw.unwrapped,
        position=read.vector(tables.position, LENGTH, "position"),
        quaternion=read.quaternion(tables.quaternion),
        velocity=read.framed_vector(tables.velocity, VELOCITY, "velocity"),
        angular_velocity=read.framed_vector(tables.angular_velocity, ANGULAR_VELOCITY, "angular_velocity"),
        left=read.wing(tables.left, "left"),
        right=read.wing(tables.right, "right"),
        experiment=read_experiment(tables, read),
        notes=_notes(tables, toml),
        sha256=toml.file.sha256,
    )
    _refuse_contradictions(mapping, toml)
    return mapping


def _orientation(file: FileTable, toml: TomlFile) -> Orientation:
    """Tables of text have rows or columns, those of Parquet columns; all else has variables."""
    where = toml.where("file", "channels")
    if file.format in TEXT_FORMATS:
        if file.channels is None:
            raise InvalidInputError(f"{where}: file.channels is missing; say whether they are 'rows' or 'columns'.")
        return file.channels
    if file.format == "parquet":
        if file.channels == "rows":
            raise InvalidInputError(f"{where}: file.channels is 'rows', but a Parquet file's channels are columns.")
        return "columns"
    if file.channels is not None or file.count is not None:
        raise InvalidInputError(
            f"{where}: the channels of a {file.format} file are variables, which have names; leave out file.channels "
            "and file.count."
        )
    return "variables"


def _separator(file: FileTable, toml: TomlFile) -> str | None:
    """What separates the fields of a line; None: white space, or there are no lines."""
    if (file.separator is not None or file.decimal == ",") and file.format not in TEXT_FORMATS:
        raise InvalidInputError(
            f"{toml.where('file')}: a {file.format} file has neither separators nor decimal commas; leave out "
            "file.separator and file.decimal."
        )
    if file.separator is not None and file.format != "csv":
        raise InvalidInputError(f"{toml.where('file', 'separator')}: file.separator is for csv, not {file.format}.")
    separator = file.separator or {"csv": ",", "tsv": "\t"}.get(file.format)
    if separator == "," and file.decimal == ",":
        raise InvalidInputError(
            f"{toml.where('file', 'decimal')}: commas cannot both separate the fields and mark the decimals; "
            "say file.separator = ';' if that is what the file has."
        )
    return separator


def _notes(tables: MappingFile, toml: TomlFile) -> dict[str, str]:
    head = {"mapping": tables.name, "description": tables.description, "source": tables.source}
    if tables.source:
        try:
            cite(tables.source)
        except FlycontrolError as error:
            raise InvalidInputError(f"{toml.where('source')}: {error}") from error
    return {key: text for key, text in head.items() if text} | tables.notes


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
    if clock.time is not None and clock.start:
        return "clock.start contradicts clock.time; give the times an offset instead"
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
    mapped: dict[int | str | VariablePlace, str] = {}
    for channel in (*mapping.channels(), *mapping.scalars()):
        again = f"{channel.key.removeprefix('paddling.')}.pitch"  # [paddling] may share the pitches of both wings
        if channel.place in mapped and mapped[channel.place] != again:
            kind = mapping.orientation.removesuffix("s")
            place = channel.place if isinstance(channel.place, VariablePlace) else repr(channel.place)
            return f"{kind} {place} is mapped both to {mapped[channel.place]} and to {channel.key}"
        if channel.place is not None:
            mapped[channel.place] = channel.key
    if set(mapped.values()) <= {"clock.time", "clock.frame", "clock.rate"}:
        return "the mapping has a clock and nothing else; map at least one channel"
    return ""

"""The tables and keys of a mapping file, as TOML holds them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator
from pydantic_core import PydanticCustomError

from flycontrol.io.toml_files import Table


def _place(written: object) -> int | str:
    if (isinstance(written, str) and written) or (type(written) is int and written >= 0):
        return written
    raise PydanticCustomError("place", "a number counted from 0, or a name, is needed")


Place = Annotated[int | str, PlainValidator(_place)]
Sign = Literal[1, -1]


class FileTable(Table):
    """How the file is laid out."""

    format: Literal["whitespace", "csv", "tsv"]
    channels: Literal["rows", "columns"]
    count: Annotated[int, Field(gt=0)] | None = None  #: of channels in the file; another count is refused


class PlaceTable(Table):
    """Where one channel is: a row or a column, by its number from 0 or by its name."""

    row: Place | None = None
    column: Place | None = None


class ChannelTable(PlaceTable):
    """One channel: value in SI = offset + sign * (number in the file, in `unit`)."""

    unit: str
    sign: Sign = 1
    offset: Any = None  #: a quantity such as "90 deg"


class ClockTable(Table):
    """The clock: frame numbers and their rate, a rate alone, or a channel of times."""

    frame: PlaceTable | None = None
    rate: Any = None  #: a quantity such as "7500 1/s"
    time: ChannelTable | None = None
    wingbeat_frequency: Any = None  #: what to expect, where no wing is mapped to measure it


class FramesTable(Table):
    """Which way the axes of the file's frames point."""

    world_z: Literal["up", "down"] | None = None
    body_axes: Literal["forward right down", "forward left up"] = "forward right down"
    stroke_plane_angle: Any = None  #: nose down from the body, a quantity such as "55 deg"


class PlacesTable(Table):
    """Where the components of a vector or a quaternion are."""

    rows: list[Place] | None = None
    columns: list[Place] | None = None


class PositionTable(PlacesTable):
    """x, y, z in the world frame."""

    unit: str
    signs: list[Sign] = Field(default=[1, 1, 1])


class VectorTable(PositionTable):
    """x, y, z in a frame of the fly or of the world."""

    frame: Literal["stroke plane", "body", "world"]


class QuaternionTable(PlacesTable):
    """Attitude of the body."""

    order: Literal["scalar first", "scalar last"]
    rotation: Literal["body to world", "world to body"]


class WingTable(Table):
    """The three angles of one wing."""

    stroke: ChannelTable
    deviation: ChannelTable
    pitch: ChannelTable


class MappingFile(Table):
    """A complete mapping file."""

    name: str = Field(min_length=1, max_length=100)
    description: str = ""
    source: str = ""
    file: FileTable
    clock: ClockTable
    frames: FramesTable = FramesTable()
    yaw: ChannelTable | None = None
    position: PositionTable | None = None
    quaternion: QuaternionTable | None = None
    velocity: VectorTable | None = None
    angular_velocity: VectorTable | None = None
    left: WingTable | None = None
    right: WingTable | None = None
    notes: dict[str, str] = Field(default={})

"""The tables and keys of a mapping file, as TOML holds them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator
from pydantic_core import PydanticCustomError

from flycontrol.io.experiment import Convention
from flycontrol.io.formats import FileFormat
from flycontrol.io.toml_files import Table


def _place(written: object) -> int | str:
    if (isinstance(written, str) and written) or (type(written) is int and written >= 0):
        return written
    raise PydanticCustomError("place", "a number counted from 0, or a name, is needed")


Place = Annotated[int | str, PlainValidator(_place)]
Sign = Literal[1, -1]


class FileTable(Table):
    """How the file is laid out."""

    format: FileFormat
    channels: Literal["rows", "columns"] | None = None  #: of a table; the variables of other files have names
    count: Annotated[int, Field(gt=0)] | None = None  #: of channels in the file; another count is refused
    separator: Literal[",", ";", "|"] | None = None  #: of a csv file's fields, a comma unless it is said
    decimal: Literal[".", ","] = "."


class PlaceTable(Table):
    """Where one channel is: a row or a column of a table, or a variable, or a row or a column of a variable."""

    variable: str | None = Field(default=None, min_length=1, max_length=200)
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
    rate: Any = None  #: a quantity such as "7500 1/s", or a table that says where a file gives it
    start: Any = None  #: time of frame 0 or of the first sample, a quantity such as "-50 ms"
    time: ChannelTable | None = None
    wingbeat_frequency: Any = None  #: what to expect, where no wing is mapped to measure it


class FramesTable(Table):
    """Which way the axes of the file's frames point."""

    world_z: Literal["up", "down"] | None = None
    body_axes: Literal["forward right down", "forward left up"] = "forward right down"
    stroke_plane_angle: Any = None  #: nose down from the body, a quantity such as "55 deg"


class PlacesTable(Table):
    """Where the components of a vector or a quaternion are."""

    variable: str | None = Field(default=None, min_length=1, max_length=200)
    variables: list[Annotated[str, Field(min_length=1, max_length=200)]] | None = None
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


class YawTable(ChannelTable):
    """The heading."""

    unwrapped: bool = False  #: has no jumps of a full turn, not even across gaps


class ScalarTable(PlaceTable):
    """One number for a whole trial: a variable or column that holds it, or an attribute of the group or file."""

    attribute: str | None = Field(default=None, min_length=1, max_length=200)
    unit: str


class LabelTable(PlaceTable):
    """One word for a whole trial, found in a variable or column, an attribute, the file's name, or its path."""

    attribute: str | None = Field(default=None, min_length=1, max_length=200)
    file_name: str | None = Field(default=None, min_length=1, max_length=200)
    path: str | None = Field(default=None, min_length=1, max_length=200)


class TrialTable(PlaceTable):
    """How the trials of an experiment are told apart; the place is that of a column that names each row's trial."""

    groups: Any = None  #: a name, a pattern such as "trial_*", or a list of them
    name: Any = None  #: a table as of LabelTable
    fly: Any = None  #: a text, or a table as of LabelTable
    gaps: Literal["refuse", "cut"] = "refuse"


class PerturbationTable(Table):
    """What perturbed the fly."""

    kind: Literal["pulse", "trace", "unknown"] | None = None
    onset: Any = None  #: a quantity such as "20 ms", or a table as of ScalarTable
    duration: Any = None
    angular_impulse: Any = None
    trace: ChannelTable | None = None
    time: ChannelTable | None = None  #: the trace's own clock
    angular_acceleration_per_unit: Any = None
    torque_per_unit: Any = None
    inertia: Any = None


class PaddlingTable(PlaceTable):
    """d_alpha: a channel of it, or the angles of both wings."""

    unit: str | None = None
    sign: Sign = 1
    convention: Convention
    left: ChannelTable | None = None
    right: ChannelTable | None = None
    stroke: ChannelTable | None = None


class MappingFile(Table):
    """A complete mapping file."""

    name: str = Field(min_length=1, max_length=100)
    description: str = ""
    empty: str = ""  #: why the file holds no motion; reading it is refused with these words
    source: str = ""
    file: FileTable
    clock: ClockTable
    frames: FramesTable = FramesTable()
    yaw: YawTable | None = None
    position: PositionTable | None = None
    quaternion: QuaternionTable | None = None
    velocity: VectorTable | None = None
    angular_velocity: VectorTable | None = None
    left: WingTable | None = None
    right: WingTable | None = None
    trial: TrialTable | None = None
    perturbation: PerturbationTable | None = None
    paddling: PaddlingTable | None = None
    notes: dict[str, str] = Field(default={})

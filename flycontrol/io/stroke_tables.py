"""The keys of a table of stroke kinematics, as TOML holds them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from flycontrol.io.entries import QuantityEntry
from flycontrol.io.mapping_file import ChannelTable, PlaceTable, Sign
from flycontrol.io.series_conventions import Constant
from flycontrol.io.toml_files import Table

Name = Annotated[str, Field(min_length=1, max_length=1000)]


class BermanWangTable(Table):
    """Berman & Wang's family."""

    kind: Literal["Berman and Wang"]
    stroke_amplitude: QuantityEntry  #: half of peak to peak
    stroke_shape: QuantityEntry | None = None
    stroke_offset: QuantityEntry | None = None
    pitch_amplitude: QuantityEntry | None = None
    pitch_shape: QuantityEntry | None = None
    pitch_lead: QuantityEntry | None = None
    pitch_offset: QuantityEntry | None = None
    deviation_amplitude: QuantityEntry | None = None
    deviation_order: Annotated[int, Field(ge=1, le=100)] = 2
    deviation_phase: QuantityEntry | None = None
    deviation_offset: QuantityEntry | None = None


class SeriesTable(Table):
    """mean + sum of cosine_k cos 2 pi k p + sine_k sin 2 pi k p, lists from k = 1 on."""

    mean: Any = "0 deg"
    cosine: list[Any] = Field(default=[], max_length=500)
    sine: list[Any] = Field(default=[], max_length=500)


class FourierTable(Table):
    """A Fourier series for each angle."""

    kind: Literal["Fourier"]
    stroke: SeriesTable
    deviation: SeriesTable = SeriesTable()
    pitch: SeriesTable


class AngleConventionTable(Table):
    """Where a file holds the series of one angle, and how it becomes this package's."""

    cosine: str = ""
    sine: str = ""
    constant: str = ""
    sign: Sign = 1
    offset: Any = "0 deg"
    advance: Annotated[float, Field(ge=-1, le=1)] = 0.0
    scale: Annotated[float, Field(gt=0, le=1000)] = 1.0


class ConventionTable(Table):
    """What the numbers of a file of series mean."""

    unit: str
    constant: Constant
    stroke: AngleConventionTable
    deviation: AngleConventionTable | None = None
    pitch: AngleConventionTable


class FourierFileTable(Table):
    """Fourier series in a JSON file, and the name of its convention or the convention itself."""

    kind: Literal["Fourier file"]
    file: Name
    convention: Any


class SamplesTable(Table):
    """Measured angles in a text table."""

    kind: Literal["samples"]
    file: Name
    format: Literal["csv", "tsv", "whitespace"] = "csv"
    separator: Literal[",", ";", "|"] | None = None
    decimal: Literal[".", ","] = "."
    phase: PlaceTable | None = None  #: [wingbeats]
    time: ChannelTable | None = None
    start: Any = None  #: the time that is phase 0
    stroke: ChannelTable
    deviation: ChannelTable | None = None
    pitch: ChannelTable
    periodic: bool
    harmonics: Annotated[int, Field(ge=1, le=100)] | None = None


class ModulationTable(Table):
    """What steering changes, from the first wingbeat on or along a ramp."""

    wing: Literal["left", "right", "both"] | None = None
    stroke_gain: Annotated[float, Field(gt=-1, le=2)] = 0.0
    stroke_offset: Any = "0 deg"
    deviation_offset: Any = "0 deg"
    pitch_offset: Any = "0 deg"
    paddling: Any = None  #: d_alpha, > 0 turns right; moves the pitch of both wings
    ramp: Annotated[list[float], Field(min_length=2, max_length=2)] | None = None  #: from, to [wingbeats]


class StrokeTable(Table):
    """The stroke of both wings."""

    frequency: QuantityEntry
    both: dict[str, Any] | None = None
    left: dict[str, Any] | None = None
    right: dict[str, Any] | None = None
    modulation: list[ModulationTable] = Field(default=[], max_length=1000)

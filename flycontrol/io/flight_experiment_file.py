"""The tables and keys of a flight experiment's file, as TOML holds them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from flycontrol.io.toml_files import Table

Count = Annotated[int, Field(ge=1)]


TrimName = Literal[
    "frequency",
    "stroke_amplitude",
    "stroke_offset",
    "pitch_amplitude",
    "pitch_offset",
    "pitch_lead",
    "deviation_offset",
    "body_pitch",
]


class TrimTable(Table):
    """What a hover trim moves."""

    moves: list[TrimName]
    body_pitch: Any = "0 deg"


class BodyTable(Table):
    """What of the body is free."""

    free: Literal["all", "yaw", "none"] | list[Literal["forward", "sideways", "down", "roll", "pitch", "yaw"]]


class PulseTable(Table):
    """A torque on the body."""

    axis: Literal["roll", "pitch", "yaw"]
    frame: Literal["stroke plane", "body"] = "stroke plane"
    torque: Any
    onset: Any
    duration: Any


class JointTable(Table):
    """What moves one angle of a wing."""

    kind: Literal["prescribed", "spring", "torque"]
    stiffness: Any = None
    damping: Any = None
    rest_angle: Any = None
    amplitude: Any = None
    mean: Any = None
    lead: Any = None


class WingHingeTable(Table):
    """The joints of one wing."""

    stroke: JointTable | None = None
    deviation: JointTable | None = None
    pitch: JointTable | None = None


class HingesTable(WingHingeTable):
    """The joints of both wings, and where one of them differs."""

    left: WingHingeTable = WingHingeTable()
    right: WingHingeTable = WingHingeTable()


class AirTable(Table):
    """What the air does."""

    terms: list[Literal["translational", "rotational", "added_mass", "dissipative"]]
    coefficients: Literal["dickinson1999", "wang2004"]
    density: Any
    nodes: Count


class MarchTable(Table):
    """How long, and how finely."""

    wingbeats: Count
    steps: Count
    samples: Count
    tolerance: Any


class SpreadTable(Table):
    """Standard deviations; quantities such as "5 %"."""

    mass: Any = None
    wing_length: Any = None
    stroke_gain: Any = None
    stroke_offset: Any = None
    deviation_offset: Any = None
    pitch_offset: Any = None
    torque: Any = None
    onset: Any = None


class EnsembleTable(Table):
    """How many flights, drawn how."""

    flights: Count
    seed: Annotated[int, Field(ge=0)] = 0
    spread: SpreadTable = SpreadTable()


class ExperimentFile(Table):
    """A complete experiment."""

    name: str = Field(min_length=1, max_length=100)
    morphology: dict[str, Any]
    stroke: dict[str, Any]
    trim: TrimTable
    body: BodyTable
    pulse: list[PulseTable] = Field(default=[])
    hinges: HingesTable = HingesTable()
    air: AirTable
    march: MarchTable
    ensemble: EnsembleTable | None = None

"""What a mapping says of an experiment: the trials in a file, what perturbed the fly, how its wings answered."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from flycontrol.io.places import Channel, Label, Place, Scalar

Convention = Literal[
    "d_alpha",
    "right minus left, forward stroke",
    "attack angle",
    "attack angle, forward stroke",
    "wing pitch",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class PulseMapping:
    """A torque pulse: its numbers, or where a file gives them."""

    onset: float | Scalar  #: [s] on the trial's clock
    duration: float | Scalar  #: [s]
    angular_impulse: float | Scalar | None = None  #: [rad/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class TraceMapping:
    """A recorded coil current, voltage or torque."""

    drive: Channel
    unit: str  #: in which the drive is handed on: "A", "V", "N m", or "1"
    time: Channel | None = None  #: its own clock; None: the trial's
    angular_acceleration_per_unit: float | None = None  #: [1/s^2 per unit]


@dataclass(frozen=True, slots=True, kw_only=True)
class PaddlingMapping:
    """d_alpha: a channel of it, or the angles of both wings."""

    convention: Convention
    difference: Channel | None = None
    left: Channel | None = None
    right: Channel | None = None
    stroke: Channel | None = None  #: positive forward; its rate tells the half-strokes


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """How the trials of an experiment are told apart, and what is known of each."""

    trial: Place | None = None  #: a column whose value names the trial of a row
    groups: tuple[str, ...] = ()  #: structures or groups of a file that are a trial each
    name: Label | None = None  #: None: the file's name
    fly: Label | None = None
    cut_at_gaps: bool = False  #: where yaw is ambiguous; otherwise such a trial is refused
    perturbation: PulseMapping | TraceMapping | None = None
    paddling: PaddlingMapping | None = None

    def channels(self) -> Iterator[Channel]:
        """Channels of the perturbation and of the wings."""
        if isinstance(self.perturbation, TraceMapping):
            yield self.perturbation.drive
            yield from () if self.perturbation.time is None else (self.perturbation.time,)
        if self.paddling is not None:
            wings = (self.paddling.difference, self.paddling.left, self.paddling.right, self.paddling.stroke)
            yield from (channel for channel in wings if channel is not None)

    def scalars(self) -> Iterator[Scalar]:
        """Numbers that a file gives once for each trial."""
        pulse = self.perturbation
        if isinstance(pulse, PulseMapping):
            given = (pulse.onset, pulse.duration, pulse.angular_impulse)
            yield from (value for value in given if isinstance(value, Scalar))

    def labels(self) -> Iterator[Label]:
        """Words that name a trial."""
        yield from (label for label in (self.name, self.fly) if label is not None)

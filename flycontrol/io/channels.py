"""A mapping in SI units: which row or column holds which channel of a recording, and what its numbers mean."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from flycontrol.io.experiment import Experiment
from flycontrol.io.formats import FileFormat
from flycontrol.io.places import Channel, Orientation, Scalar

VectorFrame = Literal["stroke plane", "body", "world"]


@dataclass(frozen=True, slots=True, kw_only=True)
class VectorChannels:
    """Components along x, y, z of a frame."""

    channels: tuple[Channel, ...]
    frame: VectorFrame


@dataclass(frozen=True, slots=True, kw_only=True)
class QuaternionChannels:
    """Components w, x, y, z of the body's attitude."""

    channels: tuple[Channel, ...]
    rotation: Literal["body to world", "world to body"]


@dataclass(frozen=True, slots=True, kw_only=True)
class WingChannels:
    """The three angles of one wing."""

    stroke: Channel
    deviation: Channel
    pitch: Channel


@dataclass(frozen=True, slots=True, kw_only=True)
class Clock:
    """Either a channel of times, or a rate with or without a channel that counts frames."""

    time: Channel | None = None
    frame: Channel | None = None
    rate: float | Scalar | None = None  #: [1/s]
    start: float = 0.0  #: time of frame 0, or of the first sample where no frames are counted [s]
    wingbeat_frequency: float | None = None  #: expected, where no wing is mapped to measure it [1/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingMapping:
    """How to read one layout of recordings."""

    name: str
    format: FileFormat
    orientation: Orientation
    count: int | None  #: of channels in the file
    separator: str | None = None  #: of the fields of a text table; None: white space
    decimal_comma: bool = False
    clock: Clock
    world_z: Literal["up", "down"] | None
    body_axes: Literal["forward right down", "forward left up"]
    stroke_plane_angle: float | None  #: v_S = Ry(angle) v_B [rad]
    yaw: Channel | None = None
    yaw_is_unwrapped: bool = False  #: the file's yaw has no jumps of a full turn, and its gaps none either
    position: tuple[Channel, ...] | None = None
    quaternion: QuaternionChannels | None = None
    velocity: VectorChannels | None = None
    angular_velocity: VectorChannels | None = None
    left: WingChannels | None = None
    right: WingChannels | None = None
    experiment: Experiment = field(default_factory=Experiment)
    notes: dict[str, str] = field(default_factory=dict[str, str])
    sha256: str = ""  #: hash of the mapping file's bytes

    def recording_channels(self) -> Iterator[Channel]:
        """Channels of a Recording, in the order of the mapping's tables."""
        yield from (channel for channel in (self.clock.time, self.clock.frame, self.yaw) if channel is not None)
        yield from self.position or ()
        for group in (self.quaternion, self.velocity, self.angular_velocity):
            yield from () if group is None else group.channels
        for wing in (self.left, self.right):
            yield from () if wing is None else (wing.stroke, wing.deviation, wing.pitch)

    def trial_channels(self) -> Iterator[Channel]:
        """Channels of a Trial: the clock, yaw or else the quaternion that tells it, and those of the experiment."""
        yield from (channel for channel in (self.clock.time, self.clock.frame, self.yaw) if channel is not None)
        if self.yaw is None and self.quaternion is not None:
            yield from self.quaternion.channels
        yield from self.experiment.channels()

    def channels(self) -> Iterator[Channel]:
        """All channels."""
        yield from self.recording_channels()
        yield from self.experiment.channels()

    def scalars(self) -> Iterator[Scalar]:
        """All numbers that a file gives once."""
        if isinstance(self.clock.rate, Scalar):
            yield self.clock.rate
        yield from self.experiment.scalars()

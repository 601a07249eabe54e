"""A mapping in SI units: which row or column holds which channel of a recording, and what its numbers mean."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from flycontrol.io.quantities import Kind
from flycontrol.io.tables import Orientation, TableFormat

VectorFrame = Literal["stroke plane", "body", "world"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """Value in SI = offset + sign * factor * (number in the file)."""

    key: str  #: its name in the mapping, "left.stroke"
    place: int | str  #: row or column, counted from 0, or its name
    where: str  #: file and line of the mapping
    kind: Kind
    unit: str = "1"  #: of the numbers in the file
    factor: float = 1.0  #: size of that unit in SI
    sign: int = 1
    offset: float = 0.0  #: [SI unit]


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
    rate: float | None = None  #: [1/s]
    wingbeat_frequency: float | None = None  #: expected, where no wing is mapped to measure it [1/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingMapping:
    """How to read one layout of recordings."""

    name: str
    format: TableFormat
    orientation: Orientation
    count: int | None  #: of channels in the file
    clock: Clock
    world_z: Literal["up", "down"] | None
    body_axes: Literal["forward right down", "forward left up"]
    stroke_plane_angle: float | None  #: v_S = Ry(angle) v_B [rad]
    yaw: Channel | None = None
    position: tuple[Channel, ...] | None = None
    quaternion: QuaternionChannels | None = None
    velocity: VectorChannels | None = None
    angular_velocity: VectorChannels | None = None
    left: WingChannels | None = None
    right: WingChannels | None = None
    notes: dict[str, str] = field(default_factory=dict[str, str])
    sha256: str = ""  #: hash of the mapping file's bytes

    def channels(self) -> Iterator[Channel]:
        """All channels, in the order of the mapping's tables."""
        yield from (channel for channel in (self.clock.time, self.clock.frame, self.yaw) if channel is not None)
        yield from self.position or ()
        for group in (self.quaternion, self.velocity, self.angular_velocity):
            yield from () if group is None else group.channels
        for wing in (self.left, self.right):
            yield from () if wing is None else (wing.stroke, wing.deviation, wing.pitch)

"""A recording of a flying fly: body and wing motion, sampled evenly, in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class WingAngles:
    """Angles of one wing in the stroke-plane frame [rad], each of shape (N,).

    Stroke is positive when the wing is swept forward of the lateral axis; deviation is positive out of the stroke
    plane on the dorsal side; pitch is 90 deg when the chord is vertical and below it on the forward stroke.
    """

    stroke: FloatArray  #: phi [rad]
    deviation: FloatArray  #: theta [rad]
    pitch: FloatArray  #: eta [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """Body and wing motion on an even time grid; a channel that was not measured is None.

    Vectors of shape (N, 3) are along forward, right and down of the frame that their name gives
    (S: stroke plane, B: body, W: world with z up).
    """

    name: str
    rate: float  #: samples a second [1/s]
    time: FloatArray  #: (N,) [s]
    source_sha256: str  #: hash of the file's bytes
    yaw: FloatArray | None = None  #: (N,) heading, positive to the right [rad]
    position_W: FloatArray | None = None  #: (N, 3) [m]
    velocity_S: FloatArray | None = None  #: (N, 3) [m/s]
    angular_velocity_S: FloatArray | None = None  #: (N, 3) roll, pitch, yaw rate [rad/s]
    q_WB: FloatArray | None = None  #: (N, 4) body to world, scalar first
    stroke_plane_angle: float | None = None  #: v_S = Ry(angle) v_B: the stroke plane's frame is nose down [rad]
    left: WingAngles | None = None
    right: WingAngles | None = None
    notes: Mapping[str, str] = field(default_factory=dict[str, str])  #: what the mapping says of its conventions

    def __post_init__(self) -> None:
        if not self.rate > 0:
            raise InvalidInputError(f"{self.name}: the sampling rate must be > 0 1/s, got {self.rate!r}.")
        for array in self._arrays():
            if len(array) != len(self.time):
                raise InvalidInputError(
                    f"{self.name}: a channel has {len(array)} samples where time has {len(self.time)}; "
                    "check the mapping."
                )
            array.setflags(write=False)

    def _arrays(self) -> list[FloatArray]:
        wings = [a for w in (self.left, self.right) if w is not None for a in (w.stroke, w.deviation, w.pitch)]
        body = [self.time, self.yaw, self.position_W, self.velocity_S, self.angular_velocity_S, self.q_WB]
        return [a for a in body if a is not None] + wings

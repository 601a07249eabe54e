"""What a trajectory's file holds: its variables, their units and what they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flycontrol.model.morphology import pitch_rotation
from flycontrol.model.trajectory import Trajectory

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Variable:
    """One variable over time, with a column for each of its components."""

    name: str
    unit: str
    meaning: str
    components: tuple[str, ...] = ()  #: empty: a single number at each instant

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of its columns in a table."""
        return tuple(f"{self.name}_{part}" for part in self.components) or (self.name,)


_XYZ, _WXYZ, _ANGLES = ("x", "y", "z"), ("w", "x", "y", "z"), ("stroke", "deviation", "pitch")
VARIABLES = (
    Variable("time", "s", "time since the flight began"),
    Variable("yaw", "rad", "heading of the stroke plane's forward axis, positive to the right, no jumps"),
    Variable("position_W", "m", "centre of mass of the body without wings; world x and y level, z up", _XYZ),
    Variable("q_WB", "1", "body to world, unit quaternion, scalar first; body x forward, y right, z down", _WXYZ),
    Variable("velocity_S", "m/s", "of the centre of mass, stroke-plane frame: forward, right, down", _XYZ),
    Variable("angular_velocity_S", "rad/s", "roll, pitch, yaw rate about the stroke-plane axes", _XYZ),
    Variable("left", "rad", "left wing: stroke forward, deviation dorsal, pitch 90 deg for a vertical chord", _ANGLES),
    Variable("right", "rad", "right wing, likewise", _ANGLES),
    Variable("left_rate", "rad/s", "rates of the left wing's angles", _ANGLES),
    Variable("right_rate", "rad/s", "rates of the right wing's angles", _ANGLES),
)


def table_of(flight: Trajectory, stroke_plane_angle: float) -> dict[str, FloatArray]:
    """Each variable's samples, (N,) or (N, components), heading unwrapped within the flight."""
    wings = {side: flight.wing(side) for side in ("left", "right")}
    return {
        "time": flight.time,
        "yaw": flight.yaw,
        "position_W": flight.position_W,
        "q_WB": body_attitude(flight, stroke_plane_angle),
        "velocity_S": flight.velocity_S,
        "angular_velocity_S": flight.angular_velocity_S,
        **{side: np.stack([w.stroke, w.deviation, w.pitch], axis=1) for side, w in wings.items()},
        **{
            f"{side}_rate": np.stack([w.stroke_rate, w.deviation_rate, w.pitch_rate], axis=1)
            for side, w in wings.items()
        },
    }


def body_attitude(flight: Trajectory, stroke_plane_angle: float) -> FloatArray:
    """R_WB = R_WS R_SB, v_S = Ry(angle) v_B, as quaternions (N, 4), scalar first."""
    to_stroke_plane = Rotation.from_matrix(pitch_rotation(stroke_plane_angle))
    attitude = Rotation.from_quat(flight.q_WS, scalar_first=True) * to_stroke_plane
    return np.asarray(attitude.as_quat(scalar_first=True), dtype=np.float64)

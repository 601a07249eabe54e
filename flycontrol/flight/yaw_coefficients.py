"""beta and gamma of Eq. 3 from the blade elements, for a given stroke."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.aerodynamics import BodyMotion, QuasiSteadyModel, flight_loads
from flycontrol.flight.coefficients import COEFFICIENTS
from flycontrol.model.morphology import Morphology
from flycontrol.model.stroke import WingMotion, attack_angle

FloatArray = NDArray[np.float64]

SMALL_RATE = 0.1  #: [rad/s], against wing rates of 1000 rad/s
SMALL_ANGLE = 1e-3  #: [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class YawCoefficients:
    """Stroke-averaged yaw torque N = -beta psi' + gamma d_alpha about the stroke-plane normal, at a given stroke."""

    damping: float  #: beta [N m s]
    roll_to_yaw: float  #: -dN/dp, yaw torque against the roll rate [N m s]
    paddling: float  #: gamma [N m/rad]
    mean_wing_speed: float  #: omega = <|phi'|> [rad/s]
    drag_slope_ratio: float  #: C_D' / (2 C_D) at the phi'^2-weighted attack angle [1/rad]

    @property
    def turn_gain(self) -> float:
        """gamma / beta, the turn angle per integral of d_alpha [1/s]."""
        return self.paddling / self.damping

    @property
    def turn_gain_over_wing_speed(self) -> float:
        """gamma / (beta omega): 1 in Eq. 5 [1]."""
        return self.turn_gain / self.mean_wing_speed


def yaw_coefficients(
    morphology: Morphology, stroke: WingMotion, velocity: FloatArray, model: QuasiSteadyModel | None = None
) -> YawCoefficients:
    """Central differences of the mean yaw torque of a stroke that both wings share.

    Parameters
    ----------
    morphology : the fly
    stroke : one or more whole wingbeats, evenly sampled, arrays of shape (N,)
    velocity : (3,) mean velocity of the body, frame S [m/s]; its sideways part is left out
    """
    model = model or QuasiSteadyModel()
    straight = np.array([velocity[0], 0.0, velocity[2]])

    def torque(roll_rate: float, yaw_rate: float, d_alpha: float) -> float:
        count = len(stroke.stroke)
        body = BodyMotion(
            velocity=np.tile(straight, (count, 1)), angular_velocity=np.tile([roll_rate, 0.0, yaw_rate], (count, 1))
        )
        left, right = (replace(stroke, pitch=stroke.pitch + side * d_alpha) for side in (-1, 1))
        return float(flight_loads(morphology, left, right, body, model).total.torque[:, 2].mean())

    weight = stroke.stroke_rate**2
    attack = np.average(attack_angle(stroke.pitch, stroke.stroke_rate), weights=weight)
    drag = COEFFICIENTS[model.coefficients](attack + SMALL_ANGLE * np.array([-1.0, 0.0, 1.0])).drag
    return YawCoefficients(
        damping=-(torque(0, SMALL_RATE, 0) - torque(0, -SMALL_RATE, 0)) / (2 * SMALL_RATE),
        roll_to_yaw=-(torque(SMALL_RATE, 0, 0) - torque(-SMALL_RATE, 0, 0)) / (2 * SMALL_RATE),
        paddling=(torque(0, 0, SMALL_ANGLE) - torque(0, 0, -SMALL_ANGLE)) / (2 * SMALL_ANGLE),
        mean_wing_speed=float(np.abs(stroke.stroke_rate).mean()),
        drag_slope_ratio=float((drag[2] - drag[0]) / (2 * SMALL_ANGLE) / (2 * drag[1])),
    )

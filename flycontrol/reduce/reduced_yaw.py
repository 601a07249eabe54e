"""The reduced yaw model of a flying fly, every coefficient from its wings.  Review, Eq. 3, 7 and 8.

I psi'' = -beta psi' + gamma d_alpha + N_ext,    d_alpha = mu d_eta0
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.hinge_transmission import HingeTransmission
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.yaw import PDController, PIDController, YawLoop, YawPlant
from flycontrol.reduce.yaw_inertia import YawInertia, yaw_inertia
from flycontrol.reduce.yaw_torque import Vector, YawExperiment, slopes_error, yaw_slopes


@dataclass(frozen=True, slots=True, kw_only=True)
class ReducedYaw:
    """Coefficients of yaw about the vertical in hover, and the loop that they make."""

    inertia: YawInertia
    damping: float  #: beta [N m s]
    paddling: float  #: gamma [N m/rad]
    damping_error: float  #: what half as many instants change of beta; NaN where the hinge made it [N m s]
    paddling_error: float  #: what half as many instants change of gamma; NaN where the hinge made it [N m/rad]
    wingbeat_frequency: float  #: [1/s]
    transmission: float | None = None  #: mu = d d_alpha / d eta0 of the hinge [1]

    def __post_init__(self) -> None:
        if not self.damping > 0:
            raise InvalidParameterError(
                f"A reduced yaw model needs a damped fly, beta > 0 N m s, got {self.damping:.3g} N m s; give it air, "
                "and wings that sweep."
            )
        if self.transmission is not None and not (np.isfinite(self.transmission) and self.transmission != 0):
            raise InvalidParameterError(
                f"ReducedYaw.transmission must be a finite number other than 0, or None, got {self.transmission!r}."
            )

    @property
    def plant(self) -> YawPlant:
        """I and beta."""
        return YawPlant(inertia=self.inertia.total, damping=self.damping)

    @property
    def turn_gain(self) -> float:
        """gamma / beta: the turn angle per integral of d_alpha, Eq. 5 [1/s]."""
        return self.paddling / self.damping

    @property
    def half_life(self) -> float:
        """ln 2 I / beta: what a yaw rate takes to halve when the fly does nothing [s]."""
        return float(np.log(2)) * self.inertia.total / self.damping

    @property
    def hinge_torque(self) -> float:
        """gamma mu: yaw torque per bias of the hinges' rest angles, opposite on both sides [N m/rad]."""
        if self.transmission is None:
            raise InvalidParameterError(
                "The torque of a hinge bias needs mu, which is not known here; give ReducedYaw.transmission."
            )
        return self.paddling * self.transmission

    def by_paddling(self, gains: PDController | PIDController) -> PDController | PIDController:
        """Torque gains of gains whose output is a paddling angle d_alpha: K = gamma k, k in rad of d_alpha."""
        return _scaled(gains, self.paddling)

    def by_hinge(self, gains: PDController | PIDController) -> PDController | PIDController:
        """Torque gains of gains whose output is a hinge bias d_eta0: K = gamma mu k.  Review, Eq. 8."""
        return _scaled(gains, self.hinge_torque)

    def through(self, hinge: HingeTransmission) -> ReducedYaw:
        """The same body with wings that pitch passively: beta, gamma and mu of their springs.

        Mu is that of the torque, so that gamma mu is the torque per bias. A wing that gives way as the body turns damps
        it less than one whose pitch is prescribed.
        """
        return replace(
            self, damping=hinge.damping, paddling=hinge.torque_per_paddling, transmission=hinge.mu_torque,
            damping_error=float("nan"), paddling_error=float("nan"),
        )  # fmt: skip

    def loop(self, controller: PDController | PIDController, delay: float) -> YawLoop:
        """The closed loop of Eq. 7 on this plant; gains in torque, delay T [s]."""
        return YawLoop(plant=self.plant, controller=controller, delay=delay)


def reduced_yaw(
    fly: FlappingFly,
    kinematics: StrokeKinematics,
    *,
    body_pitch: float = 0.0,
    transmission: float | None = None,
) -> ReducedYaw:
    """Take I, beta and gamma from the wing level; nothing is fitted.

    Parameters
    ----------
    fly
        Its body freedoms do not count.
    kinematics
        A periodic stroke, of a hover trim if the model is to be that of hover.
    body_pitch
        Mean angle of the stroke plane above the horizon, > 0 nose up: the trim's, which tells where the vertical is
        [rad].
    transmission
        mu, from the hinge's own motion.

    Raises
    ------
    InvalidParameterError
        The body's pitch is beyond +-pi/2, the stroke changes between wingbeats, or nothing damps the fly.
    """
    if not abs(body_pitch) <= np.pi / 2:  # `not <=` also refuses NaN
        raise InvalidParameterError(
            f"reduced_yaw needs the body's pitch in radians, within +-pi/2, got {body_pitch!r}; write 55 * deg for "
            "55 degrees (flycontrol.units)."
        )
    vertical: Vector = (-float(np.sin(body_pitch)), 0.0, float(np.cos(body_pitch)))
    experiment = YawExperiment(fly=fly, kinematics=kinematics, axis_S=vertical)
    slopes = yaw_slopes(experiment)
    errors = slopes_error(experiment)
    return ReducedYaw(
        inertia=yaw_inertia(experiment),
        damping=slopes.damping,
        paddling=slopes.paddling,
        damping_error=errors[0],
        paddling_error=errors[1],
        wingbeat_frequency=kinematics.frequency,
        transmission=transmission,
    )


def _scaled(gains: PDController | PIDController, torque: float) -> PDController | PIDController:
    if not isinstance(gains, PDController | PIDController):
        raise InvalidParameterError(
            f"Gains are a PDController or a PIDController, got {gains!r}; write PDController(proportional=..., "
            "derivative=...)."
        )
    proportional, derivative = torque * gains.proportional, torque * gains.derivative
    if isinstance(gains, PIDController):
        return PIDController(proportional=proportional, integral=torque * gains.integral, derivative=derivative)
    return PDController(proportional=proportional, derivative=derivative)

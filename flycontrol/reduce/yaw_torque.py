"""Wingbeat-averaged yaw torque of the air on a fly that turns steadily while it paddles.  Review, Eq. 2.

    <N>(psi', d_alpha) = -beta psi' + gamma d_alpha + ...

psi' turns about an axis that is fixed to the body, by default the stroke plane's normal, and N is the torque about it
through the centre of mass. Wings and their inertia add nothing to the mean of a steadily turning periodic stroke.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.aerodynamics import FlightLoads
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.quasi_steady import TERMS, Term
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import paddling
from flycontrol.reduce.steady_turn import steady_turn

FloatArray = NDArray[np.float64]
Vector = tuple[float, float, float]

NORMAL: Vector = (0.0, 0.0, 1.0)  #: of the stroke plane, down: psi' > 0 turns right
INSTANTS = 2000  #: of a wingbeat that a mean is taken over
_RATE = 1e-2  # of a central difference [radians a wingbeat]: small against wings, large against the kinks at reversal
_ANGLE = 1e-3  # [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class YawExperiment:
    """A fly held at its centre of mass, turned at a steady rate while its wings beat."""

    fly: FlappingFly  #: its air and its shape; its freedoms do not count
    kinematics: StrokeKinematics  #: a periodic stroke
    axis_S: Vector = NORMAL  #: unit vector that it turns about, frame S
    instants: int = INSTANTS  #: of a wingbeat

    def __post_init__(self) -> None:
        if not (self.kinematics.left.periodic and self.kinematics.right.periodic):
            raise InvalidParameterError(
                "A stroke-averaged torque needs a stroke that repeats, and this one changes between wingbeats; give a "
                "periodic one."
            )
        if not abs(float(np.linalg.norm(self.axis_S)) - 1.0) < 1e-9:
            raise InvalidParameterError(f"YawExperiment.axis_S must be a unit vector, got {self.axis_S!r}.")
        if not (isinstance(self.instants, int | np.integer) and self.instants >= 100):
            raise InvalidParameterError(
                f"YawExperiment.instants must be a whole number of at least 100, got {self.instants!r}."
            )

    @property
    def difference(self) -> float:
        """Yaw rate of the central difference that slopes are taken by [rad/s]."""
        return _RATE * self.kinematics.frequency

    def torques(self, yaw_rate: float = 0.0, d_alpha: float = 0.0) -> dict[Term, float]:
        """Mean torque about the axis by term of the air [N m], at a yaw rate [rad/s] and a paddling angle [rad]."""
        if not (np.isfinite(yaw_rate) and np.isfinite(d_alpha)):
            raise InvalidParameterError(
                f"A yaw torque needs a finite yaw rate and paddling angle, got {yaw_rate!r} rad/s and {d_alpha!r} rad."
            )
        loads = self._loads(yaw_rate, d_alpha)
        axis = np.array(self.axis_S)
        return {
            term: float(sum((wing.terms[term].torque @ axis).mean() for wing in (loads.left, loads.right)))
            for term in TERMS
        }

    def torque(self, yaw_rate: float = 0.0, d_alpha: float = 0.0) -> float:
        """Mean torque about the axis [N m], > 0 to the right."""
        return sum(self.torques(yaw_rate, d_alpha).values())

    def _loads(self, yaw_rate: float, d_alpha: float) -> FlightLoads:
        stroke = self.kinematics.modulated(*paddling(d_alpha))
        return loads_along(self.fly, steady_turn(stroke, yaw_rate * np.array(self.axis_S), self.instants))


@dataclass(frozen=True, slots=True, kw_only=True)
class YawSlopes:
    """beta = -d<N>/dpsi' and gamma = d<N>/d d_alpha at rest.  Review, Eq. 3."""

    damping: float  #: beta [N m s]
    paddling: float  #: gamma [N m/rad]
    damping_by_term: dict[Term, float]  #: summands of beta [N m s]
    paddling_by_term: dict[Term, float]  #: summands of gamma [N m/rad]

    @property
    def turn_gain(self) -> float:
        """gamma / beta: the turn angle per integral of d_alpha, Eq. 5 [1/s]; refused where nothing damps."""
        if not self.damping > 0:
            raise InvalidParameterError(
                f"gamma/beta needs a damped fly, beta > 0 N m s, got {self.damping:.3g} N m s; give it air that "
                "has the translational term, and wings that sweep."
            )
        return self.paddling / self.damping


def yaw_slopes(experiment: YawExperiment) -> YawSlopes:
    """Central differences of the mean yaw torque, term by term."""
    rate = experiment.difference
    damping = _slopes(experiment.torques(yaw_rate=rate), experiment.torques(yaw_rate=-rate), -2 * rate)
    gain = _slopes(experiment.torques(d_alpha=_ANGLE), experiment.torques(d_alpha=-_ANGLE), 2 * _ANGLE)
    return YawSlopes(
        damping=sum(damping.values()),
        paddling=sum(gain.values()),
        damping_by_term=damping,
        paddling_by_term=gain,
    )


def slopes_error(experiment: YawExperiment) -> tuple[float, float]:
    """What half as many instants change of beta [N m s] and gamma [N m/rad]."""
    fine, coarse = (
        yaw_slopes(replace(experiment, instants=n)) for n in (experiment.instants, experiment.instants // 2)
    )
    return abs(fine.damping - coarse.damping), abs(fine.paddling - coarse.paddling)


def _slopes(ahead: dict[Term, float], back: dict[Term, float], apart: float) -> dict[Term, float]:
    return {term: (ahead[term] - back[term]) / apart for term in TERMS}

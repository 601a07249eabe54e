"""The wing hinge as a damped torsional spring, and a stroke that says where its spring rests.

    tau = -kappa (eta - eta_0) - C eta'

Review, section 5 (bergou2010). tau acts on the wing about its pitch axis and does the work tau eta' on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.equations import hinge_torque
from flycontrol.model.provenance import Provenance
from flycontrol.model.wing_stroke import PhasedAngles, WingStroke

FloatArray = NDArray[np.float64]

PUBLISHED_STIFFNESS = (1e-9, 3e-9)  #: kappa [N m/rad]
STIFFNESS_PROVENANCE = Provenance(
    source="bergou2010", certainty="S2", note="order of magnitude, second hand: the number was not read in the source"
)

PUBLISHED_TRANSMISSION = (0.5, 0.6)  #: mu: "one-half" in the caption of Fig. 6, 0.6 in the text
TRANSMISSION_PROVENANCE = Provenance(source="review", certainty="S", note="section 5 and Fig. 6d")


@dataclass(frozen=True, slots=True, kw_only=True)
class DampedSpring:
    """Tau = -kappa (eta - eta_0) - C eta'."""

    stiffness: float  #: kappa [N m/rad]
    damping: float = 0.0  #: C [N m s/rad]
    rest_angle: float = np.pi / 2  #: eta_0 [rad]

    def __post_init__(self) -> None:
        _refuse_negative("DampedSpring", self.stiffness, self.damping)
        _refuse_endless("DampedSpring", self.rest_angle)

    def torque(self, pitch: FloatArray, pitch_rate: FloatArray) -> FloatArray:
        """Torque on the wing [N m] at angles [rad] and rates [rad/s], arrays of one shape."""
        return hinge_torque(self.stiffness, self.damping, pitch, self.rest_angle, pitch_rate)


@dataclass(frozen=True, slots=True, kw_only=True)
class SteeredSpring:
    """Tau = -kappa (eta - eta_0(t)) - C eta', eta_0(t) the stroke's own angle, so that steering moves it."""

    stiffness: float  #: kappa [N m/rad]
    damping: float = 0.0  #: C [N m s/rad]

    def __post_init__(self) -> None:
        _refuse_negative("SteeredSpring", self.stiffness, self.damping)


@dataclass(frozen=True, slots=True, kw_only=True)
class HingeStroke:
    """Stroke and deviation of a wingbeat; in place of its pitch the rest angle of the spring that the wing hangs on.

    A `Modulation` of it with a pitch offset biases eta_0, as smoothly as `ModulatedStroke` passes from one to another.
    """

    stroke: WingStroke
    rest_angle: float = np.pi / 2  #: eta_0 [rad]

    def __post_init__(self) -> None:
        _refuse_endless("HingeStroke", self.rest_angle)

    @property
    def periodic(self) -> bool:
        """Whether every wingbeat is like the first."""
        return self.stroke.periodic

    def __call__(self, phase: FloatArray) -> PhasedAngles:
        """Angles and derivatives at phases (N,) [wingbeats]; the third one is eta_0."""
        at = self.stroke(phase)
        angles, first, second = at.angles.copy(), at.first.copy(), at.second.copy()
        angles[:, 2], first[:, 2], second[:, 2] = self.rest_angle, 0.0, 0.0
        return PhasedAngles(angles=angles, first=first, second=second)


def _refuse_negative(name: str, stiffness: float, damping: float) -> None:
    if not (0 <= stiffness < np.inf and 0 <= damping < np.inf):  # refuses NaN too
        raise InvalidParameterError(
            f"{name} needs stiffness and damping >= 0, got {stiffness!r} N m/rad and {damping!r} N m s/rad."
        )


def _refuse_endless(name: str, rest_angle: float) -> None:
    if not np.isfinite(rest_angle):
        raise InvalidParameterError(f"{name}.rest_angle must be a finite angle in rad, got {rest_angle!r}.")

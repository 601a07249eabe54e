"""The loop as halteres, neural controller, hinge, paddling and body, in the numbers of one fly (Fig. 8)."""

from __future__ import annotations

from dataclasses import dataclass

from flycontrol.model.chain import Chain, yaw_chain
from flycontrol.model.parameters import Sourced
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg

MU = Sourced(
    value=0.6, unit="1", source="review", certainty="S", text="0.6",
    note="paddling angle a hinge bias, text of section 5; the caption of Fig. 6 says one-half",
)  # fmt: skip
STROKE = Sourced(
    value=142 * deg, unit="rad", source="flycontrol", certainty="C", text="142 deg",
    note="stroke amplitude peak to peak, within the published 140 to 145 deg",
)  # fmt: skip
DRAG_SLOPE = Sourced(
    value=0.92, unit="1", source="dickinson1999", certainty="S", text="0.92",
    note="at an attack angle of 45 deg; Eq. 5 has 1, which holds for a drag coefficient that goes with sin^2",
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopChain:
    """The chain and the two numbers that fix how the neural gains are shared out; their product alone matters."""

    chain: Chain
    gamma: float  #: paddling torque a paddling angle [N m/rad]
    omega: float  #: mean angular speed of the wings, twice the stroke amplitude a wingbeat [rad/s]


def loop_chain(loop: YawLoop, wingbeat_frequency: float, gamma: float | None = None) -> LoopChain:
    """gamma = beta C_D'/(2 C_D) omega.  Review, Eq. 2 and 5; the frequency is in 1/s.

    A gamma that was measured [N m/rad] takes the place of that estimate.
    """
    omega = 2.0 * STROKE.value * wingbeat_frequency
    if gamma is None:
        gamma = loop.plant.damping * DRAG_SLOPE.value * omega
    return LoopChain(chain=yaw_chain(loop, gamma, MU.value), gamma=gamma, omega=omega)

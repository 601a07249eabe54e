"""A fly ready to be simulated: its body and wings, the air, and what may move."""

from __future__ import annotations

from dataclasses import dataclass, field

from flycontrol.flight.multibody.freedoms import FREE, BodyFreedoms, Hinge
from flycontrol.flight.quasi_steady import QuasiSteadyModel
from flycontrol.model.morphology import GRAVITY, Morphology


@dataclass(frozen=True, slots=True, kw_only=True)
class FlappingFly:
    """Twelve degrees of freedom: body (six) and the stroke, deviation and pitch of each wing."""

    morphology: Morphology
    air: QuasiSteadyModel = field(default_factory=QuasiSteadyModel)
    body: BodyFreedoms = FREE
    left: Hinge = field(default_factory=Hinge)
    right: Hinge = field(default_factory=Hinge)
    gravity_W: tuple[float, float, float] = (0.0, 0.0, -GRAVITY)  #: [m/s^2]

"""Quasi-steady force and torque of two flapping wings on the fly, blade by blade, term by term.

A blade at r along the span moves through still air with

    u = v + w x (h + r e) + r (phi' cos(theta) e_phi + theta' e_theta),

v and w the body's velocity and angular velocity, h the hinge, e the span. Of u only the part across the span counts:
u_c along the chord, u_n along the chord's normal, and the attack angle a with tan a = |u_n| / |u_c|. Then

    dF = -1/2 rho c dr |u| (C_D(a) (u_c, u_n) + C_L(a) sign(u_c u_n) (-u_n, u_c)).

Everything is in the stroke-plane frame: x forward, y right, z down, torques about the centre of mass.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.flight.blades import BladeElements, planform_blades
from flycontrol.flight.coefficients import COEFFICIENTS
from flycontrol.flight.quasi_steady import QuasiSteadyModel
from flycontrol.model.morphology import Morphology
from flycontrol.model.stroke import Side, WingAxes, WingMotion, wing_axes

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyMotion:
    """Velocity of the centre of mass through still air and angular velocity, frame S, each (N, 3)."""

    velocity: FloatArray  #: [m/s]
    angular_velocity: FloatArray  #: roll, pitch, yaw rate [rad/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Load:
    """Force [N] and torque about the centre of mass [N m], frame S, each (N, 3)."""

    force: FloatArray
    torque: FloatArray

    def __add__(self, other: Load) -> Load:
        """Both act."""
        return Load(force=self.force + other.force, torque=self.torque + other.torque)


@dataclass(frozen=True, slots=True, kw_only=True)
class WingLoads:
    """Load of one wing, each term of the model by its name."""

    terms: Mapping[str, Load]

    @property
    def total(self) -> Load:
        """Sum of the terms."""
        return reduce(Load.__add__, self.terms.values())


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightLoads:
    """Loads of both wings."""

    left: WingLoads
    right: WingLoads

    @property
    def total(self) -> Load:
        """Sum over wings and terms."""
        return self.left.total + self.right.total


def flight_loads(
    morphology: Morphology,
    left: WingMotion,
    right: WingMotion,
    body: BodyMotion,
    model: QuasiSteadyModel | None = None,
    blades: BladeElements | None = None,
) -> FlightLoads:
    """Sum dF over the blades of both wings, for given wing and body motion.

    Parameters
    ----------
    morphology : the fly
    left, right : wing angles [rad] and rates [rad/s], arrays of shape (N,)
    body : velocity and angular velocity, arrays of shape (N, 3)
    model : coefficients, density and number of blades
    blades : blades of either wing, in place of those of the morphology's planform

    Raises
    ------
    InvalidInputError
        Wings and body were not given at equally many instants.
    """
    model = model or QuasiSteadyModel()
    if not len(left.stroke) == len(right.stroke) == len(body.velocity) == len(body.angular_velocity):
        raise InvalidInputError("Left wing, right wing and body must be given at the same instants.")
    if blades is None:
        blades = planform_blades(morphology.planform, model.nodes)
    hinge = np.array(morphology.right_hinge)
    return FlightLoads(
        left=WingLoads(terms=_terms(hinge * [1.0, -1.0, 1.0], "left", left, body, model, blades)),
        right=WingLoads(terms=_terms(hinge, "right", right, body, model, blades)),
    )


def _terms(
    hinge: FloatArray,
    side: Side,
    motion: WingMotion,
    body: BodyMotion,
    model: QuasiSteadyModel,
    blades: BladeElements,
) -> dict[str, Load]:
    axes = wing_axes(motion, side)
    velocity = _blade_velocity(hinge, axes, motion, body, blades.radius)
    along_chord = np.einsum("nmk,nk->nm", velocity, axes.chord)
    along_normal = np.einsum("nmk,nk->nm", velocity, axes.normal)
    chordwise, normalwise = _translational(along_chord, along_normal, blades.area, model)
    force = chordwise[..., None] * axes.chord[:, None] + normalwise[..., None] * axes.normal[:, None]
    arm = hinge + blades.radius[:, None] * axes.span[:, None]
    return {"translational": Load(force=force.sum(axis=1), torque=np.cross(arm, force).sum(axis=1))}


def _blade_velocity(
    hinge: FloatArray, axes: WingAxes, motion: WingMotion, body: BodyMotion, radius: FloatArray
) -> FloatArray:
    """U = v + w x h + r (w x e + e'), (N, m, 3) [m/s]."""
    sweep = (motion.stroke_rate * np.cos(motion.deviation))[:, None] * axes.forward
    tip = np.cross(body.angular_velocity, axes.span) + sweep + motion.deviation_rate[:, None] * axes.upward
    base = body.velocity + np.cross(body.angular_velocity, hinge)
    return base[:, None] + radius[:, None] * tip[:, None]


def _translational(
    u_c: FloatArray, u_n: FloatArray, area: FloatArray, model: QuasiSteadyModel
) -> tuple[FloatArray, FloatArray]:
    """-1/2 rho dS |u| (C_D (u_c, u_n) + C_L sign(u_c u_n) (-u_n, u_c)), each part (N, m) [N]."""
    attack = np.arctan2(np.abs(u_n), np.abs(u_c))  # a wing that moves backwards meets the air with its trailing edge
    lift, drag = COEFFICIENTS[model.coefficients](attack)
    lift = lift * np.sign(u_c * u_n)
    pressure = -0.5 * model.air_density * area * np.hypot(u_c, u_n)
    return pressure * (drag * u_c - lift * u_n), pressure * (drag * u_n + lift * u_c)

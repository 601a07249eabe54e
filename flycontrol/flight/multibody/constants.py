"""Numbers of a fly as the compiled dynamics wants them.

Blades are Gauss nodes for the chord; c^2 and c^3 keep the same nodes with weights that integrate them exactly against
polynomials of degree n - 1. Added mass and dissipation need no blades: they are moments of c^2 and c^4.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.blades import planform_blades
from flycontrol.flight.coefficient_series import coefficient_series
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.march import DAMPING, FREED, REST, STIFFNESS
from flycontrol.flight.multibody.freedoms import Hinge, Prescribed
from flycontrol.flight.quasi_steady import QuasiSteadyModel
from flycontrol.model.hinge import DampedSpring, SteeredSpring
from flycontrol.model.morphology import Morphology
from flycontrol.model.planform import Planform

FloatArray = NDArray[np.float64]

_LANES = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Constants:
    """Arrays for the kernels; left wing first."""

    joints: FloatArray  #: (2, 3, 4) free, stiffness, damping, rest angle
    free: FloatArray  #: (6,)
    gravity: FloatArray  #: (3,) in W [m/s^2]
    body: FloatArray  #: (10,) mass, inertia, right hinge
    wings: FloatArray  #: (2, 20)
    blades: FloatArray  #: (2, 4, n)
    polynomials: FloatArray  #: (5, k)

    @property
    def arguments(
        self,
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """In the kernels' order."""
        return (self.joints, self.free, self.gravity, self.body, self.wings, self.blades, self.polynomials)


def constants_of(fly: FlappingFly, frequency: float) -> Constants:
    """Pack a fly; the wingbeat frequency [1/s] enters the dissipative torque."""
    wing = wing_constants(fly.morphology, fly.air, frequency)
    blades = blade_rows(fly.morphology, fly.air)
    return Constants(
        joints=np.stack([_joints(fly.left), _joints(fly.right)]),
        free=fly.body.mask,
        gravity=np.array(fly.gravity_W),
        body=body_constants(fly.morphology),
        wings=np.stack([wing, wing]),
        blades=np.stack([blades, blades]),
        polynomials=_polynomials(fly.air),
    )


@lru_cache(maxsize=64)
def body_constants(morphology: Morphology) -> FloatArray:
    """(10,) mass of the body without wings, its inertia (xx, xy, xz, yy, yz, zz), the right hinge."""
    inertia = morphology.inertia_S
    mass = morphology.mass - 2 * morphology.wing_body.mass
    return np.array([mass, *inertia[np.triu_indices(3)], *morphology.right_hinge])


@lru_cache(maxsize=64)
def wing_constants(morphology: Morphology, air: QuasiSteadyModel, frequency: float) -> FloatArray:
    """(20,) mass and inertia, added mass, dissipation, centre of pressure, circulation of one wing.

    m22 = pi rho c^2 / 4 acts at x = (x0 - 1/2) c ahead of the pitch axis, I_a = pi rho c^4 / 128 about mid-chord.
    """
    wing, plan, x0 = morphology.wing_body, morphology.planform, morphology.pitch_axis
    added = np.pi / 4 * air.air_density * ("added_mass" in air.terms)
    viscous = np.pi / 16 * air.air_density * plan.moment(4) * ("dissipative" in air.terms)
    rotating = air.air_density * air.rotation(x0) * ("rotational" in air.terms)
    x = x0 - 0.5
    start, travel = air.centre_of_pressure
    return np.array([
        wing.mass, *wing.centre, wing.span_inertia, wing.chord_inertia, wing.normal_inertia, wing.product,
        added * plan.moment(2),
        added * x * plan.moment(3),
        -added * plan.moment(2, 1),
        added * (x**2 + 1 / 32) * plan.moment(4),
        -added * x * plan.moment(3, 1),
        added * plan.moment(2, 2),
        viscous * air.dissipation[0] * frequency,
        viscous * air.dissipation[1],
        x0 - (start + travel / 2),
        travel / 4,
        *(rotating * plan.moment(2, power) for power in range(3)),
    ])  # fmt: skip


@lru_cache(maxsize=64)
def blade_rows(morphology: Morphology, air: QuasiSteadyModel) -> FloatArray:
    """(4, n) radius and the weights of pressure, its arm, the circulation's arm (see `kernels.air`).

    Blades without area fill up the last group of four, which is computed at once: six cost less so than with two alone.
    """
    plan = morphology.planform
    steady = 0.5 * air.air_density * ("translational" in air.terms)
    rotating = air.air_density * air.rotation(morphology.pitch_axis) * ("rotational" in air.terms)
    radius, once, square, cube = _nodes_and_weights(plan, air.nodes)
    rows = np.array([radius, steady * once, steady * square, rotating * cube])
    return np.ascontiguousarray(np.pad(rows, ((0, 0), (0, -len(radius) % _LANES))))


@lru_cache(maxsize=64)
def _nodes_and_weights(plan: Planform, nodes: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Radii of the blades and their weights for c, c^2 and c^3."""
    radius = planform_blades(plan, nodes).radius
    return (radius, _weights(plan, radius, 1), _weights(plan, radius, 2), _weights(plan, radius, 3))


def _weights(plan: Planform, radius: FloatArray, chord_power: int) -> FloatArray:
    """Sum of w f(r) = integral of c^m f dr for polynomials f to degree n - 1, and 2 n - 1 on Gauss nodes (m = 1)."""
    x, count = 2 * radius / plan.length - 1, len(radius)
    moments = [plan.legendre_moment(chord_power, degree) for degree in range(count)]
    return np.asarray(np.linalg.solve(np.polynomial.legendre.legvander(x, count - 1).T, np.array(moments)), np.float64)


def _polynomials(air: QuasiSteadyModel) -> FloatArray:
    """Series of the coefficients, the last one scaled to the travel of the centre of pressure."""
    series = coefficient_series(air.coefficients).copy()
    series[-1] *= air.centre_of_pressure[1] / np.pi
    return series


def _joints(hinge: Hinge) -> FloatArray:
    rows = np.zeros((3, 4))
    for row, joint in zip(rows, hinge.joints, strict=True):
        row[FREED] = not isinstance(joint, Prescribed)
        if isinstance(joint, DampedSpring):
            row[[STIFFNESS, DAMPING, REST]] = joint.stiffness, joint.damping, joint.rest_angle
        if isinstance(joint, SteeredSpring):  # its rest angle comes with the stroke, as a torque of the drive
            row[[STIFFNESS, DAMPING]] = joint.stiffness, joint.damping
    return rows

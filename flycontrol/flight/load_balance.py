"""What a motion of the body needs against what air and wings supply, term by term.

    m (v' + w x v - g) = F_air + F_wings,    I w' + w x I w = N_air + N_wings

about the centre of mass of the body without its wings, in the stroke-plane frame; F_wings, N_wings are the reaction of
the wings' own mass: inertia and weight. The body's own drag is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.aerodynamics import Load
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.multibody.inverse import inverse_dynamics
from flycontrol.flight.quasi_steady import TERMS, VACUUM
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.trajectory import Trajectory, rotation_matrices
from flycontrol.model.wingbeats import Wingbeats, wingbeat_mean

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadBalance:
    """Both sides of Newton's and Euler's equations of the body, frame S, each (N, 3)."""

    required: Load  #: m (v' + w x v - g) and I w' + w x I w of the body without its wings
    air: Mapping[str, Load]  #: on both wings: translational, rotational, added_mass, dissipative
    wing_inertia: Load  #: reaction of the wings' inertia and weight

    @property
    def air_total(self) -> Load:
        """All that the air does."""
        return reduce(Load.__add__, self.air.values())

    @property
    def supplied(self) -> Load:
        """Air and wings."""
        return self.air_total + self.wing_inertia


def load_balance(fly: FlappingFly, trajectory: Trajectory) -> LoadBalance:
    """Required and supplied loads along a flight, simulated or measured; equal where the fly made the motion."""
    loads = loads_along(fly, trajectory)
    required = _required(fly, trajectory)
    # without air, what must act from outside is the body's need less what the wings' inertia does to it
    outside = inverse_dynamics(replace(fly, air=VACUUM), trajectory)
    return LoadBalance(
        required=required,
        air={term: loads.left.terms[term] + loads.right.terms[term] for term in TERMS},
        wing_inertia=Load(
            force=required.force - outside.body_force,
            torque=required.torque - outside.body_torque,
        ),
    )


def wingbeat_balance(balance: LoadBalance, trajectory: Trajectory, beats: Wingbeats) -> LoadBalance:
    """Mean of every load over each wingbeat, arrays of shape (beats.count, 3)."""
    return each_load(balance, lambda values: wingbeat_mean(values, trajectory.time, beats))


def world_balance(balance: LoadBalance, trajectory: Trajectory) -> LoadBalance:
    """The same loads in the world frame W, z up."""
    rotation = rotation_matrices(trajectory.q_WS)
    return each_load(balance, lambda values: np.einsum("nij,nj->ni", rotation, values))


def each_load(balance: LoadBalance, change: Callable[[FloatArray], FloatArray]) -> LoadBalance:
    """The balance with every force and torque (N, 3) passed through a linear operation."""

    def changed(load: Load) -> Load:
        return Load(force=change(load.force), torque=change(load.torque))

    return LoadBalance(
        required=changed(balance.required),
        air={term: changed(load) for term, load in balance.air.items()},
        wing_inertia=changed(balance.wing_inertia),
    )


def _required(fly: FlappingFly, trajectory: Trajectory) -> Load:
    inertia, spin = fly.morphology.inertia_S, trajectory.angular_velocity_S
    mass = fly.morphology.mass - 2 * fly.morphology.wing_body.mass
    gravity_S = np.einsum("nji,j->ni", rotation_matrices(trajectory.q_WS), np.array(fly.gravity_W))
    momentum = spin @ inertia.T
    return Load(
        force=mass * (trajectory.acceleration_S + np.cross(spin, trajectory.velocity_S) - gravity_S),
        torque=trajectory.angular_acceleration_S @ inertia.T + np.cross(spin, momentum),
    )

"""Inverse dynamics: the torques that a motion needs.

tau = M_qa v' + M_qw w' + M_qq q'' + t, gravity and air included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.inverse import generalised_forces
from flycontrol.flight.multibody.constants import constants_of
from flycontrol.flight.state_vector import samples_of
from flycontrol.model.trajectory import Trajectory

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RequiredForces:
    """What must act for a motion to be as it is, each (N, 3)."""

    body_force: FloatArray  #: from outside on the body, frame S; zero in free flight [N]
    body_torque: FloatArray  #: from outside on the body about its centre of mass, frame S; zero in free flight [N m]
    left_hinge: FloatArray  #: torques of stroke, deviation, pitch, of hinge and muscles on the wing [N m]
    right_hinge: FloatArray  #: the same, right wing [N m]


def inverse_dynamics(fly: FlappingFly, trajectory: Trajectory) -> RequiredForces:
    """Forces and torques behind a motion of body and wings, simulated or measured, with the fly's air and gravity.

    A hinge torque tau_k does the work tau_k q'_k on the wing; springs and dampers of the fly's hinges are not taken out
    of it: it is what hinge, muscles and springs do together.
    """
    samples, constants = samples_of(trajectory), constants_of(fly, trajectory.frequency)
    forces = np.empty((len(samples), 12))
    generalised_forces(
        samples,
        constants.gravity,
        constants.body,
        constants.wings,
        constants.blades,
        constants.polynomials,
        forces,
    )
    return RequiredForces(
        body_force=forces[:, :3], body_torque=forces[:, 3:6], left_hinge=forces[:, 6:9], right_hinge=forces[:, 9:]
    )

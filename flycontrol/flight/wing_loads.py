"""Force and torque of the air on both wings along a flight, term by term."""

from __future__ import annotations

import numpy as np

from flycontrol.flight.aerodynamics import FlightLoads, Load, WingLoads
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.inverse import wing_loads
from flycontrol.flight.multibody.constants import constants_of
from flycontrol.flight.quasi_steady import TERMS
from flycontrol.flight.state_vector import samples_of
from flycontrol.model.trajectory import Trajectory


def loads_along(fly: FlappingFly, trajectory: Trajectory) -> FlightLoads:
    """Each term of the fly's air on each wing, at the trajectory's instants, simulated or measured.

    Added mass needs the trajectory's accelerations; the other terms do not.

    Returns
    -------
    FlightLoads
        Per wing, `terms` maps translational, rotational, added_mass and dissipative to force [N] and torque about the
        body's centre of mass [N m], frame S, each (N, 3). Terms that the model leaves out are zero.
    """
    samples, constants = samples_of(trajectory), constants_of(fly, trajectory.frequency)
    loads = np.empty((len(samples), 2, len(TERMS), 6))
    wing_loads(samples, constants.body, constants.wings, constants.blades, constants.polynomials, loads)
    left, right = (
        WingLoads(
            terms={
                term: Load(force=loads[:, side, k, :3].copy(), torque=loads[:, side, k, 3:].copy())
                for k, term in enumerate(TERMS)
            }
        )
        for side in (0, 1)
    )
    return FlightLoads(left=left, right=right)

"""What a few blades a wing get wrong, by repeating a wingbeat's loads with many."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.trajectory import QuadratureError, Trajectory

_MANY = 64  #: blades


def estimate_quadrature_error(fly: FlappingFly, wingbeat: Trajectory) -> QuadratureError | None:
    """Compare the fly's blades with many at the instants of one wingbeat, its end not among them.

    None when the wingbeat was not flown to its end.
    """
    if len(wingbeat.time) < wingbeat.samples_per_wingbeat:
        return None
    few = loads_along(fly, wingbeat).total
    many = loads_along(replace(fly, air=replace(fly.air, nodes=_MANY)), wingbeat).total
    weight, length = fly.morphology.weight, fly.morphology.wing_length
    force = (few.force - many.force) / weight
    torque = (few.torque - many.torque) / (weight * length)
    return QuadratureError(
        force=float(np.max(np.linalg.norm(force, axis=1))),
        torque=float(np.max(np.linalg.norm(torque, axis=1))),
        mean_force=float(np.linalg.norm(force.mean(axis=0))),
        mean_torque=float(np.linalg.norm(torque.mean(axis=0))),
    )

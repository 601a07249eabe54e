"""What a few blades a wing get wrong, by repeating a wingbeat's loads with many."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.trajectory import Trajectory

_MANY = 64  #: blades


@dataclass(frozen=True, slots=True, kw_only=True)
class QuadratureError:
    """Of the air's load on both wings: the largest, and that of the mean, with few blades less with many."""

    force: float  #: largest at any instant, over the weight
    torque: float  #: largest at any instant, over weight times wing length
    mean_force: float  #: over the weight
    mean_torque: float  #: over weight times wing length


def estimate_quadrature_error(fly: FlappingFly, wingbeat: Trajectory) -> QuadratureError:
    """Compare the fly's blades with many, along one wingbeat; its last instant is not counted twice."""
    few = loads_along(fly, wingbeat).total
    many = loads_along(replace(fly, air=replace(fly.air, nodes=_MANY)), wingbeat).total
    weight, length = fly.morphology.weight, fly.morphology.wing_length
    force = (few.force - many.force)[: wingbeat.samples_per_wingbeat] / weight
    torque = (few.torque - many.torque)[: wingbeat.samples_per_wingbeat] / (weight * length)
    return QuadratureError(
        force=float(np.max(np.linalg.norm(force, axis=1))),
        torque=float(np.max(np.linalg.norm(torque, axis=1))),
        mean_force=float(np.linalg.norm(force.mean(axis=0))),
        mean_torque=float(np.linalg.norm(torque.mean(axis=0))),
    )

"""Yaw torque of the eight versions of a wing motion, some of its angles symmetrised.  Review, section 4 and Fig. 4.

Torque is about the normal of the stroke plane through the centre of mass, > 0 to the right: of the air (all terms) for
a body that is held, of air and wings' inertia where the body moves as it was measured.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.flight_record import one_after_another
from flycontrol.flight.load_balance import load_balance
from flycontrol.flight.state_vector import LEVEL
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.symmetrised import VERSIONS, symmetrised
from flycontrol.model.trajectory import Trajectory
from flycontrol.model.wingbeats import Wingbeats, wingbeat_mean
from flycontrol.reduce.steady_turn import steady_turn

FloatArray = NDArray[np.float64]

_YAW = 2
_INSTANTS = 200  #: of a repeating wingbeat


def torques_of_stroke(fly: FlappingFly, stroke: StrokeKinematics, instants: int = _INSTANTS) -> FloatArray:
    """Mean yaw torque over a wingbeat of a stroke that repeats, body held, (8,) in the order of `VERSIONS` [N m].

    The wings' inertia adds nothing: its mean over a periodic motion of a held body vanishes.
    """
    held = steady_turn(stroke, np.zeros(3), instants)
    versions = one_after_another([symmetrised(held, kept) for kept in VERSIONS])
    return loads_along(fly, versions).total.torque[:, _YAW].reshape(len(VERSIONS), instants).mean(axis=1)


def torques_by_wingbeat(fly: FlappingFly, trajectory: Trajectory, beats: Wingbeats) -> FloatArray:
    """Mean yaw torque of each wingbeat of a flight, body as it moves, (n, 8) in the order of `VERSIONS` [N m].

    Version 0, mirror-symmetric wings, has the torque of the body's own motion: mostly its damping. For a body at rest
    hand over `at_rest(trajectory)`.
    """
    versions = [load_balance(fly, symmetrised(trajectory, kept)).supplied.torque[:, _YAW] for kept in VERSIONS]
    return wingbeat_mean(np.stack(versions, axis=1), trajectory.time, beats)


def at_rest(trajectory: Trajectory) -> Trajectory:
    """The same wing motion on a level body that neither flies nor turns."""
    nothing = np.zeros_like(trajectory.velocity_S)
    return replace(
        trajectory,
        position_W=nothing,
        q_WS=np.tile(LEVEL, (len(nothing), 1)),
        velocity_S=nothing,
        angular_velocity_S=nothing,
        acceleration_S=nothing,
        angular_acceleration_S=nothing,
    )

"""How far a fly turns with the eight versions of a wing motion: they are flown, yaw alone free.  Review, Fig. 4."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.multibody.freedoms import YAW_ONLY, Hinge
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.symmetrised import VERSIONS, symmetrised
from flycontrol.model.trajectory import Trajectory, wing_angles
from flycontrol.model.wing_stroke import SampledStroke

FloatArray = NDArray[np.float64]


def turn_angles(fly: FlappingFly, trajectory: Trajectory, settings: MarchSettings | None = None) -> FloatArray:
    """Change of heading over the whole wingbeats of a flight from rest, (8,) in the order of `VERSIONS` [rad].

    Wings follow the flight's angles, whatever moved them there; the body stays level where it is and is free to yaw.
    """
    settings = settings or MarchSettings(estimate_error=False)
    tethered = replace(fly, body=YAW_ONLY, left=Hinge(), right=Hinge())
    return np.array([_turn(tethered, symmetrised(trajectory, kept), settings) for kept in VERSIONS])


def _turn(fly: FlappingFly, trajectory: Trajectory, settings: MarchSettings) -> float:
    phase = trajectory.phase - trajectory.phase[0]
    left, right = (
        SampledStroke(phase=phase, samples=wing_angles(trajectory.wing(side)), periodic=False)
        for side in ("left", "right")
    )
    stroke = StrokeKinematics(frequency=trajectory.frequency, left=left, right=right)
    heading = simulate_flight(fly, stroke, int(phase[-1] + 1e-9), settings=settings).yaw
    return float(heading[-1] - heading[0])

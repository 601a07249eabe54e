"""Symmetrised wing motion flown anew."""

from dataclasses import replace

import numpy as np
import pytest
from reduced_fly import FLY, wiggling

from flycontrol.flight.multibody.freedoms import YAW_ONLY
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.model.wing_stroke import Modulation
from flycontrol.reduce.factorial import Factorial
from flycontrol.reduce.symmetrised_torque import torques_of_stroke
from flycontrol.reduce.symmetrised_turn import turn_angles
from flycontrol.units import deg

STROKE = (
    wiggling().kinematics.modulated(
        Modulation(deviation_offset=3 * deg, pitch_offset=-4 * deg),
        Modulation(deviation_offset=-3 * deg, pitch_offset=4 * deg),
    )
)  # fmt: skip


@pytest.fixture(scope="module")
def turns():
    flown = simulate_flight(
        replace(FLY, body=YAW_ONLY), STROKE, 6, settings=MarchSettings(steps=200, samples=100, estimate_error=False)
    )
    return flown, turn_angles(FLY, flown)


def test_the_motion_as_it_was_turns_the_fly_as_it_did(turns):
    """Quintic splines through 100 samples a wingbeat."""
    flown, angles = turns
    assert abs(angles[-1] / (flown.yaw[-1] - flown.yaw[0]) - 1) < 1e-4


def test_a_fly_with_mirror_symmetric_wings_does_not_turn(turns):
    assert abs(turns[1][0]) < 1e-9 * abs(turns[1][-1])


def test_the_turn_is_shared_like_the_torque_that_makes_it(turns):
    """psi is linear in the torque but for what the wings' asymmetry changes of the damping, and the first wingbeat."""
    turn, torque = (Factorial(values=v) for v in (turns[1], torques_of_stroke(FLY, STROKE)))
    assert np.allclose(turn.shapley / turn.total, torque.shapley / torque.total, rtol=0, atol=0.02)

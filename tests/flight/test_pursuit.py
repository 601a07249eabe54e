"""A simulated fly steered after wanted rates."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_fly import FLY, SYMMETRIC, rms

from flycontrol.errors import InvalidInputError
from flycontrol.flight.multibody.freedoms import BodyFreedoms
from flycontrol.flight.pursuit import pursued_flight
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import level_start

TURNING = replace(FLY, body=BodyFreedoms(forward=False, sideways=False, down=False))
START = level_start(SYMMETRIC)
QUICK = MarchSettings(steps=100, samples=20, estimate_error=False)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_pursuing_fly_turns_as_wanted_and_hardly_about_the_other_axes(axis):
    """One slow swing over twenty wingbeats, after four to settle."""
    wanted = np.zeros((25, 3))
    wanted[4:, axis] = 10 * np.sin(2 * np.pi * np.arange(21) / 20)
    flown = pursued_flight(TURNING, SYMMETRIC, wanted, START, QUICK).angular_velocity_S[:: QUICK.samples]
    assert rms((flown - wanted)[4:, axis]) < 0.25 * rms(wanted[4:, axis])
    assert rms(np.delete((flown - wanted)[4:], axis, axis=1)) < 0.25 * rms(wanted[4:, axis])


def test_what_cannot_be_followed_is_said():
    with pytest.raises(InvalidInputError, match="shape"):
        pursued_flight(TURNING, SYMMETRIC, np.zeros((5, 2)), START)
    on_a_tether = replace(FLY, body=BodyFreedoms(yaw=False))
    with pytest.raises(InvalidInputError, match="cannot be steered"):
        pursued_flight(on_a_tether, SYMMETRIC, np.zeros((5, 3)), START)

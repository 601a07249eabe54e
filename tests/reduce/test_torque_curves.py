"""Where the yaw torque leaves its straight line, in closed form and in flight."""

import numpy as np
import pytest
from reduced_fly import hover, sweeping

from flycontrol.errors import InvalidParameterError
from flycontrol.reduce.torque_curves import damping_curve, paddling_curve
from flycontrol.units import deg


def test_a_sweeping_plate_has_the_cubic_part_of_its_reversals():
    """2 f psi'^2 / (3 |phi''| <|phi'|>) = (psi' / largest phi')^2 / 6 for a sine; the next power is left out."""
    plate = sweeping(pitch_shape=0.01, pitch_amplitude=0.0, terms=("translational",))
    largest = 70 * deg * 2 * np.pi * 220.0
    found = damping_curve(plate, np.linspace(0.02, 0.24, 12) * largest)
    assert found.share_of_cubic(0.1 * largest) == pytest.approx(0.01 / 6, rel=0.01)


def test_yaw_damping_is_linear_beyond_any_rate_of_turning_and_paddling_to_15_deg():
    """sin(2.04 a) / (2.04 a) = 0.95, the cosine in C_D, at a = 15.5 deg."""
    damping, paddling = damping_curve(hover()), paddling_curve(hover())
    assert damping.linear_range > 300  # [rad/s]; the fastest turns of the real flights reach 60
    assert abs(damping.share_of_cubic(60.0)) < 1e-3
    assert paddling.leaves
    square = paddling_curve(sweeping(terms=("translational",)))
    assert square.linear_range == pytest.approx(15.50 * deg, rel=3e-3)
    assert paddling.linear_range == pytest.approx(square.linear_range, rel=0.02)


def test_paddling_loses_torque_by_the_cube_that_the_cosine_in_drag_has():
    """(2.04 a)^2 / 6, from angles small enough for its first power."""
    found = paddling_curve(sweeping(terms=("translational",)), np.linspace(0.5, 4.5, 9) * deg)
    assert found.share_of_cubic(3 * deg) == pytest.approx(-((2.04 * 3 * deg) ** 2) / 6, rel=5e-3)


def test_inputs_that_make_no_curve_are_refused():
    with pytest.raises(InvalidParameterError, match="at least three rising inputs > 0"):
        damping_curve(hover(), [0.0, 1.0, 2.0])

"""Mean yaw torque of a fly that turns and paddles: symmetry, dimensions, and what other routes say."""

from dataclasses import replace

import numpy as np
import pytest
from reduced_fly import FLY, MELANOGASTER, STEADY, derivatives, hover, trim, wiggling

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.yaw_coefficients import yaw_coefficients
from flycontrol.model.wing_stroke import ModulatedStroke, Modulation
from flycontrol.reduce.yaw_torque import YawExperiment, slopes_error, yaw_slopes
from flycontrol.units import deg


@pytest.mark.parametrize("experiment", [hover, wiggling])
def test_turning_is_damped_and_paddling_to_the_right_turns_right(experiment):
    found = yaw_slopes(experiment())
    assert found.damping > 0
    assert found.paddling > 0


def test_the_mirror_image_flips_the_torque_and_a_symmetric_stroke_has_none():
    fly = wiggling()
    torque = fly.torque(yaw_rate=30.0, d_alpha=5 * deg)
    assert fly.torque(yaw_rate=-30.0, d_alpha=-5 * deg) == pytest.approx(-torque, rel=1e-9)
    assert abs(fly.torque()) < 1e-12 * abs(torque)


def test_torque_goes_with_the_fifth_power_of_length():
    """Length cubed by area and arm, squared by speed."""
    m, once = MELANOGASTER, yaw_slopes(wiggling())
    larger = replace(
        m,
        wing_length=1.3 * m.wing_length,
        mean_chord=1.3 * m.mean_chord,
        right_hinge=tuple(1.3 * x for x in m.right_hinge),
    )
    scaled = yaw_slopes(wiggling(larger))
    assert scaled.damping == pytest.approx(1.3**5 * once.damping, rel=1e-9)
    assert scaled.paddling == pytest.approx(1.3**5 * once.paddling, rel=1e-9)


def test_damping_goes_with_frequency_and_paddling_with_its_square():
    """Exactly, since all that a quasi-steady air does is a velocity squared or an acceleration."""
    once, faster = yaw_slopes(wiggling()), yaw_slopes(wiggling(frequency=1.5 * 220.0))
    assert faster.damping == pytest.approx(1.5 * once.damping, rel=1e-9)
    assert faster.paddling == pytest.approx(1.5**2 * once.paddling, rel=1e-9)
    assert faster.turn_gain == pytest.approx(1.5 * once.turn_gain, rel=1e-9)


def test_a_hinge_higher_on_the_body_changes_nothing():
    """The arm of a yaw torque and the velocity of a yawing blade lie in the stroke plane."""
    ahead, side, below = MELANOGASTER.right_hinge
    raised = yaw_slopes(wiggling(replace(MELANOGASTER, right_hinge=(ahead, side, below - 1e-3))))
    once = yaw_slopes(wiggling())
    assert raised.damping == pytest.approx(once.damping, rel=1e-9)
    assert raised.paddling == pytest.approx(once.paddling, rel=1e-9)


def test_damping_is_that_of_the_stroke_averaged_derivatives_about_any_axis():
    """n D n of their matrix, within the error that they state."""
    matrix, error = derivatives().matrix[3:, 3:], derivatives().error[3:, 3:]
    for tilt in (0.0, -10 * deg, 20 * deg):
        axis = np.array([-np.sin(tilt), 0.0, np.cos(tilt)])
        found = yaw_slopes(replace(hover(), axis_S=tuple(axis)))
        bound = np.abs(axis) @ error @ np.abs(axis)
        assert abs(found.damping + axis @ matrix @ axis) < bound
        assert bound < 1e-3 * found.damping


def test_paddling_and_damping_are_those_of_the_blade_elements_with_arctangents():
    translating = replace(FLY, air=STEADY)
    motion, _ = trim().kinematics.motion((np.arange(2000) + 0.5) / 2000, "right")
    blades = yaw_coefficients(MELANOGASTER, motion, np.zeros(3))
    found = yaw_slopes(YawExperiment(fly=translating, kinematics=trim().kinematics))
    assert found.damping == pytest.approx(blades.damping, rel=2e-5)
    assert found.paddling == pytest.approx(blades.paddling, rel=2e-5)


def test_translation_makes_almost_all_of_both_in_the_built_in_hover():
    """Rotation and dissipation go with the pitch rate, which a fore-aft symmetric stroke has alike on both halves."""
    found = yaw_slopes(hover())
    assert found.damping_by_term["translational"] == pytest.approx(found.damping, rel=1e-3)
    assert found.paddling_by_term["translational"] == pytest.approx(found.paddling, rel=1e-3)
    damping, paddling = slopes_error(hover())
    assert damping < 1e-4 * found.damping
    assert paddling < 1e-4 * found.paddling


def test_a_stroke_that_changes_between_wingbeats_is_refused():
    stroke = trim().kinematics
    ramped = replace(stroke, right=ModulatedStroke(stroke=stroke.right, after=Modulation(stroke_gain=0.1)))
    with pytest.raises(InvalidParameterError, match="give a periodic one"):
        YawExperiment(fly=FLY, kinematics=ramped)
    with pytest.raises(InvalidParameterError, match="unit vector"):
        YawExperiment(fly=FLY, kinematics=stroke, axis_S=(0.0, 0.0, 2.0))


def test_a_torque_that_is_none_and_half_an_instant_are_refused():
    for asked in ({"yaw_rate": float("nan")}, {"d_alpha": float("inf")}):
        with pytest.raises(InvalidParameterError, match="finite yaw rate and paddling angle"):
            hover().torque(**asked)
    for instants in (2000.5, 3, "2000"):
        with pytest.raises(InvalidParameterError, match="whole number of at least 100, got"):
            replace(hover(), instants=instants)

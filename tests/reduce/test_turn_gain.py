"""gamma/beta taken apart: each factor against its closed form, and all of them against the measured slope."""

import numpy as np
import pytest
from reduced_fly import MELANOGASTER, fry_hover, hover, hydei_wingbeat, sweeping, wiggling

from flycontrol.errors import InvalidParameterError
from flycontrol.model.wing_stroke import BermanWangStroke
from flycontrol.reduce.turn_gain import drag_slope, turn_gain
from flycontrol.reduce.yaw_torque import YawExperiment
from flycontrol.units import deg


def test_at_constant_speed_with_square_pitch_and_the_hinge_on_the_axis_eq_5_holds_with_the_slope_of_drag():
    """gamma/beta = omega C_D' / (2 C_D), within 2 % already where reversals take a hundredth of the wingbeat."""
    found = turn_gain(sweeping(stroke_shape=0.999, pitch_shape=10.0))
    assert found.ratio == pytest.approx(found.ideal, rel=0.02)
    limit = turn_gain(sweeping(stroke_shape=0.9999, pitch_shape=100.0))
    assert limit.ratio == pytest.approx(limit.ideal, rel=0.005)
    assert limit.ratio == pytest.approx(0.92 * limit.speeds.mean, rel=0.005)


@pytest.mark.parametrize("attack", [25, 30, 45, 60])
def test_eq_5_with_the_slope_of_drag_holds_at_other_attack_angles_where_reversals_are_sharp(attack):
    """A wing pitched 90 deg less the attack angle to either side; slow reversals cost 3 to 5 % below 45 deg."""
    found = turn_gain(sweeping(stroke_shape=0.9999, pitch_shape=100.0, pitch_amplitude=(90 - attack) * deg))
    assert found.attack == pytest.approx(attack * deg, rel=0.01)
    assert found.ratio == pytest.approx(found.ideal, rel=0.02)


@pytest.mark.parametrize("experiment", [hover, wiggling])
def test_the_factors_multiply_up_to_the_measured_ratio(experiment):
    found = turn_gain(experiment())
    assert found.product == pytest.approx(found.ratio, rel=1e-12)


def test_the_factors_of_measured_wingbeats_multiply_up_too(real_data):
    for experiment in (fry_hover(real_data), hydei_wingbeat(real_data)):
        found = turn_gain(experiment)
        assert found.product == pytest.approx(found.ratio, rel=1e-12)
        assert 0.75 < found["hinge to the side"].factor < 0.9
        assert found["waveform"].factor > 1.2


def test_the_waveform_of_a_sine_gives_pi_squared_over_eight_and_none_with_the_speed_that_drag_sees():
    """The factor <phi'^2> / <|phi'|>^2: how much drag favours the fast part of the stroke."""
    found = turn_gain(sweeping(terms=("translational",)))
    assert found["waveform"].factor == pytest.approx(np.pi**2 / 8, rel=1e-4)
    assert found.speeds.by_drag * found.drag_slope == pytest.approx(found.ideal * found["waveform"].factor, rel=1e-4)
    measured = turn_gain(wiggling())
    assert measured["waveform"].factor == pytest.approx(measured.speeds.by_drag / measured.speeds.mean, rel=1e-4)


def test_a_hinge_to_the_side_lowers_the_ratio_as_the_moments_of_the_wing_say():
    """gamma by r^2 (r + y cos phi) phi'^2, beta by r (r + y cos phi)^2 |phi'|: the hinge's own speed and arm."""
    experiment = sweeping(morphology=MELANOGASTER, terms=("translational",))
    motion, _ = experiment.kinematics.motion((np.arange(20000) + 0.5) / 20000, "right")
    plan = MELANOGASTER.planform
    first, second, third = (plan.moment(1, power) for power in (1, 2, 3))
    y, speed = MELANOGASTER.right_hinge[1] * np.cos(motion.stroke), np.abs(motion.stroke_rate)
    gain = np.mean(speed**2 * (third + y * second)) / (third * np.mean(speed**2))
    damping = np.mean(speed * (third + 2 * y * second + y**2 * first)) / (third * np.mean(speed))
    assert turn_gain(experiment)["hinge to the side"].factor == pytest.approx(gain / damping, rel=2e-3)


def test_parts_that_a_wing_lacks_leave_the_ratio_alone():
    found = turn_gain(sweeping())
    for name in ("deviation", "hinge to the side", "hinge ahead"):
        assert found[name].factor == pytest.approx(1.0, abs=1e-12)
    assert [one.name for one in turn_gain(sweeping(terms=("translational",))).factors][-1] == "hinge ahead"


def test_the_slope_of_drag_is_092_at_45_deg_and_1_for_a_drag_like_sine_squared():
    """C_D = 1.92 - 1.55 cos(2.04 a - 9.82 deg); and 0.79 of Whitney & Wood's, 3 / 3.8."""
    argument = (2.04 * 45 - 9.82) * deg
    closed = 2.04 * 1.55 * np.sin(argument) / (2 * (1.92 - 1.55 * np.cos(argument)))
    assert drag_slope("dickinson1999", 45 * deg) == pytest.approx(closed, rel=1e-6)
    assert drag_slope("dickinson1999", 45 * deg) == pytest.approx(0.92, abs=0.005)
    assert drag_slope("whitney2010", 45 * deg) == pytest.approx(3 / 3.8, rel=1e-6)


def test_the_mean_speed_of_a_stroke_is_twice_its_span_a_wingbeat():
    found = turn_gain(hover()).speeds
    experiment: YawExperiment = hover()
    stroke = experiment.kinematics.right
    assert isinstance(stroke, BermanWangStroke)
    assert found.mean == pytest.approx(4 * stroke.stroke_amplitude * experiment.kinematics.frequency, rel=1e-5)
    assert found.mean < found.rms < found.by_drag < found.largest


def test_a_factor_that_is_not_there_is_refused_with_the_names_of_those_that_are():
    with pytest.raises(InvalidParameterError, match="No factor is named 'nothing'; there are waveform, pitch"):
        turn_gain(sweeping())["nothing"]

"""Intervals from the profile likelihood, where those from the covariance are false."""

import numpy as np
import pytest
from perturbed_fly import AT_REST, TRUTH, recording

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.least_squares import minimise
from flycontrol.identify.gains.model import Unknown, gain_model

NEARLY_FLAT = {"kp": 3000.0, "kd": 0.0, "delay": 0.005, "damping": 150.0, "impulse": 35.0}


@pytest.fixture(scope="module")
def flat():
    """A fly without derivative gain and with a short delay: K_D and the delay do the same to first order."""
    return fit_gains([recording(1, truth=NEARLY_FLAT)], gain_model(fixed=AT_REST))


@pytest.fixture(scope="module")
def usual():
    return fit_gains([recording(0)], gain_model(fixed=AT_REST))


def deviance_at(found, name, value):
    """The lowest deviance over the other unknowns, by searches from the ends of the ridge and from the minimum."""
    i = found.problem.names.index(name)
    best = np.inf
    for start in (found.minimum.x, *found.profile(name).ridge[[0, -1]]):
        x = start.copy()
        x[i] = value
        best = min(best, minimise(found.weighted, x, most_steps=200, scale=1.0, fixed=(i,)).at.cost)
    return best - found.minimum.at.cost


@pytest.mark.parametrize("name", ["kp", "kd", "delay", "damping", "impulse[fly]", "heading[fly]"])
def test_at_the_ends_of_an_interval_the_deviance_is_students_t_squared(usual, name):
    found = usual.profile(name)
    for end in (found.low, found.high):
        assert deviance_at(usual, name, end) == pytest.approx(found.threshold, rel=4e-3)


def test_where_yaw_is_linear_in_the_unknowns_the_profile_is_the_covariance():
    known = {k: v for k, v in TRUTH.items() if k != "impulse"}
    found = fit_gains([recording(3)], gain_model(fixed=known))
    for estimate in found.estimates:
        profile = found.profile(estimate.name)
        assert (profile.low, profile.high) == pytest.approx((estimate.low, estimate.high), rel=1e-9)
        assert estimate.method == "linear"


def test_usual_recordings_keep_linear_intervals_and_profiles_agree_with_them(usual):
    for estimate in usual.estimates:
        profile, width = usual.profile(estimate.name), estimate.high - estimate.low
        assert estimate.method == "linear"
        assert abs(profile.low - estimate.low - estimate.bias) < 0.05 * width
        assert abs(profile.high - estimate.high - estimate.bias) < 0.05 * width


def test_a_delay_that_the_data_do_not_bound_below_has_an_open_interval_and_its_reason(flat):
    delay = flat["delay"]
    linear_low = flat.minimum.x[2] - 1.97 * delay.standard_error
    assert linear_low > 0.009  # the covariance claims to know better
    assert delay.method == "profile"
    assert delay.low == -np.inf
    assert delay.open_because == "the likelihood stays above the threshold down to the bound of 0.001 s"
    assert deviance_at(flat, "delay", 0.0012) < flat.profile("delay").threshold


def test_an_interval_holds_every_value_that_another_profile_met_below_the_threshold(flat):
    for walked in ("kd", "delay"):
        profile = flat.profile(walked)
        for i, estimate in enumerate(flat.estimates):
            if estimate.method == "profile":
                inside = profile.ridge[profile.deviance < flat.profile(estimate.name).threshold, i]
                assert estimate.low <= inside.min()
                assert inside.max() <= estimate.high


def test_an_unknown_at_its_bound_has_an_interval_on_one_side():
    model = gain_model(fixed=AT_REST, settings={"damping": Unknown(low=75.0)})
    found = fit_gains([recording(0)], model)
    damping = found["damping"]
    assert damping.at_bound
    assert (damping.value, damping.low) == (75.0, -np.inf)
    assert 75.0 < damping.high < 80.0
    assert "down to the bound of 75 1/s" in damping.open_because
    assert np.isfinite([found["kp"].low, found["kp"].high]).all()


def test_an_unknown_name_is_refused(usual):
    with pytest.raises(InvalidParameterError, match="No unknown is named 'gain'"):
        usual.profile("gain")

"""What a fit says where the data say little: nothing visible, no response, trade-offs, something wrongly held."""

import re
from dataclasses import replace

import numpy as np
import pytest
from perturbed_fly import AT_REST, PULSE, TIMES, TRUTH, recording

from flycontrol.identify.gains.design import expected_covariance, trade_offs
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.least_squares import minimise
from flycontrol.identify.gains.model import Unknown, gain_model
from flycontrol.identify.gains.response import yaw_response
from flycontrol.identify.gains.score import score_tests
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg, ms

MODEL = gain_model(fixed=AT_REST)
KNOWN_DAMPING = gain_model(fixed=AT_REST | {"damping": 69.0})


@pytest.fixture(scope="module")
def found():
    return fit_gains([recording(0)], MODEL)


def test_noise_alone_shows_no_perturbation():
    noise = 0.3 * deg * np.random.default_rng(0).standard_normal(801)
    still = Trial(name="still", time=TIMES, yaw=noise, rate=8000.0, perturbation=PULSE)
    found = fit_gains([still], KNOWN_DAMPING)
    assert found.status.startswith("no perturbation visible")
    assert (found["kp"].low, found["kp"].high) == (-np.inf, np.inf)
    assert found["kp"].open_because == "no perturbation visible"


def test_a_fly_without_control_shows_no_response():
    drifting = recording(0, truth=TRUTH | {"kp": 0.0, "kd": 0.0})
    assert fit_gains([drifting], KNOWN_DAMPING).status.startswith("no response found")


def test_a_usual_recording_converges_and_says_no_more(found):
    assert found.status == "converged: one minimum inside all bounds."


def test_an_interval_too_wide_for_use_is_not_identifiable():
    flat = {"kp": 3000.0, "kd": 0.0, "delay": 0.005, "damping": 150.0, "impulse": 35.0}
    status = fit_gains([recording(1, truth=flat)], MODEL).status
    assert status.startswith("not identifiable: the intervals are too wide for use, kd from")
    assert "the likelihood stays above the threshold down to the bound of 0.001 s" in status


def test_an_upper_bound_that_the_data_push_against_is_named_and_leaves_one_open_side():
    model = gain_model(fixed=AT_REST | {"damping": 69.0}, settings={"delay": Unknown(low=5 * ms, high=10 * ms)})
    found = fit_gains([recording(0)], model)
    delay = found["delay"]
    assert found.status.startswith("at a bound: the best delay lies at your upper bound of 10 ms; widen it")
    assert "not identifiable" not in found.status
    assert delay.at_bound
    assert 9 * ms < delay.low < 10 * ms  # far closer than the 5 ms down to the other bound, which the data exclude
    assert delay.high == np.inf


def test_what_a_bound_rules_out_does_not_make_an_interval_too_wide():
    """The data leave a half millisecond on either side; the bound cuts the upper part of it."""
    free = fit_gains([recording(0)], KNOWN_DAMPING)["delay"]
    bound = {"delay": Unknown(low=1 * ms, high=free.value + 0.2 * (free.high - free.value))}
    found = fit_gains([recording(0)], gain_model(fixed=AT_REST | {"damping": 69.0}, settings=bound))
    assert found.status.startswith("converged")


def test_a_limit_that_no_torque_reaches_is_said_by_name_with_the_least_that_it_can_be():
    """The strongest torque of the fly below is 2,000 1/s^2; tanh of it departs by 1 % at a sixth of a limit."""
    found = fit_gains([recording(2)], gain_model(fixed=AT_REST | {"damping": 69.0}, estimate=["limit"]))
    limit = found["limit"]
    assert found.status.startswith("converged: one minimum inside all bounds. limit is not determined: the torque")
    assert (limit.value, limit.high) == (np.inf, np.inf)
    t = 1.97
    for value, sign in ((0.97 * limit.low, 1), (1.03 * limit.low, -1)):
        at = found.minimum.x.copy()
        at[found.problem.names.index("limit")] = value
        there = minimise(found.weighted, at, scale=1.0, fixed=[found.problem.names.index("limit")])
        assert sign * (there.at.cost - found.minimum.at.cost - t**2) > 0
    plain = fit_gains([recording(2)], KNOWN_DAMPING)
    for name in ("kp", "kd", "delay"):  # as if the limit had not been asked for
        assert found[name].value == pytest.approx(plain[name].value, abs=0.05 * plain[name].standard_error)
        assert found[name].standard_error == pytest.approx(plain[name].standard_error, rel=0.02)


@pytest.mark.parametrize(
    ("model", "freed"),
    [
        (gain_model("P", fixed=AT_REST | {"damping": 69.0, "delay": TRUTH["delay"]}), "kd"),
        (gain_model(fixed=AT_REST | {"delay": 8 * ms}), "delay"),
    ],
)
def test_a_wrong_controller_or_delay_is_not_taken_for_a_wrong_onset(model, freed):
    status = fit_gains([recording(0)], model).status
    assert "came at another time" not in status
    assert re.search(f"either the .* or the model is wrong .*; a free {freed} removes more of the misfit", status)


def test_an_onset_that_explains_more_than_any_freed_parameter_is_asserted():
    late = replace(recording(0, noise=0.1, perturbation=Pulse(onset=12 * ms, duration=4.5 * ms)), perturbation=PULSE)
    status = fit_gains([late], MODEL).status
    assert "the perturbation came at another time than recorded" in status
    assert "It removes more of the misfit than" in status


def test_a_fly_that_turned_before_the_onset_is_noticed():
    turning = recording(0, truth=TRUTH | {"initial_rate": 1.0})
    found = fit_gains([turning], KNOWN_DAMPING)
    tests = score_tests(found.weighted, found.minimum, found.uncertainty)
    assert min(test.p for test in tests if test.kind == "initial_rate") < 1e-4
    assert "score test" in found.status


def test_an_onset_a_millisecond_off_is_noticed_and_measured():
    late = replace(recording(0, perturbation=Pulse(onset=11 * ms, duration=4.5 * ms)), perturbation=PULSE)
    found = fit_gains([late], KNOWN_DAMPING)
    first = score_tests(found.weighted, found.minimum, found.uncertainty)[0]
    assert first.kind == "onset_shift"
    assert first.expected == pytest.approx(1 * ms, rel=0.3)  # one step of Newton's
    assert "estimate onset_shift" in found.status


def test_p_values_of_score_tests_are_uniform_where_nothing_was_wrong():
    p = []
    for seed in range(60):
        found = fit_gains([recording(seed)], KNOWN_DAMPING)
        p += [t.p for t in score_tests(found.weighted, found.minimum, found.uncertainty) if t.kind == "initial_rate"]
    assert min(p) > 3e-4  # 60 uniform numbers fall below with a probability of 2 %
    assert abs(np.mean(p) - 0.5) < 4 / np.sqrt(12 * 60)


def test_the_expected_covariance_of_the_same_experiment_is_the_covariance(found):
    np.testing.assert_allclose(expected_covariance(found), found.covariance, rtol=1e-6)


def test_a_longer_recording_is_expected_to_do_what_it_does(found):
    times = np.arange(1041) / 8000
    rng = np.random.default_rng(0)
    clean = yaw_response({e.name.split("[")[0]: x for e, x in zip(found.estimates, found.minimum.x, strict=True)},
                         times, PULSE).yaw  # fmt: skip
    deviation = found.noise[0][0].deviation
    longer = Trial(name="fly", time=times, yaw=clean + deviation * rng.standard_normal(1041), rate=8000.0,
                   perturbation=PULSE)  # fmt: skip
    errors = [e.standard_error for e in fit_gains([longer], MODEL).estimates]
    expected = np.sqrt(np.diag(expected_covariance(found, after=30 * ms)))
    np.testing.assert_allclose(errors, expected, rtol=4 / np.sqrt(2 * 1041) + 0.02)


def test_two_recordings_halve_the_variances_of_what_they_share(found):
    twice = expected_covariance(found, copies=2)
    assert twice[0, 0] == pytest.approx(found.covariance[0, 0] / 2)
    assert twice[4, 4] > 0.5 * found.covariance[4, 4]


def test_trade_offs_are_said_in_words_with_what_would_help(found):
    strongest, *_ = trade_offs(found)
    assert strongest.sentence.startswith(f"{strongest.first} and {strongest.second} trade off, correlation +0.9")
    pair = next(t for t in trade_offs(found) if {t.first, t.second} == {"kp", "delay"})
    assert pair.remedies[0].what == "damping known from elsewhere"
    assert pair.remedies[0].errors[0] < 0.5

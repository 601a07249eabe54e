"""What a fit says where the data say little: nothing visible, no response, trade-offs, something wrongly held."""

from dataclasses import replace

import numpy as np
import pytest
from perturbed_fly import AT_REST, PULSE, TIMES, TRUTH, recording

from flycontrol.identify.gains.design import expected_covariance, trade_offs
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.model import gain_model
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

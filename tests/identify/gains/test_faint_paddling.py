"""Paddling as faint as its noise: one search, one minimum, whatever the recordings' order and wherever it begins."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.intervals import estimates
from flycontrol.identify.gains.least_squares import minimise
from flycontrol.identify.gains.model import Unknown, gain_model
from flycontrol.identify.gains.problem import fit_problem, standard_model
from flycontrol.identify.gains.response import yaw_response
from flycontrol.identify.gains.result import spoken_estimate
from flycontrol.identify.gains.starts import starting_points
from flycontrol.identify.gains.uncertainty import local_uncertainty
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg, ms

TRUTH = {"kp": 4000.0, "kd": 59.0, "delay": 13.6 * ms, "damping": 156.0, "paddling_gain": 1.3e5}
LOOP = ("kp", "kd", "delay", "damping")
TIMES = np.arange(401) / 4000
ONCE_A_WINGBEAT = slice(9, None, 18)
FAINT, PLAIN = (5.0, 6.0, -7.0), (40.0, 48.0, -56.0)  #: impulses [rad/s]: a tenth of the paddling's noise, and as much


@cache
def filmed(seed, impulses=FAINT):
    rng, trials = np.random.default_rng(seed), []
    for k, impulse in enumerate(impulses):
        pulse = Pulse(onset=(5 + 0.6 * k) * ms, duration=4.5 * ms)
        clean = yaw_response(TRUTH | {"impulse": impulse}, TIMES, pulse, torque=True)
        seen = clean.fly[ONCE_A_WINGBEAT] / TRUTH["paddling_gain"]
        paddling = np.full(len(TIMES), np.nan)
        paddling[ONCE_A_WINGBEAT] = seen + deg * rng.standard_normal(len(seen))
        yaw = clean.yaw + 0.3 * deg * rng.standard_normal(len(TIMES))
        trials.append(
            Trial(name=f"p{k}", fly="fly", time=TIMES, yaw=yaw, rate=4000.0, perturbation=pulse, paddling=paddling)
        )
    return tuple(trials)


@cache
def fitted(seed, impulses=FAINT, turned=0):
    trials = filmed(seed, impulses)
    return fit_gains(trials[turned:] + trials[:turned])


@pytest.mark.parametrize(
    ("seed", "impulses"), [(0, FAINT), (1, FAINT), (3, FAINT), (11, FAINT), (8, (8.0, 9.0, -10.0))]
)
def test_estimates_do_not_depend_on_the_order_of_the_recordings(seed, impulses):
    """A search ends within 3e-5 standard errors of the minimum; twice that between two, and a little for the bias."""
    found = [fitted(seed, impulses, turned) for turned in range(3)]
    assert all(each.usable for each in found)
    for name in (*LOOP, "paddling_gain"):
        values = [each[name].value for each in found]
        assert np.ptp(values) < 1e-4 * found[0][name].standard_error, name


@pytest.mark.parametrize("seed", range(4))
def test_gains_and_delay_are_found_though_paddling_is_lost_in_noise(seed):
    """Four standard errors: chance passes them once in 16,000."""
    for name in LOOP:
        e = fitted(seed)[name]
        assert abs(e.value - TRUTH[name]) < 4 * e.standard_error


@pytest.mark.parametrize("impulses", [FAINT, PLAIN])
def test_the_paddling_gain_is_the_reciprocal_of_a_regression_on_the_torque(impulses):
    """At the minimum the reciprocal alone solves a linear problem, which needs no search."""
    found = fitted(0, impulses)
    gain, products, squares = found.minimum.x[found.problem.names.index("paddling_gain")], 0.0, 0.0
    for part, noises in zip(found.problem.parts, found.noise, strict=True):
        assert noises[1].order == 0
        torque = gain * part.predicted(found.minimum.x, False)[1][0] / noises[1].deviation
        products += torque @ part.channels[1].values / noises[1].deviation
        squares += torque @ torque
    error = 1 / np.sqrt(squares)  # of the reciprocal
    assert abs(products / squares - 1 / gain) < 1e-4 * error


@pytest.mark.parametrize("gain", [-1e30, -1e9, -1e5, -1e-3, 1e-3, 1.0, 1e9, 1e30])
def test_a_search_finds_the_paddling_gain_from_any_size_and_sign(gain):
    best = fitted(0, PLAIN)
    start = best.minimum.x.copy()
    place = best.problem.names.index("paddling_gain")
    start[place] = gain
    found = minimise(best.weighted, start, scale=1.0)
    assert found.converged
    assert abs(found.x[place] - best.minimum.x[place]) < 1e-4 * best["paddling_gain"].standard_error


def test_the_start_of_a_shared_paddling_gain_rests_on_all_recordings():
    trials = filmed(1)
    starts = [
        next(starting_points(fit_problem(order, standard_model(order)))).x[4]
        for order in (trials, trials[1:] + trials[:1], trials[::-1])
    ]
    assert starts == pytest.approx([starts[0]] * 3, rel=1e-9)


def test_a_paddling_gain_that_the_user_bounds_stays_inside_on_its_side_of_zero():
    """The data of this seed want a negative one."""
    model = gain_model(settings={"paddling_gain": Unknown(low=1e4, high=1e6)})
    found = fit_gains(filmed(11), model)
    assert found["paddling_gain"].value == 1e6
    assert found["paddling_gain"].at_bound
    assert found.status.startswith("at a bound: the best paddling_gain lies at your upper bound of 1e+06")


@pytest.mark.parametrize("seed", range(4))
def test_a_corrected_estimate_stays_in_its_interval_on_its_side_of_zero(seed):
    found = fitted(seed)
    for e, x in zip(found.estimates, found.minimum.x, strict=True):
        assert e.low <= e.value <= e.high
        assert e.kind != "paddling_gain" or e.value * x > 0


def test_a_bias_wider_than_the_interval_is_not_taken_off():
    found = fitted(0, PLAIN)
    width = 0.5 * (found["kp"].high - found["kp"].low)
    for times, taken in ((0.9, 0.9), (1.5, 0.0), (-1e6, 0.0), (np.nan, 0.0)):
        bias = found.uncertainty.bias.copy()
        bias[0] = times * width
        kp = estimates(found.weighted, found.minimum, replace(found.uncertainty, bias=bias), found.level, {})[0]
        assert kp.name == "kp"
        assert kp.bias == pytest.approx(taken * width, rel=1e-6)
        assert kp.value == pytest.approx(found.minimum.x[0] - kp.bias)


def lost(found):
    """The same minimum with a paddling gain so large that paddling shows no trace of it."""
    x = found.minimum.x.copy()
    x[found.problem.names.index("paddling_gain")] = -3.4e150
    return replace(found.minimum, x=x, at=found.weighted.normal_equations(x))


def test_no_bias_is_taken_off_where_an_unknown_leaves_no_trace_or_the_search_failed():
    found = fitted(0, PLAIN)
    for minimum in (lost(found), replace(found.minimum, converged=False)):
        assert not local_uncertainty(found.weighted, minimum).bias.any()


def test_an_unknown_without_trace_spoils_no_other_and_has_no_number_in_words():
    found = fitted(0, PLAIN)
    minimum = lost(found)
    said = estimates(found.weighted, minimum, local_uncertainty(found.weighted, minimum), 0.95, {})
    for e, x in zip(said, found.minimum.x, strict=True):
        assert e.undetermined == (e.kind == "paddling_gain")
        assert e.undetermined or e.value == x
    gamma = next(e for e in said if e.undetermined)
    assert spoken_estimate(gamma) == "of any size"

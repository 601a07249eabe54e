"""A delay that puts an edge of the pulse on a sample of the paddling: a minimum at that kink is a minimum."""

import numpy as np
import pytest

from flycontrol.identify.gains.fit import fit_without_profiles
from flycontrol.identify.gains.response import yaw_response
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg

BEAT, RATE = 1 / 220, 8800.0
TIMES = np.arange(1001) / RATE
PULSE = Pulse(onset=1.5 * BEAT, duration=BEAT)  # three wingbeats later its edges lie in the middle of wingbeats
TRUTH = {"kp": 3050.0, "kd": 45.0, "delay": 3 * BEAT, "damping": 69.0, "impulse": 35.0, "paddling_gain": 4e4}
SEEDS = range(12)


def filmed(seed):
    """Yaw in every frame, paddling in the middle of every wingbeat."""
    rng = np.random.default_rng(seed)
    clean = yaw_response(TRUTH, TIMES, PULSE, torque=True)
    paddling = np.full(len(TIMES), np.nan)
    paddling[20::40] = (clean.fly / TRUTH["paddling_gain"])[20::40] + 0.02 * deg * rng.standard_normal(25)
    yaw = clean.yaw + 0.3 * deg * rng.standard_normal(len(TIMES))
    return Trial(name="fly", time=TIMES, yaw=yaw, rate=RATE, perturbation=PULSE, paddling=paddling)


@pytest.fixture(scope="module")
def fits():
    return [fit_without_profiles([filmed(seed)], noise="white") for seed in SEEDS]


def test_every_fit_converges(fits):
    assert all(fit.converged for fit in fits), [fit.status for fit in fits]


def test_some_end_at_the_kink_and_there_the_cost_rises_to_both_sides(fits):
    at_kink = [fit for fit in fits if abs(fit["delay"].value - TRUTH["delay"]) < 1e-8]
    assert at_kink
    for fit in at_kink:
        step = np.where(np.array(fit.problem.kinds) == "delay", 1e-3 * fit["delay"].standard_error, 0.0)
        before, there, after = (fit.weighted.normal_equations(fit.minimum.x + sign * step).cost for sign in (-1, 0, 1))
        assert there < min(before, after)


def test_intervals_there_hold_the_truth(fits):
    """Of 60 intervals of 95 % at least 51: fewer happen by chance in one case of five hundred."""
    names = ("kp", "kd", "delay", "damping", "paddling_gain")
    held = sum(fit[name].low <= TRUTH[name] <= fit[name].high for fit in fits for name in names)
    assert held >= 51

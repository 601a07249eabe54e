"""A search that begins, or is led, where responses overflow ends with a status, not with an error."""

from functools import partial

import numpy as np
import pytest

from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.least_squares import WeightedProblem, minimise
from flycontrol.identify.gains.model import Unknown, gain_model
from flycontrol.identify.gains.noise import white
from flycontrol.identify.gains.problem import fit_problem
from flycontrol.identify.gains.response import yaw_response
from flycontrol.model.trial import Pulse, Trial

TIMES = np.arange(201) / 2000
PULSE = Pulse(onset=0.01, duration=0.0045)
TRUTH = {"kp": 3050.0, "kd": 45.0, "delay": 0.0136, "damping": 69.0, "impulse": 35.0}


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("kd", [-1e4, -1e8, 1e22, -1e60])
def test_a_start_from_which_responses_overflow_is_not_called_converged(kd):
    yaw = yaw_response(TRUTH, TIMES, PULSE).yaw
    trial = Trial(name="fly", time=TIMES, yaw=yaw, rate=2000.0, perturbation=PULSE)
    boundless = {"kp": Unknown(), "kd": Unknown()}
    model = gain_model(fixed={"initial_yaw": 0.0, "initial_rate": 0.0, "damping": 69.0}, settings=boundless)
    problem = fit_problem([trial], model)
    start = np.array(
        [{"kp": 3000.0, "kd": kd, "delay": 0.002, "impulse": 35.0}.get(kind, 0.0) for kind in problem.kinds]
    )
    found = minimise(WeightedProblem(problem, [[white(0.005, 100)]]), start)
    assert not found.converged or abs(found.x[problem.kinds.index("kd")] - 45.0) < 1e-3


def test_estimates_of_a_search_that_ran_out_of_steps_have_no_intervals(monkeypatch):
    yaw = yaw_response(TRUTH, TIMES, PULSE).yaw + 1e-3 * np.random.default_rng(0).standard_normal(len(TIMES))
    trial = Trial(name="fly", time=TIMES, yaw=yaw, rate=2000.0, perturbation=PULSE)
    monkeypatch.setattr("flycontrol.identify.gains.fit.minimise", partial(minimise, most_steps=1))
    found = fit_gains([trial])
    assert found.status.startswith("not converged: the search stopped after 1 steps, so the estimates mean nothing")
    assert "starting values" not in found.status
    assert not found.usable
    loop = [found[kind] for kind in ("kp", "kd", "delay", "damping")]
    assert all((e.low, e.high, e.standard_error) == (-np.inf, np.inf, np.inf) for e in loop)


@pytest.mark.parametrize("shift", [-1e3, -1e137, -1e300])
def test_a_pulse_so_early_that_no_sum_of_delays_reaches_the_recording_has_left_it(shift):
    turned = yaw_response({**TRUTH, "onset_shift": shift}, TIMES, PULSE).yaw
    assert np.array_equal(turned, np.zeros(len(TIMES)))

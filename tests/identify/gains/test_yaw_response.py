"""The exact response of a trial, against the delay room's own integrator and against differences."""

import numpy as np
import pytest

from flycontrol.delay.response import response
from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.response import NAMES, yaw_response
from flycontrol.model.trial import Pulse, TorqueTrace
from flycontrol.model.yaw import YawLoop

TRUTH = {"kp": 3050.0, "kd": 45.0, "delay": 0.0136, "damping": 69.0, "impulse": 35.0}
PULSE = Pulse(onset=0.01, duration=0.0045)
TIMES = np.arange(801) / 8000


def test_yaw_after_a_pulse_is_the_exact_response_of_the_yaw_loop():
    found = yaw_response(TRUTH, TIMES, PULSE, torque=True)
    loop = YawLoop.from_rates(b=69, kp=3050, kd=45, delay=0.0136)
    push = TRUTH["impulse"] / PULSE.duration
    exact = response(loop.closed_loop(), 0.09, [0.0, PULSE.duration], [[push], [0.0]])
    after = PULSE.onset <= TIMES
    outputs = exact(np.minimum(TIMES[after] - PULSE.onset, 0.09))
    np.testing.assert_allclose(found.yaw[after], outputs[0], atol=1e-13)
    np.testing.assert_allclose(found.fly[after], outputs[2], atol=1e-13 * np.abs(outputs[2]).max() + 1e-9)
    assert not found.yaw[~after].any()


@pytest.mark.parametrize("limit", [np.inf, 800.0])
def test_derivatives_are_those_of_the_response(limit):
    values = TRUTH | {"ki": 5000.0, "initial_yaw": 0.1, "initial_rate": 3.0, "heading": 0.2}
    names = [n for n in NAMES if n != "paddling_gain" and (n != "limit" or np.isfinite(limit))]
    if np.isfinite(limit):
        values = values | {"limit": limit}
    found = yaw_response(values, TIMES, PULSE, derivatives=names, torque=True)
    for name, by_yaw, by_fly in zip(names, found.by_parameter, found.fly_by_parameter, strict=True):
        h = 1e-6 if name == "onset_shift" else 1e-5 * max(abs(values[name]), 0.01)

        def at(step, name=name):
            moved = yaw_response(values | {name: values.get(name, 0.0) + step}, TIMES, PULSE, torque=True)
            return np.array([moved.yaw, moved.fly])

        difference = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)
        for mine, reference in zip((by_yaw, by_fly), difference, strict=True):
            error = np.sort(np.abs(mine - reference))[:-8]  # where the difference straddles a kink it is no derivative
            assert error[-1] <= 3e-8 * np.abs(reference).max() + 1e-12, name


def test_a_fine_trace_of_a_pulse_acts_like_the_pulse():
    edge = 1e-7
    time = np.array([0.0, 0.01 - edge, 0.01, 0.0145 - edge, 0.0145, 0.1])
    trace = TorqueTrace(time=time, drive=np.array([0.0, 0.0, 2.0, 2.0, 0.0, 0.0]), unit="A")
    found = yaw_response(TRUTH, TIMES, trace).yaw
    np.testing.assert_allclose(found, yaw_response(TRUTH, TIMES, PULSE).yaw, atol=2e-5)


def test_a_smooth_trace_agrees_with_small_steps_of_the_same_loop():
    time = np.arange(400) / 8000
    drive = np.exp(-(((time - 0.02) / 0.004) ** 2))
    drive[[0, -1]] = 0.0
    trace = TorqueTrace(time=time, drive=drive, unit="V")
    values = TRUTH | {"initial_rate": 1.0}
    found = yaw_response(values, TIMES, trace).yaw
    step, n = 1e-6, 100_000
    grid = step * np.arange(n + 1)
    push = TRUTH["impulse"] * np.interp(grid, time, drive, right=0.0) / np.trapezoid(drive, time)
    late = round(TRUTH["delay"] / step)
    yaw, rate = np.zeros(n + 1 + late), np.ones(n + 1 + late)
    yaw[: late + 1] = step * np.arange(-late, 1)
    for k in range(n):  # Euler's steps with half a step's correction
        w = TRUTH["kp"] * yaw[k] + TRUTH["kd"] * rate[k]
        acceleration = -TRUTH["damping"] * rate[k + late] - w + push[k]
        rate[k + late + 1] = rate[k + late] + step * acceleration
        yaw[k + late + 1] = yaw[k + late] + step * (rate[k + late] + rate[k + late + 1]) / 2
    np.testing.assert_allclose(found, np.interp(TIMES, grid, yaw[late:]), atol=3e-5)


def test_what_no_trial_can_have_is_refused():
    with pytest.raises(InvalidParameterError, match="delay must be > 0 s"):
        yaw_response(TRUTH | {"delay": 0.0}, TIMES, PULSE)
    with pytest.raises(InvalidParameterError, match="Unknown parameter 'gain'"):
        yaw_response(TRUTH | {"gain": 0.0}, TIMES, PULSE)
    with pytest.raises(InvalidParameterError, match="zero throughout"):
        yaw_response(TRUTH, TIMES, TorqueTrace(time=TIMES, drive=np.zeros(801), unit="A"))

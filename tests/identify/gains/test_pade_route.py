"""The fit through CasADi with a Pade approximant: the same numbers as the exact one where the approximant is good."""

import numpy as np
import pytest

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.pade_route import fit_gains_with_pade
from flycontrol.identify.gains.response import NAMES, drive_of, evaluate, parameter_vector, span_of, yaw_response
from flycontrol.identify.gains.shooting import PadeShooting
from flycontrol.model.trial import Pulse, TorqueTrace, Trial
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg

TRUTH = {"kp": 3050.0, "kd": 45.0, "delay": 0.0136, "damping": 69.0, "impulse": 35.0}
PULSE = Pulse(onset=0.01, duration=0.0045)
TIMES = np.arange(401) / 4000
KNOWN = {"damping": 69.0, "initial_yaw": 0.0, "initial_rate": 0.0, "heading": 0.0}


def shot(order, values, names, times=TIMES, perturbation=PULSE, torque=False):
    """Yaw and torque with derivatives, by the approximant and exactly."""
    p, drive = parameter_vector(values), drive_of(perturbation)
    active = np.array([NAMES.index(name) for name in names], dtype=np.int64)
    call = (p, active, drive, span_of(times, drive), times, torque)
    return PadeShooting(order)(*call), evaluate(*call)


def recording(noise=0.3, seed=0, truth=TRUTH):
    rng = np.random.default_rng(seed)
    yaw = yaw_response(truth, TIMES, PULSE).yaw + noise * deg * rng.standard_normal(len(TIMES))
    return Trial(name="fly", time=TIMES, yaw=yaw, rate=4000.0, perturbation=PULSE)


def test_the_shot_loop_is_the_delay_rooms_pade_loop():
    """Against python-control's response of the same augmented loop, the pulse on its grid."""
    import control

    pulse = Pulse(onset=0.0, duration=0.005)
    (yaw, _), _ = shot(5, TRUTH, [], perturbation=pulse)
    system = YawLoop.from_rates(b=69, kp=3050, kd=45, delay=0.0136).pade(5)
    pushed = control.forced_response(system, TIMES[:21], np.full(21, 35.0 / 0.005))
    free = control.forced_response(system, TIMES[20:], np.zeros(381), pushed.states[:, -1])
    theirs = np.concatenate([pushed.outputs[0], free.outputs[0][1:]])
    np.testing.assert_allclose(yaw[0], theirs, atol=1e-12)


@pytest.mark.parametrize("further", [{}, {"limit": 900.0}, {"ki": 6e4}])
def test_derivatives_of_the_shot_loop_are_those_of_its_response(further):
    values = TRUTH | {"initial_yaw": 0.05, "initial_rate": 1.0, "heading": 0.1} | further
    names = [*TRUTH, "initial_yaw", "initial_rate", "heading", *further]
    (yaw, fly), _ = shot(3, values, names, torque=True)
    for k, name in enumerate(names):
        h = 1e-4 * max(abs(values[name]), 0.01)
        (ahead, fly_ahead), _ = shot(3, values | {name: values[name] + h}, [], torque=True)
        (behind, fly_behind), _ = shot(3, values | {name: values[name] - h}, [], torque=True)
        for mine, difference in ((yaw, ahead - behind), (fly, fly_ahead - fly_behind)):
            slope = difference[0] / (2 * h)
            assert np.abs(mine[k + 1] - slope).max() <= 1e-6 * np.abs(slope).max(), name


def test_a_saturated_loop_that_never_saturates_is_the_linear_one():
    """Runge-Kutta steps against matrix exponentials."""
    (linear, _), _ = shot(4, TRUTH, ["kp", "delay"])
    (saturated, _), _ = shot(4, TRUTH | {"limit": 1e8}, ["kp", "delay"])
    assert (np.abs(saturated - linear).max(axis=1) < 2e-6 * np.abs(linear).max(axis=1)).all()


def test_a_fly_that_turned_before_the_start_keeps_turning_in_the_approximant():
    """Without feedback of the offset a ramp is answered exactly: the approximant's states hold it from the start."""
    (yaw, _), (exact, _) = shot(
        6, {"kp": 0.0, "kd": 20.0, "delay": 0.0136, "damping": 0.0, "initial_rate": 2.0}, [], perturbation=None
    )
    early = TIMES < 0.0136
    slowed = 2.0 * TIMES - 20.0 * TIMES**2  # psi'' = -kd psi'(t - T), psi' = 2 until the delay is over
    np.testing.assert_allclose(exact[0][early], slowed[early], atol=1e-13)
    np.testing.assert_allclose(yaw[0][early], slowed[early], atol=1e-6)


def test_a_recorded_torque_acts_as_it_does_on_the_exact_loop():
    time = np.arange(200) / 4000
    drive = np.exp(-(((time - 0.02) / 0.004) ** 2))
    trace = TorqueTrace(time=time, drive=drive, unit="V")
    (yaw, _), (exact, _) = shot(10, TRUTH, [], perturbation=trace)
    assert np.abs(yaw - exact).max() < 1e-4 * deg  # a smooth drive leaves the approximant little to miss


def test_at_a_high_order_the_route_is_a_check_of_the_exact_fit():
    found = fit_gains_with_pade([recording()], gain_model(fixed=KNOWN), order=8)
    assert found.minimum.converged
    assert found.route == "Padé [8/8]"
    assert max(abs(shift) for shift in found.bias_in_standard_errors.values()) < 0.02
    for i, name in enumerate(found.names):
        assert np.sqrt(found.covariance[i, i]) == pytest.approx(found.exact[name].standard_error, rel=2e-3)


def test_saturated_paddling_can_be_fitted_through_the_approximant():
    trial = recording(truth=TRUTH | {"limit": 900.0})
    found = fit_gains_with_pade([trial], gain_model(fixed=KNOWN, estimate=["limit"]), order=6)
    assert found.minimum.converged
    assert max(abs(shift) for shift in found.bias_in_standard_errors.values()) < 0.1


def test_what_the_route_cannot_do_is_refused_in_a_sentence():
    with pytest.raises(InvalidParameterError, match="order must be an integer >= 1"):
        fit_gains_with_pade([recording()], order=0)
    with pytest.raises(InvalidInputError, match="leave onset_shift out"):
        fit_gains_with_pade([recording()], gain_model(fixed=KNOWN, estimate=["onset_shift"]))

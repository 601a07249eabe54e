"""Traps of fitting a loop with delay: each is set, a plain approach falls in, this package does not."""

import complex_steps
import numpy as np
import pytest
from scipy.integrate import ode
from scipy.optimize import least_squares, leastsq

from flycontrol.identify.gains.constrained import constrained_fit
from flycontrol.identify.gains.constraints import Constraint
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.least_squares import minimise
from flycontrol.identify.gains.model import Unknown, gain_model
from flycontrol.identify.gains.pade_route import pade_fit
from flycontrol.identify.gains.response import NAMES, drive_of, evaluate, parameter_vector, span_of, yaw_response
from flycontrol.identify.gains.shooting import PadeShooting
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg

TRUTH = {"kp": 3050.0, "kd": 45.0, "delay": 0.0136, "damping": 69.0, "impulse": 35.0}
KNOWN = {"damping": 69.0, "initial_yaw": 0.0, "initial_rate": 0.0, "heading": 0.0, "impulse": 35.0}
AT_ONCE = Pulse(onset=0.0, duration=0.0045)
START = [2400.0, 35.0, 0.0115]  # 22 %, 22 % and 15 % off


def recording(rate, pulse=AT_ONCE, noise=0.3, seed=0):
    times = np.arange(round(0.1 * rate) + 1) / rate
    clean = yaw_response(TRUTH, times, pulse).yaw
    yaw = clean + noise * deg * np.random.default_rng(seed).standard_normal(len(times))
    return Trial(name="fly", time=times, yaw=yaw, rate=rate, perturbation=pulse)


def truth_is_found(trial):
    found = fit_gains([trial], gain_model(fixed=KNOWN))
    misses = [abs(found[name].value - TRUTH[name]) / found[name].standard_error for name in ("kp", "kd", "delay")]
    return found.converged and max(misses) < 4


def solver_step_by_step(times, kp, kd, T):
    """An adaptive solver from sample to sample, the past interpolated between them: what a delay solver may be."""
    states, known = np.zeros((len(times), 2)), [1]

    def rate(t, x):
        then, k = t - T, known[0]
        past = [np.interp(then, times[:k], states[:k, j]) if then > times[0] else 0.0 for j in (0, 1)]
        push = TRUTH["impulse"] / AT_ONCE.duration if t < AT_ONCE.duration else 0.0
        return [x[1], push - TRUTH["damping"] * x[1] - kp * past[0] - kd * past[1]]

    solver = ode(rate).set_integrator("vode").set_initial_value([0.0, 0.0], times[0])
    for k in range(1, len(times)):
        states[k] = solver.integrate(times[k])
        known[0] = k + 1
    return states[:, 0]


def test_a_generic_fit_around_a_delay_solver_calls_20_percent_off_a_success_and_ours_finds_the_truth():
    """The solver's own error, 0.03 deg, is harmless; but it is rough over the steps of difference quotients."""
    trial = recording(1000)
    error = solver_step_by_step(trial.time, 3050.0, 45.0, 0.0136) - yaw_response(TRUTH, trial.time, AT_ONCE).yaw
    assert np.abs(error).max() < 0.05 * deg
    x, covariance, details, _, ending = leastsq(
        lambda q: solver_step_by_step(trial.time, *q) - trial.yaw, START, full_output=True
    )
    spread = np.sqrt(np.sum(details["fvec"] ** 2) / (len(trial.time) - 3) * covariance[0, 0])
    assert ending in (1, 2, 3, 4)  # which MINPACK counts as success
    assert abs(x[0] / TRUTH["kp"] - 1) > 0.15
    assert spread < 1e-3 * x[0]
    assert truth_is_found(trial)


def buffered_delay(times, T):
    """Euler's steps with a delay line of whole steps."""
    h, n = times[1] - times[0], len(times)
    late = round(T / h)
    psi, rate = np.zeros(n + late), np.zeros(n + late)
    for k in range(n - 1):
        push = TRUTH["impulse"] / AT_ONCE.duration if times[k] < AT_ONCE.duration else 0.0
        torque = push - TRUTH["kp"] * psi[k] - TRUTH["kd"] * rate[k]
        rate[k + late + 1] = rate[k + late] + h * (torque - TRUTH["damping"] * rate[k + late])
        psi[k + late + 1] = psi[k + late] + h * rate[k + late]
    return psi[late:]


def test_a_delay_in_whole_samples_stops_a_fit_at_once_and_ours_moves():
    trial = recording(8000)
    naive = least_squares(lambda q: buffered_delay(trial.time, q[0]) - trial.yaw, [0.0115])
    assert naive.success
    assert naive.x[0] == 0.0115
    model = gain_model(
        fixed=KNOWN | {"kp": 3050.0, "kd": 45.0}, settings={"delay": Unknown(start=0.0115, low=0.001, high=0.06)}
    )
    ours = fit_gains([trial], model)
    assert abs(ours["delay"].value - TRUTH["delay"]) < 4 * ours["delay"].standard_error
    assert ours["delay"].standard_error < 1e-4


@pytest.mark.parametrize("onset", [0.01, 0.0100371, 0.01 + 1e-13, 0.0101249])
def test_edges_of_a_pulse_may_lie_anywhere_between_samples(onset):
    pulse = Pulse(onset=onset, duration=0.00457)
    times = np.arange(801) / 8000
    exact = complex_steps.response(TRUTH, times, pulse)[0].real
    np.testing.assert_allclose(yaw_response(TRUTH, times, pulse).yaw, exact, rtol=0, atol=1e-13)


def test_a_pulse_rounded_to_samples_costs_a_tenth_of_a_degree_which_biases_a_fit():
    """The trap: the same fit with edges moved to the nearest samples is many standard errors off."""
    pulse, onto_grid = Pulse(onset=0.01006, duration=0.00450), Pulse(onset=0.01, duration=0.0045)
    times = np.arange(801) / 8000
    cost = yaw_response(TRUTH, times, pulse).yaw - yaw_response(TRUTH, times, onto_grid).yaw
    assert np.abs(cost).max() > 0.1 * deg
    trial = recording(8000, pulse, noise=1e-9)
    rounded = Trial(name="fly", time=trial.time, yaw=trial.yaw, rate=8000.0, perturbation=onto_grid)
    model = gain_model(fixed=KNOWN)
    ours, naive = fit_gains([trial], model, noise="white"), fit_gains([rounded], model, noise="white")
    assert abs(ours["delay"].value - TRUTH["delay"]) < 1e-12
    assert abs(naive["delay"].value - TRUTH["delay"]) > 1.5e-5  # a third of a standard error at 0.3 deg


def test_a_pade_fit_biases_the_delay_and_says_so_and_the_exact_one_does_not():
    exact = fit_gains([recording(8000)], gain_model(fixed=KNOWN))
    clean = fit_gains([recording(8000, noise=1e-9)], gain_model(fixed=KNOWN), noise="white")
    assert abs(clean["delay"].value - TRUTH["delay"]) < 1e-12
    first, fourth = pade_fit(exact, 1), pade_fit(exact, 4)
    assert 1e-3 < first.bias["delay"] < 2e-3  # + 1.4 ms
    assert first.bias_in_standard_errors["delay"] > 20
    assert first.status.startswith("Padé [1/1]: converged; against the exact delay")
    assert abs(fourth.bias_in_standard_errors["delay"]) < 0.2


def test_at_order_20_the_approximant_holds_where_the_companion_form_in_seconds_is_lost():
    import control

    times = np.arange(201) / 2000
    loop = control.ss(control.tf(*control.pade(TRUTH["delay"], 20)))
    plant = control.ss([[0, 1], [0, -69.0]], [[0], [1]], np.eye(2), np.zeros((2, 1)))
    closed = control.feedback(plant, loop * control.ss([], [], [], [[3050.0, 45.0]]))
    push = np.where(times < 0.0045 - 1e-9, TRUTH["impulse"] / 0.0045, 0.0)
    with np.errstate(all="ignore"):
        companion = control.forced_response(closed, times, push).states[0]
    p, drive = parameter_vector(TRUTH), drive_of(AT_ONCE)
    call = (p, np.array([NAMES.index("delay")]), drive, span_of(times, drive), times, False)
    (ours, _), (exact, _) = PadeShooting(20)(*call), evaluate(*call)
    assert not np.abs(companion - exact[0]).max() < 1.0 * deg
    assert np.abs(ours[0] - exact[0]).max() < 5e-4 * deg
    assert np.abs(ours[1] - exact[1]).max() < 1e-3 * np.abs(exact[1]).max()


def test_a_search_cut_short_is_a_status_and_neither_an_exception_nor_a_success():
    whole = fit_gains([recording(8000)], gain_model(fixed=KNOWN))
    cut = minimise(whole.weighted, np.array(START), most_steps=1)
    assert not cut.converged
    assert minimise(whole.weighted, np.array(START)).converged
    wrong = constrained_fit(whole, [Constraint(name="none", expression=lambda p: p["kp"] ** 2, low=-2.0, high=-1.0)])
    assert not wrong.converged
    assert wrong.status.startswith("exact delay: not converged: IPOPT ended with")

from itertools import pairwise

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from method_of_steps import MethodOfSteps
from random_systems import drawn_alike, random_system

from flycontrol.delay.interconnect import delay, feedback
from flycontrol.delay.piecewise import fitted, piecewise_polynomial, sampled
from flycontrol.delay.response import response
from flycontrol.delay.system import delay_lti
from flycontrol.delay.timeresponse import forced_response, impulse_response, initial_response, step_response
from flycontrol.errors import InvalidParameterError

PLANT = control.tf([5.0, 30.0], [1.0, 3.0, 8.0, 2.0])
TIMES = np.linspace(0.0, 4.0, 401)


def integrator_with_delay(k=1.0, T=1.0):
    """x' = -k x(t - T) + u."""
    return delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[-k]], C1=[[1.0]], C2=[[1.0]], tau=[T])


@pytest.mark.parametrize("ours", [step_response, impulse_response])
def test_without_delay_step_and_impulse_are_python_controls(ours):
    theirs = getattr(control, ours.__name__)(PLANT, TIMES)
    np.testing.assert_allclose(ours(PLANT, TIMES).outputs, theirs.outputs, atol=1e-10)


def test_without_delay_forced_and_initial_responses_are_python_controls():
    samples = np.sin(3 * TIMES) + (TIMES > 1)
    plant = control.ss(PLANT)
    theirs = control.forced_response(plant, TIMES, samples)
    np.testing.assert_allclose(forced_response(plant, TIMES, samples).outputs, theirs.outputs, atol=1e-10)
    start = [0.3, -1.0, 0.7]
    theirs = control.initial_response(plant, TIMES, start)
    ours = initial_response(plant, TIMES, start)
    np.testing.assert_allclose(ours.outputs, theirs.outputs, atol=1e-10)
    np.testing.assert_allclose(ours.states, theirs.states, atol=1e-10)


def test_results_have_the_shapes_of_python_control():
    plant = random_system(1, 3, 0, inputs=2, outputs=2)
    theirs = control.step_response(control.ss(plant.A, plant.B1, plant.C1, plant.D11), TIMES)
    ours = step_response(plant, TIMES)
    assert ours.outputs.shape == theirs.outputs.shape
    assert ours.states.shape == theirs.states.shape
    np.testing.assert_allclose(ours.outputs, theirs.outputs, atol=1e-9 * np.abs(theirs.outputs).max())


@drawn_alike
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_the_impulse_response_integrates_to_the_step_response(seed, chained):
    system = random_system(seed, 3, 3, chained=chained)
    edge = 3.0
    impulse, step = impulse_response(system, edge), step_response(system, edge)
    exact, deltas = impulse.exact[0], impulse.impulses[0]
    x, weights = np.polynomial.legendre.leggauss(12)
    total, scale = 0.0, 1 + np.abs(step.outputs).max()
    for k, (a, h) in enumerate(zip(exact.starts, exact.lengths, strict=True)):
        total += h / 2 * weights @ exact(a + h * (1 + x) / 2)[0]
        if k + 1 < len(exact.starts):
            b = exact.starts[k + 1]
            passed = deltas.weights[deltas.times <= b + 1e-9].sum()
            assert total + passed == pytest.approx(step.exact[0]([b])[0, 0], abs=1e-10 * scale)


def test_an_impulse_through_a_delayed_input_arrives_late_and_whole():
    """x' = -x + u(t - 0.4) + u(t - 0.7), the second through a chain: x = exp(0.4 - t) + exp(0.7 - t)."""
    system = delay_lti(
        A=[[-1.0]], B1=[[0.0]], B2=[[1.0, 1.0]], C1=[[1.0]], C2=[[0.0], [0.0]], D21=[[1.0], [0.0]],
        D22=[[0.0, 0.0], [1.0, 0.0]], tau=[0.4, 0.3],
    )  # fmt: skip
    t = np.linspace(0.0, 2.0, 57)
    exact = np.where(t >= 0.4, np.exp(0.4 - t), 0.0) + np.where(t >= 0.7, np.exp(0.7 - t), 0.0)
    np.testing.assert_allclose(impulse_response(system, t).outputs, exact, atol=1e-13)


def test_a_ramp_through_a_pure_delay_comes_out_late():
    ramp = piecewise_polynomial([0.0, 1.0, 3.0], [[[0.0, 1.0, 0.0]], [[1.0, 0.0, -0.25]]])
    t = np.linspace(0.0, 3.0, 301)
    shifted = np.where(t < 0.35, 0.0, np.where(t < 1.35, t - 0.35, 1 - 0.25 * (t - 1.35) ** 2))
    np.testing.assert_allclose(forced_response(delay(0.35), t, ramp).outputs, shifted, atol=1e-14)


def test_a_quadratic_input_to_a_delayed_integrator_follows_the_steps_by_hand():
    # x' = -x(t - 1) + t^2 from rest: x = t^3/3, then t^3/3 - (t - 1)^4/12, then + (t - 2)^5/60
    t = np.linspace(0.0, 3.0, 91)
    exact = t**3 / 3 - np.where(t > 1, (t - 1) ** 4 / 12, 0) + np.where(t > 2, (t - 2) ** 5 / 60, 0)
    parabola = piecewise_polynomial([0.0, 3.0], [[[0.0, 0.0, 1.0]]])
    np.testing.assert_allclose(forced_response(integrator_with_delay(), t, parabola).outputs, exact, atol=1e-13)


def test_held_samples_are_the_piecewise_constant_input_of_their_edges():
    system = random_system(7, 3, 2)
    t = np.linspace(0.0, 2.0, 41)
    samples = np.random.default_rng(3).normal(size=41)
    ours = forced_response(system, t, samples, hold="zero").exact[0]
    exact = MethodOfSteps(system, 2.0, t[:3], samples[:3, None])
    early = np.linspace(0.001, 0.149, 20)  # before the fourth sample
    np.testing.assert_allclose(ours(early), exact(early), atol=1e-10)
    edges = response(system, 2.0, t[:-1], samples[:-1, None])
    np.testing.assert_allclose(ours(t), edges(t), atol=1e-11)


def test_samples_on_one_line_are_one_piece():
    assert len(sampled(np.arange(9.0), [0, 0, 0, 1, 2, 3, 3, 3, 3]).starts) == 3
    assert len(sampled(np.arange(6.0), [1, 1, 2, 2, 2, 2], "zero").starts) == 2


def test_a_sine_in_the_past_goes_on_as_a_sine_where_the_equation_wants_it():
    # x' = -(pi/2) x(t - 1) has the solution sin(pi t / 2)
    T = np.linspace(0.0, 7.0, 141)
    ours = initial_response(integrator_with_delay(np.pi / 2), T, history=lambda t: [np.sin(np.pi * t / 2)])
    np.testing.assert_allclose(ours.outputs, np.sin(np.pi * T / 2), atol=1e-12)


def test_a_history_that_jumps_is_taken_from_the_right_side():
    # x' = -x(t - 1), x = 0 before -0.4 and 1 from there to 0, so that x = 1 - (t - 0.6) for 0.6 < t < 1
    t = np.linspace(0.0, 1.0, 101)
    ours = initial_response(integrator_with_delay(), t, history=lambda s: [float(s >= -0.4)], breaks=[-0.4])
    np.testing.assert_allclose(ours.outputs, np.where(t < 0.6, 1.0, 1.6 - t), atol=1e-13)


def test_a_history_runs_through_chained_delays():
    """x' = w2, w2(t) = w1(t - 0.3) = x(t - 0.7), whole and in two delays, after x = cos t."""
    chained = delay_lti(
        A=[[0.0]], B1=[[0.0]], B2=[[0.0, 1.0]], C1=[[1.0]], C2=[[1.0], [0.0]], D22=[[0.0, 0.0], [1.0, 0.0]],
        tau=[0.4, 0.3],
    )  # fmt: skip
    whole = integrator_with_delay(-1.0, 0.7)
    one, other = (initial_response(system, 3.0, history=lambda t: [np.cos(t)]) for system in (chained, whole))
    np.testing.assert_allclose(one.outputs, other.outputs, atol=1e-12)
    np.testing.assert_allclose(one.exact[0]([0.5])[0], 1 + np.sin(-0.2) - np.sin(-0.7), atol=1e-13)


def test_a_fit_reaches_rounding():
    pieces = fitted(lambda t: [np.exp(-t) * np.sin(20 * t), abs(t - 1)], [0.0, 1.0, 3.0])
    t = np.linspace(0.0, 3.0, 1001)
    np.testing.assert_allclose(pieces(t), [np.exp(-t) * np.sin(20 * t), abs(t - 1)], atol=3e-14)
    assert all(b > a for a, b in pairwise(pieces.starts))


def test_left_to_itself_a_step_response_runs_until_it_has_settled():
    whole = step_response(feedback(integrator_with_delay(0.0) * delay(0.3)))
    assert whole.outputs[-1] == pytest.approx(1.0, abs=5e-3)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda s: step_response(s, [0.5, 1.0]), "rising from 0 s"),
        (lambda s: step_response(s, -1.0), "end > 0 s"),
        (lambda s: forced_response(s, [0.0, 1.0, 2.0], [1.0, 2.0]), r"shape \(1, 2\)"),
        (lambda s: forced_response(s, [0.0, 1.0], [[1.0, 2.0]] * 2), "1 input"),
        (lambda s: forced_response(s, [0.0, 9.0], sampled([0.0, 1.0], [1.0, 2.0])), "must cover"),
        (lambda s: forced_response(s, [0.0, 1.0], [1.0, np.nan]), "finite"),
        (lambda s: initial_response(s, 1.0, [1.0, 2.0]), "must be 1 finite"),
        (lambda s: initial_response(s, 1.0, 1.0, history=lambda _: [1.0, 2.0]), "must return 1 finite"),
        (lambda s: initial_response(s, 1.0, history=lambda t: [float(t > -0.3)]), "not smooth near -0.3"),
        (lambda _: piecewise_polynomial([0.0, 1.0], np.ones((1, 1, 11))), "degree 0 to 9"),
    ],
)
def test_an_impossible_experiment_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InvalidParameterError, match=sentence):
        call(integrator_with_delay())

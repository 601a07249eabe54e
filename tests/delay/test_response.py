from dataclasses import replace
from math import factorial

import control
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from method_of_steps import MethodOfSteps
from random_systems import drawn_alike, random_system

from flycontrol.delay.interconnect import delay, feedback, series
from flycontrol.delay.pade import from_control
from flycontrol.delay.response import response
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import delay_lti
from flycontrol.errors import InvalidParameterError


def first_order(k: float, T: float):
    """psi' = -k psi(t - T) + u."""
    return delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[-k]], C1=[[1.0]], C2=[[1.0]], tau=[T])


def steps_by_hand(k: float, T: float, t: np.ndarray) -> np.ndarray:
    """psi(t) = sum_j (-k)^j (t - (j - 1) T)^j / j! over the steps begun, for psi = 1 in the past."""
    terms = [np.where(t > (j - 1) * T, (-k) ** j * (t - (j - 1) * T) ** j / factorial(j), 0.0) for j in range(12)]
    return np.sum(terms, axis=0)


@pytest.mark.parametrize(("k", "T"), [(1.0, 1.0), (0.3, 1.0), (1.7, 0.73), (40.0, 0.0136)])
def test_one_delayed_integrator_follows_the_polynomials_of_the_method_of_steps(k, T):
    t = np.linspace(0.0, 9.7 * T, 371)
    exact = steps_by_hand(k, T, t)
    # the alternating sum by hand itself loses about 1e-13 of its largest term
    np.testing.assert_allclose(response(first_order(k, T), 10 * T, initial_state=[1.0])(t)[0], exact, atol=1e-11)


@drawn_alike
@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_without_delay_the_response_is_the_matrix_exponential(seed, n):
    system = random_system(seed, n, 0)
    x0 = np.random.default_rng(seed).normal(size=n)
    t = np.linspace(0.0, 3.0, 7)
    exact = np.array([system.C1 @ scipy.linalg.expm(system.A * time) @ x0 for time in t]).T
    np.testing.assert_allclose(response(system, 3.0, initial_state=x0)(t), exact, atol=1e-10 * np.abs(exact).max())


def test_a_delay_free_loop_answers_as_in_python_control():
    loop = control.feedback(control.tf([5.0, 30.0], [1.0, 3.0, 8.0, 0.0]), 1)
    t = np.linspace(0.0, 4.0, 401)
    held = control.forced_response(control.ss(loop), t, np.ones_like(t)).outputs
    ours = response(from_control(loop), 4.0, [0.0], [[1.0]])(t)[0]
    np.testing.assert_allclose(ours, held, atol=1e-9)  # lsim's own matrix exponentials, step after step
    switched = response(from_control(loop), 4.0, [0.0, 1.5], [[1.0], [-0.4]])(t)[0]
    later = response(from_control(loop), 4.0, [0.0], [[-1.4]])(t[t >= 1.5] - 1.5)[0]
    np.testing.assert_allclose(switched[t >= 1.5], ours[t >= 1.5] + later, atol=1e-12)


@pytest.mark.parametrize(("seed", "states", "delays"), [(1, 1, 1), (2, 2, 2), (3, 3, 2), (4, 2, 3), (5, 4, 2)])
@pytest.mark.parametrize("chained", [False, True])
def test_random_systems_agree_with_an_independent_method_of_steps(seed, states, delays, chained):
    system = random_system(seed, states, delays, inputs=2, outputs=2, chained=chained)
    edges, inputs = [0.0, 0.31731, 1.00217], [[1.0, 0.0], [0.3, -0.7], [0.0, 0.2]]
    history = np.random.default_rng(seed).normal(size=states)
    end = 2.5
    t = np.linspace(0.0013, end - 0.0017, 97)
    exact = MethodOfSteps(system, end, edges, inputs, history)(t)
    ours = response(system, end, edges, inputs, history)(t)
    np.testing.assert_allclose(ours, exact, atol=1e-10 * np.abs(exact).max())


def test_two_delays_without_a_common_measure_agree_with_the_method_of_steps():
    system = delay_lti(
        A=[[0.0, 1.0], [-2.0, -0.5]], B1=[[0.0], [1.0]], B2=[[0.0, 0.0], [-1.0, -0.6]], C1=[[1.0, 0.0]],
        C2=[[1.0, 0.0], [0.0, 1.0]], tau=[1.0 / np.sqrt(2.0), 1.0 / np.pi],
    )  # fmt: skip
    t = np.linspace(0.01, 5.99, 113)
    pulse = ([0.0, np.exp(-1.0)], [[1.0], [0.0]])
    exact = MethodOfSteps(system, 6.0, *pulse)(t)
    np.testing.assert_allclose(response(system, 6.0, *pulse)(t), exact, atol=1e-11)


def test_a_delay_shorter_than_every_time_constant_is_still_resolved():
    # x' = -(x(t - 1) + x(t - 0.37)) / 10: nothing but the delays asks for steps below 5 s
    system = delay_lti(A=[[0.0]], B1=[[0.0]], B2=[[-0.1, -0.1]], C1=[[1.0]], C2=[[1.0], [1.0]], tau=[1.0, 0.37])
    t = np.linspace(0.05, 13.95, 60)
    exact = MethodOfSteps(system, 14.0, initial_state=[1.0])(t)
    np.testing.assert_allclose(response(system, 14.0, initial_state=[1.0])(t), exact, atol=1e-11)


def test_two_delays_in_series_are_one_delay_of_their_sum():
    """x' = -x + 3 (1 - x)(t - 0.57), the delay once whole and once as a chain of 0.3 and 0.27."""
    split = delay_lti(
        A=[[-1.0]], B1=[[0.0]], B2=[[0.0, 3.0]], C1=[[1.0]], C2=[[-1.0], [0.0]], D21=[[1.0], [0.0]],
        D22=[[0.0, 0.0], [1.0, 0.0]], tau=[0.3, 0.27],
    )  # fmt: skip
    whole = delay_lti(A=[[-1.0]], B1=[[0.0]], B2=[[3.0]], C1=[[1.0]], C2=[[-1.0]], D21=[[1.0]], tau=[0.57])
    t = np.linspace(0.0, 6.0, 101)
    np.testing.assert_allclose(
        response(split, 6.0, inputs=[[1.0]])(t), response(whole, 6.0, inputs=[[1.0]])(t), atol=1e-11
    )


def test_a_constant_history_that_is_an_equilibrium_stays_one_through_a_chain_of_delays():
    # x' = -x + w2, w2(t) = w1(t - 0.4), w1(t) = x(t - 0.3): every constant is an equilibrium
    system = delay_lti(
        A=[[-1.0]], B1=[[0.0]], B2=[[0.0, 1.0]], C1=[[1.0]], C2=[[1.0], [0.0]], D22=[[0.0, 0.0], [1.0, 0.0]],
        tau=[0.3, 0.4],
    )  # fmt: skip
    t = np.linspace(0.0, 5.0, 50)
    np.testing.assert_allclose(response(system, 5.0, initial_state=[0.7])(t), 0.7, atol=1e-13)


def test_in_the_long_run_the_response_decays_at_the_rightmost_root():
    loop = first_order(0.3, 1.0)  # 0.3 < 1/e: the rightmost root is real
    tail = response(loop, 60.0, initial_state=[1.0])
    s0 = rightmost_roots(loop, 3).roots[0].real
    early, late = tail([50.0, 60.0])[0]
    assert np.log(late / early) / 10.0 == pytest.approx(s0, rel=1e-10)


@drawn_alike
@given(st.integers(0, 2**32 - 1), st.floats(-3, 3), st.floats(-3, 3))
def test_responses_superpose(seed, one, other):
    system = random_system(seed, 2, 2)
    t = np.linspace(0.0, 2.0, 21)

    def to(first, second):
        return response(system, 2.0, [0.0, 0.41], [[first], [second]])(t)

    together = one * to(1.0, 0.0) + other * to(0.0, 1.0)
    np.testing.assert_allclose(to(one, other), together, atol=1e-11 * (1 + np.abs(together).max()))


def test_the_largest_value_is_the_largest_extremum_of_the_response():
    loop = feedback(series(delay(0.21), delay_lti(A=[[0.0, 1.0], [0.0, -1.0]], B1=[[0.0], [1.0]], C1=[[2.0, 0.5]])))
    whole = response(loop, 20.0, [0.0, 0.37], [[1.0], [0.0]])
    value, time = whole.largest()
    near = np.linspace(time - 1e-3, time + 1e-3, 20001)
    # the extremum is flat: a time wrong by 1e-7 would cost 1e-14, a grid of panels' fractions costs far more
    assert value == pytest.approx(np.abs(whole(near)[0]).max(), rel=1e-10)
    assert value >= np.abs(whole(np.linspace(0.0, 20.0, 200001))[0]).max() * (1 - 1e-12)


@drawn_alike
@given(st.integers(0, 2**32 - 1), st.floats(0.02, 0.9))
def test_after_the_last_time_outside_a_band_the_response_stays_inside(seed, share):
    system = random_system(seed, 3, 1)
    continuous = replace(system, D12=np.zeros((1, 1)))  # no path from input to output but through a state
    whole = response(continuous, 12.0, [0.0, 0.613], [[1.0], [0.0]])
    band = share * whole.largest()[0]
    last = whole.last_time_outside(band)
    t = np.linspace(0.0, 12.0, 24001)
    outside = t[np.abs(whole(t)[0]) > band]
    if not np.isfinite(last):
        assert abs(whole([12.0])[0, 0]) > band
        return
    assert outside.max() <= last + 1e-9
    assert abs(whole([last])[0, 0]) == pytest.approx(band, rel=1e-9)


def test_times_outside_the_response_or_falling_times_are_refused():
    whole = response(first_order(1.0, 0.5), 2.0, initial_state=[1.0])
    for times in ([2.1], [-0.1], [1.0, 0.5], [np.nan]):
        with pytest.raises(InvalidParameterError, match="rise within"):
            whole(times)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"end": 0.0}, "must be > 0 s"),
        ({"end": np.nan}, "must be > 0 s"),
        ({"end": 1.0, "edges": [0.1]}, "must rise from 0 s"),
        ({"end": 1.0, "edges": [0.0, 0.0]}, "must rise from 0 s"),
        ({"end": 1.0, "edges": [0.0, 0.1], "inputs": [[1.0]]}, r"shape \(2, 1\), got shape \(1, 1\)"),
        ({"end": 1.0, "inputs": [[np.nan]]}, "finite"),
        ({"end": 1.0, "initial_state": [1.0, 2.0]}, "must be 1 finite numbers"),
    ],
)
def test_an_impossible_experiment_is_refused_in_a_sentence(arguments, sentence):
    with pytest.raises(InvalidParameterError, match=sentence):
        response(first_order(1.0, 0.5), **arguments)

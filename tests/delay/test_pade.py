from dataclasses import replace
from math import factorial

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_systems import drawn_alike, random_points, random_system

from flycontrol.delay.interconnect import delay, feedback
from flycontrol.delay.pade import from_control, pade, pade_matrices, to_statespace
from flycontrol.errors import InvalidParameterError

orders = pytest.mark.parametrize("order", [1, 2, 3, 5, 8, 12, 20, 40])


def textbook(order: int, s):
    """[n/n] = sum_k c_k (-s)^k / sum_k c_k s^k with c_k = (2n - k)! n! / ((2n)! k! (n - k)!)."""
    n = order
    c = [
        factorial(2 * n - k) * factorial(n) / (factorial(2 * n) * factorial(k) * factorial(n - k)) for k in range(n + 1)
    ]
    return np.polyval(c[::-1], -s) / np.polyval(c[::-1], s)


@orders
def test_the_approximant_is_stable(order):
    poles = np.linalg.eigvals(pade_matrices(order).A)
    assert poles.real.max() < 0


@orders
def test_the_approximant_lets_every_frequency_pass_unchanged_in_size(order):
    w = np.geomspace(1e-3, 1e3, 200)
    assert np.abs(pade(delay(1.0), order)(1j * w)[:, 0, 0]) == pytest.approx(1.0, abs=1e-12)


@orders
def test_its_states_are_scaled_to_the_energy_that_they_store(order):
    """A + A' = -B B', C = +-B': a lossless all-pass whose realisation cannot be ill conditioned."""
    A, B, C, D = pade_matrices(order)
    np.testing.assert_allclose(A + A.T, -np.outer(B, B), atol=1e-12 * np.abs(A).max())
    np.testing.assert_allclose(np.abs(C), np.abs(B), atol=1e-14 * np.abs(B).max())
    assert abs(D) == 1.0


@pytest.mark.parametrize("order", range(1, 8))
def test_it_is_the_textbooks_rational_function(order):
    s = 3.0 * random_points(1, 20)
    np.testing.assert_allclose(pade(delay(1.0), order)(s)[:, 0, 0], textbook(order, s), rtol=1e-11)


@pytest.mark.parametrize("order", range(1, 7))
def test_its_error_falls_with_the_power_2n_plus_1_of_delay_times_frequency(order):
    """R(jw) - exp(-jw) = O(w^(2n+1)) with the constant n!^2 / ((2n)! (2n+1)!)."""
    constant = factorial(order) ** 2 / (factorial(2 * order) * factorial(2 * order + 1))
    # errors from 1e-9 to 1e-7: small enough for the leading term, large enough for double precision
    w = (np.array([1e-9, 1e-7]) / constant) ** (1 / (2 * order + 1))
    T = 0.0136
    error = np.abs(pade(delay(T), order)(1j * w / T)[:, 0, 0] - np.exp(-1j * w))
    slope = np.log(error[1] / error[0]) / np.log(w[1] / w[0])
    assert slope == pytest.approx(2 * order + 1, abs=0.05 * order)
    assert error[0] == pytest.approx(1e-9, rel=0.1)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_it_agrees_with_python_control_at_low_orders(order):
    companion = control.tf(*control.pade(0.3, order))
    s = random_points(2, 10)
    np.testing.assert_allclose(pade(delay(0.3), order)(s)[:, 0, 0], companion(s), rtol=1e-9)


@drawn_alike
@given(st.integers(0, 2**32 - 1), st.integers(1, 9))
def test_approximating_and_closing_the_loop_commute(seed, order):
    P = random_system(seed, 3, 2, inputs=2, outputs=2, chained=True)
    P = replace(P, D12=np.zeros((2, 2)))  # a proper loop without an algebraic part
    s = random_points(seed)
    first, last = pade(feedback(P), order)(s), feedback(pade(P, order))(s)
    np.testing.assert_allclose(first, last, rtol=1e-7, atol=1e-8 * np.abs(last).max())


def test_a_system_without_delay_is_its_own_approximation():
    system = random_system(1, 3, 0)
    assert pade(system, 4) is system


def test_a_state_space_goes_to_python_control_and_back_unchanged():
    there = to_statespace(random_system(2, 3, 0))
    back = from_control(there)
    s = random_points(4)
    np.testing.assert_allclose(back(s)[:, 0, 0], there(s), rtol=1e-12)


def test_a_transfer_function_of_python_control_becomes_the_same_system():
    G = control.tf([2.0, 1.0], [1.0, 3.0, 5.0])
    s = random_points(4)
    np.testing.assert_allclose(from_control(G)(s)[:, 0, 0], G(s), rtol=1e-12)


@pytest.mark.parametrize("order", [0, -1, 2.0, "3"])
def test_an_order_that_is_no_positive_integer_is_refused(order):
    with pytest.raises(InvalidParameterError, match="integer >= 1"):
        pade_matrices(order)


def test_a_state_space_of_a_delay_needs_an_order():
    with pytest.raises(InvalidParameterError, match=r"has 1 delay.*give the order"):
        to_statespace(delay(0.1))


def test_discrete_time_is_refused():
    with pytest.raises(InvalidParameterError, match="continuous-time"):
        from_control(control.ss([[0.5]], [[1.0]], [[1.0]], [[0.0]], dt=0.1))


def test_an_improper_system_is_refused_in_a_sentence():
    with pytest.raises(InvalidParameterError, match="improper"):
        from_control(control.tf([1.0, 2.0, 3.0], [1.0, 1.0]))

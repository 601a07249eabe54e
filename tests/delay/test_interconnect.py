from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_systems import drawn_alike, random_points, random_system

from flycontrol.delay.interconnect import append, connect, delay, feedback, series
from flycontrol.delay.system import delay_lti
from flycontrol.errors import AlgebraicLoopError, InvalidParameterError

seeds = st.integers(0, 2**32 - 1)
POINTS = random_points(11)


def same(system, transfer):
    value = system(POINTS)
    np.testing.assert_allclose(value, transfer, rtol=1e-8, atol=1e-9 * np.abs(transfer).max())


@drawn_alike
@given(seeds, seeds)
def test_series_multiplies_transfer_matrices(one, other):
    first = random_system(one, 2, 2, inputs=1, outputs=3)
    second = random_system(other, 3, 1, inputs=3, outputs=2)
    same(series(first, second), second(POINTS) @ first(POINTS))


@drawn_alike
@given(seeds, seeds, st.sampled_from([-1.0, 1.0]))
def test_feedback_divides_by_one_plus_the_loop(one, other, sign):
    P = random_system(one, 3, 2, inputs=2, outputs=1, chained=True)
    K = random_system(other, 1, 1, inputs=1, outputs=2)
    p, k = P(POINTS), K(POINTS)
    same(feedback(P, K, sign), p @ np.linalg.inv(np.eye(2) - sign * k @ p))


@drawn_alike
@given(seeds)
def test_unit_feedback_is_feedback_through_the_identity(seed):
    P = random_system(seed, 2, 2, inputs=2, outputs=2)
    identity = delay_lti(A=np.zeros((0, 0)), B1=np.zeros((0, 2)), C1=np.zeros((2, 0)), D11=np.eye(2))
    same(feedback(P), feedback(P, identity)(POINTS))


def test_appended_systems_do_not_touch_each_other():
    first, second = random_system(1, 2, 1), random_system(2, 1, 2, inputs=2)
    both = append(first, second)(POINTS)
    same_first, same_second = both[:, :1, :1], both[:, 1:, 1:]
    np.testing.assert_allclose(same_first, first(POINTS), rtol=1e-10)
    np.testing.assert_allclose(same_second, second(POINTS), rtol=1e-10)
    assert not both[:, :1, 1:].any()
    assert not both[:, 1:, :1].any()


@given(st.floats(0.0, 3.0))
@drawn_alike
def test_a_pure_delay_is_the_exponential(seconds):
    np.testing.assert_allclose(delay(seconds)(POINTS)[:, 0, 0], np.exp(-POINTS * seconds), rtol=1e-13)


def test_opening_a_loop_again_gives_the_plant_back():
    """feedback(feedback(P, K), K, +1) = P."""
    P, K = random_system(4, 3, 2), random_system(5, 1, 1)
    same(feedback(feedback(P, K), K, sign=1.0), P(POINTS))


def test_a_loop_whose_direct_path_has_gain_one_is_refused():
    gain = delay_lti(A=np.zeros((0, 0)), B1=np.zeros((0, 1)), C1=np.zeros((1, 0)), D11=[[1.0]])
    with pytest.raises(AlgebraicLoopError, match="no unique solution"):
        feedback(gain, sign=1.0)
    through = replace(random_system(1), D11=np.array([[-1.0]]))
    with pytest.raises(AlgebraicLoopError, match="put a delay or a lag"):
        feedback(through)


def test_series_of_systems_that_do_not_fit_names_both_sizes():
    with pytest.raises(InvalidParameterError, match=r"first system \(2\).*second \(3\)"):
        series(random_system(1, outputs=2), random_system(2, inputs=3))


def test_feedback_through_a_system_that_does_not_fit_names_both_sizes():
    with pytest.raises(InvalidParameterError, match=r"= \(3, 2\) .* shape \(2, 3\), got \(4, 1\)"):
        feedback(random_system(1, inputs=2, outputs=3), random_system(2, inputs=1, outputs=4))
    with pytest.raises(InvalidParameterError, match=r"\(outputs, inputs\) = \(3, 2\)"):
        feedback(random_system(1, inputs=2, outputs=3))


def test_connect_refuses_matrices_that_do_not_fit_and_names_both_shapes():
    with pytest.raises(InvalidParameterError, match=r"\(1, 1\).*\(2, 1\)"):
        connect(random_system(1), np.zeros((2, 1)), np.eye(1), np.eye(1))


@pytest.mark.parametrize("seconds", [-0.1, np.nan, np.inf])
def test_a_delay_that_no_clock_can_show_is_refused(seconds):
    with pytest.raises(InvalidParameterError, match="must be >= 0 s and finite"):
        delay(seconds)

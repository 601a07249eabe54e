"""What a Pade approximation does to a response and to a stability boundary, and the companion form's trap."""

import control
import numpy as np
import pytest
from pd_loop import KD, KP, B, T, pd_closed
from scipy.optimize import brentq

from flycontrol.delay.pade import pade
from flycontrol.delay.response import response
from flycontrol.delay.spectrum import rightmost_roots

TIMES = np.linspace(0.0, 0.2, 401)


@pytest.fixture(scope="module")
def exact_step():
    return response(pd_closed(), 0.2, inputs=[[1.0]])(TIMES)[0]


def relative_error(yaw, exact):
    return float(np.abs(yaw - exact).max() / np.abs(exact).max())


@pytest.mark.parametrize("order", [12, 18, 24, pytest.param(40, marks=pytest.mark.slow)])
def test_orders_from_12_to_40_stay_accurate_in_time(order, exact_step):
    approximate = response(pade(pd_closed(), order), 0.2, inputs=[[1.0]])(TIMES)[0]
    # yaw's third derivative jumps a delay after the step, so the error falls like 1 / order^3, not exponentially
    assert relative_error(approximate, exact_step) < 0.02 / order**3


def companion_loop(order: int) -> control.StateSpace:
    """The same loop as python-control builds it: companion form, time in seconds."""
    lag = control.ss(control.tf(*control.pade(T, order)))
    plant = control.ss([[0.0, 1.0], [0.0, -B]], [[0.0], [1.0]], np.eye(2), np.zeros((2, 1)))
    return control.feedback(plant, lag * control.ss([], [], [], [[KP, KD]]))


def test_at_order_4_the_companion_form_gives_the_same_response(exact_step):
    theirs = control.forced_response(companion_loop(4), TIMES, np.ones_like(TIMES)).outputs[0]
    ours = response(pade(pd_closed(), 4), 0.2, inputs=[[1.0]])(TIMES)[0]
    np.testing.assert_allclose(theirs, ours, atol=1e-6 * exact_step.max())


@pytest.mark.filterwarnings("ignore")  # it also warns
@pytest.mark.parametrize("order", [14, 16])
def test_the_companion_form_in_seconds_is_lost_at_order_14_where_the_ladder_is_not(order, exact_step):
    theirs = control.forced_response(companion_loop(order), TIMES, np.ones_like(TIMES)).outputs[0]
    ours = response(pade(pd_closed(), order), 0.2, inputs=[[1.0]])(TIMES)[0]
    assert not relative_error(theirs, exact_step) < 0.1  # NaN is lost too
    assert relative_error(ours, exact_step) < 1e-5


def critical_gain(order: int | None) -> float:
    def abscissa(kd):
        loop = pd_closed(kd=kd)
        return rightmost_roots(loop if order is None else pade(loop, order), 1).abscissa

    return brentq(abscissa, 100.0, 200.0, xtol=1e-9)


def test_a_pade_approximation_overstates_stability_by_30_percent_at_order_1_and_less_at_higher_ones():
    excess = [critical_gain(order) / critical_gain(None) - 1 for order in (1, 2, 3, 4)]
    assert excess[0] == pytest.approx(0.30, abs=0.005)
    assert min(excess) > 0
    assert (np.diff(excess) < 0).all()


@pytest.mark.parametrize("order", [8, 12, 24, 40])
def test_rightmost_poles_of_high_orders_are_the_exact_roots(order):
    exact = rightmost_roots(pd_closed(), 3).roots
    approximate = rightmost_roots(pade(pd_closed(), order), 3).roots
    np.testing.assert_allclose(approximate, exact, rtol=1e-10)

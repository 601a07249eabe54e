from dataclasses import replace

import control
import numpy as np
import pytest
from pd_loop import largest_delay, pd_open
from random_systems import random_system

from flycontrol.delay.convert import from_control
from flycontrol.delay.count import count_right_of
from flycontrol.delay.interconnect import delay, feedback, series
from flycontrol.delay.nyquist import nyquist_response
from flycontrol.delay.system import DelayLTI, delay_lti
from flycontrol.errors import InvalidParameterError, NeutralSystemError


def random_loop(seed: int) -> DelayLTI:
    """Up to four states and three delays, some of them in inner loops, up to two integrators and a resonance on the
    axis, a delay in series, any gain.
    """
    rng = np.random.default_rng(seed)
    inner = random_system(seed, int(rng.integers(1, 5)), int(rng.integers(1, 4)))
    loop = replace(inner, A=inner.A - 2 * np.eye(inner.n_states), D12=0 * inner.D12, D21=0 * inner.D21)
    for _ in range(int(rng.integers(0, 3))):
        numerator = [1.0, rng.normal()] if rng.random() < 0.5 else [1.0]
        loop = loop * from_control(control.tf(numerator, [1.0, 0.0]))
    if rng.random() < 0.3:
        loop = loop * from_control(control.tf([1.0, 1.0, 1.0], [1.0, 0.0, rng.uniform(0.1, 9.0)]))
    return float(rng.choice([0.01, 0.1, 1.0])) * loop * delay(rng.uniform(0.0, 1.0))


def test_encirclements_and_open_loop_poles_give_the_certified_count_on_two_hundred_random_loops():
    """Two computations: the winding of L around -1, and the argument principle on the closed loop's matrix."""
    integrators = unstable = 0
    for seed in range(200):
        loop = random_loop(seed)
        found, exact = nyquist_response(loop), count_right_of(feedback(loop), 0.0)
        assert (found.status, exact.status) == ("certified", "certified"), seed
        assert found.closed_loop_unstable == exact.roots, seed
        integrators += len(found.axis_poles) > 0
        unstable += exact.roots > 0
    assert min(integrators, unstable, 200 - unstable) > 40  # the sample is no trivial one


@pytest.mark.parametrize(("factor", "count"), [(0.5, 0), (0.9999, 0), (1.0001, 2), (2.0, 2)])
def test_pd_control_encircles_from_its_largest_delay_on(factor, count):
    b, kp, kd = 20.0, 900.0, 55.0
    found = nyquist_response(pd_open(b, kp, kd, factor * largest_delay(b, kp, kd)))
    assert (found.count, found.open_loop_unstable, found.closed_loop_unstable) == (count, 0, count)


@pytest.mark.parametrize(
    ("plant", "count", "poles"),
    [
        ("5/(s-1)", -1, 1),
        ("0.5/(s-1)", 0, 1),
        ("1/s**2", 2, 0),
        ("0.3*(s+1)**2/s**3", 2, 0),
        ("3*(s+1)**2/s**3", 0, 0),
        ("(s+1)/(s**2+1)**2", 2, 0),
    ],
)
def test_textbook_loops_are_encircled_as_by_hand(plant, count, poles):
    """A hundredth of a second of delay changes no verdict, but decides that of 1/s^2, which has none without."""
    loop = from_control(eval(plant, {"s": control.tf("s")})) * delay(0.01)
    found = nyquist_response(loop)
    assert (found.count, found.open_loop_unstable) == (count, poles)
    assert found.closed_loop_unstable == count_right_of(feedback(loop), 0.0).roots


@pytest.mark.parametrize(("gain", "count"), [(2.0, 0), (4.0, 1), (-0.5, 0), (-2.0, 1)])
def test_a_direct_path_without_delay_may_pass_on_either_side_of_minus_one(gain, count):
    """gain (s - 1) / (s + 3) closes to a root at (gain - 3) / (gain + 1)."""
    loop = from_control(gain * control.tf([1.0, -1.0], [1.0, 3.0]))
    assert nyquist_response(loop).count == count


@pytest.mark.parametrize("seed", range(12))
def test_without_delay_the_count_is_that_of_python_control(seed):
    rng = np.random.default_rng(seed)
    plant = control.ss(rng.normal(size=(3, 3)), rng.normal(size=(3, 1)), 3 * rng.normal(size=(1, 3)), 0)
    theirs = control.nyquist_response(plant, np.append(0.0, np.geomspace(1e-3, 1e5, 20_000)))
    assert nyquist_response(from_control(plant)).count == theirs.count


def test_the_curve_is_that_of_the_loop_and_passes_the_integrator_on_its_right():
    loop = pd_open()
    found = nyquist_response(loop)
    np.testing.assert_allclose(found.response, loop(found.contour)[:, 0, 0], rtol=1e-10)
    assert found.contour[0].real > 0
    assert found.contour[0].imag == 0
    assert (found.contour.real >= 0).all()


def test_a_closed_loop_pole_on_the_axis_is_said_and_not_counted():
    found = nyquist_response(series(delay(np.pi / 2), from_control(control.tf([1.0], [1.0, 0.0]))))  # roots +-j
    assert found.count is None
    assert found.closed_loop_unstable is None
    assert "meets -1" in found.status


def test_an_integrator_that_the_loop_does_not_show_is_said_and_not_counted():
    """s / (s (s + 1)), uncancelled: the closed loop keeps its pole at zero whatever the gain."""
    loop = delay_lti(A=[[0.0, 0.0], [0.0, -1.0]], B1=[[1.0], [1.0]], C1=[[0.0, 0.5]])
    found = nyquist_response(loop)
    assert found.count is None
    assert "hidden" in found.status


def test_a_direct_path_with_more_gain_than_one_through_a_delay_is_refused():
    loop = 1.5 * delay(0.1) * from_control(control.tf([1.0, 1.0], [1.0, 2.0]))
    with pytest.raises(NeutralSystemError, match="surrounds -1 at all high frequencies"):
        nyquist_response(loop)


def test_a_direct_path_of_minus_one_is_refused():
    with pytest.raises(InvalidParameterError, match="direct path is -1"):
        nyquist_response(from_control(control.tf([-1.0, 1.0], [1.0, 1.0])))

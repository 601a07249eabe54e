import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pd_loop import largest_delay, pd_closed
from random_systems import drawn_alike, random_system
from scipy.special import lambertw

from flycontrol.delay.count import count_right_of
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import characteristic_matrix, delay_lti


@pytest.mark.parametrize("chained", [False, True])
def test_the_count_agrees_with_the_roots_found_in_three_hundred_random_systems(chained):
    for seed in range(150):
        system = random_system(seed, 1 + seed % 4, 1 + seed % 3, chained=chained)
        found = rightmost_roots(system, 8)
        assert found.status == "certified", seed
        for line in (0.0, found.abscissa - 0.3, found.abscissa + 0.1, -1.0):
            counted = count_right_of(system, line)
            gap = np.abs(found.roots.real - line).min()
            if line > found.line and gap > 1e-6:
                assert counted.status == "certified", seed
                assert counted.roots == (found.roots.real > line).sum(), seed


@pytest.mark.parametrize("seed", range(6))
def test_the_count_is_the_winding_number_of_a_densely_walked_contour(seed):
    """The argument principle on a rectangle around every root right of the line, by brute force."""
    system = random_system(seed, 1 + seed % 3, 1 + seed % 2)
    line = -0.7
    reach = 60.0  # above ||A|| + ||B2|| exp(0.7 tau) ||C2|| of these systems
    side = np.linspace(-reach, reach, 100_001)
    right, up = reach + 0 * side, np.linspace(line, reach, 20_001)
    contour = np.concatenate([right + 1j * side, up[::-1] + 1j * reach, line + 1j * side[::-1], up - 1j * reach])
    phase = np.unwrap(np.angle(np.linalg.det(characteristic_matrix(system, contour))))
    assert count_right_of(system, line).roots == round((phase[-1] - phase[0]) / (2 * np.pi))


@drawn_alike
@given(st.floats(0.05, 60.0), st.floats(-1.5, 1.5))
def test_the_count_of_a_delayed_integrator_is_that_of_lambert_ws_branches(k, line):
    system = delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[-k]], C1=[[1.0]], C2=[[1.0]], tau=[1.0])
    exact = np.array([lambertw(-k, j) for j in range(-60, 60)]).real
    counted = count_right_of(system, line)
    if counted.roots is None:
        assert counted.status == "a root too near the line"
        assert np.abs(exact - line).min() < 1e-6
    else:
        assert counted.status == "certified"
        assert counted.roots == (exact > line).sum()


@pytest.mark.parametrize("factor", [0.9, 0.999999, 1.000001, 1.1])
def test_two_roots_enter_the_right_half_plane_at_the_largest_delay(factor):
    T = factor * largest_delay(20.0, 900.0, 55.0)
    assert count_right_of(pd_closed(T=T), 0.0).roots == (0 if factor < 1 else 2)


def test_a_root_on_the_line_is_said_and_not_counted():
    system = delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[-1.0]], C1=[[1.0]], C2=[[1.0]], tau=[np.pi / 2])  # roots +-j
    counted = count_right_of(system, 0.0)
    assert counted.roots is None
    assert counted.status == "a root too near the line"


def test_a_system_without_states_has_no_roots():
    system = delay_lti(
        A=np.zeros((0, 0)), B1=np.zeros((0, 1)), C1=np.zeros((1, 0)), D12=[[1.0]], D21=[[1.0]], tau=[1.0]
    )
    counted = count_right_of(system, 0.0)
    assert (counted.roots, counted.status) == (0, "certified")

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_systems import drawn_alike, random_system

from flycontrol.delay.balance import balance
from flycontrol.delay.convert import from_control
from flycontrol.delay.frequency_domain import frequency_domain
from flycontrol.delay.interconnect import delay
from flycontrol.delay.kernels import bernstein
from flycontrol.delay.panels import bernstein_matrix, kernel_blocks, panels_along, transfer
from flycontrol.delay.system import delay_lti
from flycontrol.errors import InvalidParameterError


def largest_errors(system, pieces) -> np.ndarray:
    """The largest Frobenius norm of what the polynomials miss, on 33 points of each panel."""
    u = np.linspace(-1.0, 1.0, 33)
    powers = u[:, None] ** np.arange(pieces.series.shape[1])
    found = np.einsum("uk,Pkab->Puab", powers, pieces.series)
    exact = system(pieces.centre[:, None] + pieces.half[:, None] * u)
    return np.linalg.norm(found - exact, axis=(2, 3)).max(axis=1)


@drawn_alike
@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.integers(1, 3), st.booleans())
def test_no_polynomial_errs_by_more_than_its_bound(seed, states, delays, chained):
    system = random_system(seed, states, delays, inputs=2, outputs=2, chained=chained)
    pieces = panels_along(kernel_blocks(balance(system)), 0.3j, 40.0j)
    rounding = 1e-13 * np.abs(pieces.series).sum(axis=1).max(axis=(1, 2))  # of the comparison itself
    assert (largest_errors(system, pieces) <= pieces.error + rounding).all()


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_the_bound_holds_where_it_is_far_above_rounding(tolerance):
    """Loose panels, whose errors are seen: neither exceeded nor so large that panels are wasted."""
    for seed in range(20):
        system = random_system(seed, 3, 2, chained=True)
        pieces = panels_along(kernel_blocks(balance(system)), 0.3j, 40.0j, floor=tolerance)
        error = largest_errors(system, pieces)
        assert (error <= pieces.error + 1e-13).all()
        assert np.median(pieces.error / error) < 30


def test_panels_join_from_end_to_end():
    pieces = panels_along(kernel_blocks(balance(random_system(3, 4, 2))), 0.5, 20.0j + 0.1)
    np.testing.assert_allclose((pieces.centre + pieces.half)[:-1], (pieces.centre - pieces.half)[1:], rtol=1e-12)
    np.testing.assert_allclose([pieces.points(0, -1.0), pieces.points(-1, 1.0)], [0.5, 20.0j + 0.1], rtol=1e-12)


def test_a_triple_integrator_far_below_every_rate_takes_few_panels():
    chain = delay_lti(A=np.diag([1.0, 1.0], -1), B1=[[1.0], [0.0], [0.0]], C1=[[2.0, 4.0, 2.0]])
    pieces = panels_along(kernel_blocks(balance(chain)), 1e-9j, 1e3j, first=1e-10)
    assert len(pieces) < 250
    # the comparison loses digits as 1/w^3 does in forming L from its states
    assert (largest_errors(chain, pieces) <= pieces.error + 1e-12 * np.abs(pieces.series[:, 0, 0, 0])).all()


def test_values_and_slopes_are_those_of_the_transfer_matrix():
    system = random_system(8, 4, 3, inputs=2, outputs=3, chained=True)
    s = np.array([0.1 + 2.0j, 3.0j, -0.05 + 1.0j])
    found, slope = transfer(kernel_blocks(balance(system)), s)
    np.testing.assert_allclose(found, system(s), rtol=1e-11)
    step = 1e-5
    np.testing.assert_allclose(slope, (system(s + step) - system(s - step)) / (2 * step), rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("degree", [1, 2, 5, 16, 32])
def test_control_points_reproduce_the_powers_and_never_exceed_one(degree):
    matrix = bernstein_matrix(degree)
    x = np.linspace(0.0, 1.0, 11)
    basis = np.stack([_bernstein(degree, i, x) for i in range(degree + 1)])
    np.testing.assert_allclose(basis.T @ matrix, (2 * x[:, None] - 1) ** np.arange(degree + 1), atol=1e-13)
    assert np.abs(matrix).max() == 1.0


def _bernstein(n: int, i: int, x: np.ndarray) -> np.ndarray:
    from math import comb

    return comb(n, i) * x**i * (1 - x) ** (n - i)


@drawn_alike
@given(st.integers(0, 2**32 - 1), st.integers(1, 8))
def test_every_root_of_a_polynomial_is_isolated(seed, degree):
    """Roots drawn; those closer than a thousandth of the interval to each other are left to the next test."""
    roots = np.random.default_rng(seed).uniform(-1.5, 1.5, degree)
    if np.diff(np.sort(np.append(roots, [-1.0, 1.0]))).min() < 1e-3:
        return
    points = bernstein_matrix(degree) @ np.polynomial.polynomial.polyfromroots(roots)
    _, found = bernstein.roots(points[None], np.zeros(1))
    assert np.sort(found) == pytest.approx(np.sort(roots[np.abs(roots) < 1]), abs=1e-7)


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6])
def test_two_roots_close_to_each_other_are_two(gap):
    points = bernstein_matrix(2) @ np.polynomial.polynomial.polyfromroots([0.3, 0.3 + gap])
    _, found = bernstein.roots(points[None], np.zeros(1))
    assert np.sort(found) == pytest.approx([0.3, 0.3 + gap], abs=1e-9)


def test_a_root_at_the_point_where_an_interval_is_halved_is_found_once():
    for sign in (1.0, -1.0):
        points = sign * bernstein_matrix(3) @ np.array([0.0, 1.0, 0.0, 0.0])
        _, found = bernstein.roots(points[None], np.zeros(1))
        assert found == pytest.approx([0.0], abs=1e-12)


def test_poles_on_the_axis_are_found_with_their_multiplicity():
    import control

    s = control.tf("s")
    loop = from_control((s + 1) / (s**2 * (s**2 + 4) ** 2)) * delay(0.3)
    found = [(pole.frequency, pole.multiplicity) for pole in frequency_domain(loop).poles.on_axis]
    assert found == [(0.0, 2), (pytest.approx(2.0, abs=1e-7), 2)]


def test_a_response_that_turns_too_often_to_be_followed_is_refused():
    system = delay_lti(A=[[-1.0]], B1=[[1.0]], C1=[[0.0]], C2=[[1.0]], D12=[[1.0]], tau=[1e4])
    with pytest.raises(InvalidParameterError, match="turns too often"):
        panels_along(kernel_blocks(balance(system)), 1.0j, 1e6j)

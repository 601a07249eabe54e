from dataclasses import replace
from importlib import import_module

import control
import numpy as np
import pytest
from pd_loop import largest_delay, pd_open
from random_systems import random_points, random_system

from flycontrol.delay.convert import from_control
from flycontrol.delay.count import count_right_of
from flycontrol.delay.interconnect import delay, feedback
from flycontrol.delay.pade import pade, pade_matrices
from flycontrol.delay.pade_order import pade_certificate, pade_order
from flycontrol.delay.system import DelayLTI
from flycontrol.errors import InvalidParameterError, UnstableSystemError

pade_order_module = import_module("flycontrol.delay.pade_order")
STABLE = [(m, n) for n in range(1, 9) for m in range(max(0, n - 4), n)]


@pytest.mark.parametrize(("m", "n"), STABLE)
def test_m_over_n_is_the_textbooks_rational_function(m, n):
    s = random_points(1, 12)
    numerator, denominator = control.pade(1.0, n, m)
    theirs = np.polyval(numerator, s) / np.polyval(denominator, s)
    np.testing.assert_allclose(pade(delay(1.0), n, m)(s)[:, 0, 0], theirs, rtol=1e-9)


@pytest.mark.parametrize(("m", "n"), [*STABLE, (19, 20), (18, 20), (39, 40)])
def test_strictly_proper_approximants_have_input_normal_states(m, n):
    """A + A' = -B B': the controllability Gramian is the identity, so no order is ill conditioned; and stable."""
    A, B, C, D = pade_matrices(n, m)
    np.testing.assert_allclose(A + A.T, -np.outer(B, B), atol=1e-12 * np.abs(A).max())
    assert np.linalg.eigvals(A).real.max() < 0
    assert D == 0
    assert np.abs(C).max() < 10 * n


@pytest.mark.parametrize("n", [1, 2, 5, 20])
def test_one_degree_less_in_the_numerator_is_the_legendre_delay_network(n):
    """Voelker and Eliasmith's state space, which projects the past onto Legendre polynomials."""
    i = np.arange(n)
    A = (2 * i[:, None] + 1) * np.where(i[:, None] < i, -1.0, (-1.0) ** (i[:, None] - i + 1))
    B, s = (2 * i + 1) * (-1.0) ** i, random_points(4)
    network = [np.ones(n) @ np.linalg.solve(point * np.eye(n) - A, B) for point in s]
    np.testing.assert_allclose(pade(delay(1.0), n, -1)(s)[:, 0, 0], network, rtol=1e-9)


@pytest.mark.parametrize(("m", "n"), [(0, 1), (1, 2), (1, 3), (3, 4), (2, 4), (4, 5)])
def test_the_error_falls_with_the_power_m_plus_n_plus_1(m, n):
    w = np.array([0.2, 0.1]) * n
    error = np.abs(pade(delay(1.0), n, m)(1j * w)[:, 0, 0] - np.exp(-1j * w))
    assert np.log2(error[0] / error[1]) == pytest.approx(m + n + 1, abs=0.1 * n)


@pytest.mark.parametrize("below", [1, 2])
@pytest.mark.parametrize("n", [2, 3, 6, 12, 30])
def test_up_to_two_degrees_less_in_the_numerator_no_frequency_is_amplified(n, below):
    gain = np.abs(pade(delay(1.0), n, -below)(1j * np.geomspace(1e-3, 1e4, 2000)))
    assert gain.max() < 1 + 1e-12


@pytest.mark.parametrize("n", range(1, 5))
def test_without_a_numerator_the_approximant_is_stable_up_to_order_four(n):
    assert np.linalg.eigvals(pade_matrices(n, 0).A).real.max() < 0


@pytest.mark.parametrize(("m", "n"), [(0, 5), (0, 8), (1, 7)])
def test_an_approximant_with_unstable_poles_is_refused(m, n):
    assert np.roots(control.pade(1.0, n, m)[1]).real.max() > 0
    with pytest.raises(InvalidParameterError, match=rf"\[{m}/{n}\].*unstable poles.*degree {n - 4} or more"):
        pade_matrices(n, m)


@pytest.mark.parametrize("m", [6, -6, 2.0, "1"])
def test_a_numerator_that_is_no_degree_is_refused(m):
    with pytest.raises(InvalidParameterError, match="degree from 0 to 5"):
        pade_matrices(5, m)


def random_loop(seed: int) -> DelayLTI:
    """Delays inside and in series, an integrator now and then; about half of them unstable when closed."""
    rng = np.random.default_rng(seed)
    inner = random_system(seed, int(rng.integers(1, 4)), int(rng.integers(1, 3)))
    loop = replace(inner, A=inner.A - 2 * np.eye(inner.n_states), D12=0 * inner.D12, D21=0 * inner.D21)
    if rng.random() < 0.4:
        loop = loop * from_control(control.tf([1.0, 0.5], [1.0, 0.0]))
    return float(rng.choice([0.3, 1.0, 4.0])) * loop * delay(rng.uniform(0.1, 1.0))


def unstable_poles(rational: DelayLTI) -> int:
    return int((np.linalg.eigvals(rational.A).real > 0).sum())


@pytest.mark.parametrize("numdeg", [None, -1])
def test_whenever_an_order_is_certified_exact_and_approximate_loop_are_equally_unstable(numdeg):
    certified = refused = unstable = 0
    for seed in range(24):
        loop = random_loop(seed)
        closed = feedback(loop)
        exact = count_right_of(closed, 0.0).roots
        for order in (1, 3):
            found = pade_certificate(loop, order, numdeg)
            assert found.unstable == exact
            certified += found.certified
            refused += not found.certified
            if found.certified:
                assert unstable_poles(pade(closed, order, numdeg)) == exact, seed
                unstable += exact > 0
    assert min(certified, refused, unstable) > 4  # the sample shows all cases


def test_the_stated_errors_are_never_exceeded():
    for seed in range(16):
        loop = random_loop(seed)
        closed = feedback(loop)
        found = pade_certificate(loop, 2 + seed % 3, band=5.0)
        if found.certified:
            inside, far = np.linspace(0.0, 5.0, 4001), np.geomspace(1e-3, 1e4, 4001)
            approximate = pade(closed, found.order)
            error = np.abs(closed(1j * inside) - approximate(1j * inside)).max()
            assert error <= found.error
            assert error >= found.error * 0.99 - 1e-9  # nor is the bound a loose one
            assert np.abs(closed(1j * far) - approximate(1j * far)).max() <= found.error_everywhere


@pytest.mark.parametrize("numdeg", [None, -1])
@pytest.mark.parametrize("accuracy", [0.2, 1e-2, 1e-4, 1e-7])
def test_the_order_chosen_reaches_the_accuracy_and_the_one_before_does_not(accuracy, numdeg):
    loop = pd_open(b=69.0, kp=3050.0, kd=45.0)
    found = pade_order(loop, accuracy, numdeg)
    assert found.certified
    assert found.error <= accuracy
    assert found.numdeg == found.order + (numdeg or 0)
    if found.order > (1 if numdeg is None else 1 - numdeg):
        before = pade_certificate(loop, found.order - 1, numdeg)
        assert not (before.certified and before.error <= accuracy)


def test_a_lower_order_that_looks_stable_is_not_certified_at_the_edge_of_stability():
    """Just above the largest delay the exact loop is unstable while [1/1] still closes to a stable one."""
    b, kp, kd = 20.0, 900.0, 55.0
    loop = pd_open(b, kp, kd, 1.02 * largest_delay(b, kp, kd))
    assert count_right_of(feedback(loop), 0.0).roots == 2
    assert unstable_poles(pade(feedback(loop), 1)) == 0
    found = pade_certificate(loop, 1)
    assert not found.certified
    assert found.error == np.inf
    assert "proves nothing" in found.status
    assert pade_certificate(loop, 6).certified


def test_in_one_delay_the_certificate_is_the_quotient_of_the_textbook():
    """sup |N (R - exp(-jwT)) / (D + N exp(-jwT))| by brute force."""
    b, kp, kd, T = 20.0, 900.0, 55.0, 0.0136
    w = np.geomspace(1e-1, 1e5, 200_001)
    s = 1j * w
    N, D = kd * s + kp, s * (s + b)
    R = pade(delay(T), 2)(s)[:, 0, 0]
    quotient = np.abs(N * (R - np.exp(-s * T)) / (D + N * np.exp(-s * T))).max()
    assert pade_certificate(pd_open(b, kp, kd, T), 2).loop_error == pytest.approx(quotient, rel=2e-3)


@pytest.mark.parametrize("accuracy", [0.0, -1.0, 1e-12, 1.0, np.nan])
def test_an_accuracy_that_cannot_be_is_refused(accuracy):
    with pytest.raises(InvalidParameterError, match=r"accuracy must lie in \[1e-09, 1\)"):
        pade_order(pd_open(), accuracy)


def test_an_accuracy_that_no_order_reaches_is_refused():
    with pytest.raises(InvalidParameterError, match=r"No Pade order up to 40 .* narrower band"):
        pade_order(pd_open(), 1e-3, band=2e4)


def test_a_loop_that_no_order_certifies_is_refused_after_few_of_them(monkeypatch):
    """|L| = 100 at low frequencies keeps every approximant's error far above the band from being small enough."""
    tried = []
    monkeypatch.setattr(pade_order_module, "pade", lambda *args: tried.append(args[1]) or pade(*args))
    with pytest.raises(InvalidParameterError, match=r"No Pade order up to 40 closes this loop certified"):
        pade_order(control.tf([100.0], [1.0, 1.0]) * delay(1.0) * delay(2**0.5), 0.5, band=0.1)
    assert set(tried) <= {*range(1, 8), 40}


def test_a_loop_without_delay_has_nothing_to_approximate():
    with pytest.raises(InvalidParameterError, match="no delay"):
        pade_order(from_control(control.tf([1.0], [1.0, 1.0])), 1e-2)


def test_a_loop_on_the_boundary_is_refused():
    with pytest.raises(UnstableSystemError, match=r"on the imaginary axis, at 1 rad/s.*either side"):
        pade_order(from_control(control.tf([1.0], [1.0, 0.0])) * delay(np.pi / 2), 1e-2)


def in_series(gain: float = 1.0) -> DelayLTI:
    """Two delays with the plant between them."""
    return delay(0.1) * control.tf([gain], [1.0, 1.0, 0.0]) * delay(0.1 * 2**0.5)


def one_after_the_other() -> DelayLTI:
    """A delay in front of a choice of two ways, one of them late."""
    return control.tf([2.0], [1.0, 1.0, 0.0]) * delay(0.3) * (1 + delay(0.1 * 2**0.5))


@pytest.mark.parametrize("loop", [in_series(), in_series(20.0), one_after_the_other()])
def test_delays_in_series_are_certified_like_delays_side_by_side(loop):
    closed = feedback(loop)
    for order in (2, 4):
        found = pade_certificate(loop, order)
        assert found.certified
        assert found.unstable == count_right_of(closed, 0.0).roots == unstable_poles(pade(closed, order))


def test_an_order_is_found_for_delays_in_series():
    loop = in_series(0.1)
    found = pade_order(loop, 1e-2)
    assert found.certified
    w = np.linspace(0.0, found.band, 2001)
    difference = feedback(loop)(1j * w) - pade(feedback(loop), found.order)(1j * w)
    assert np.abs(difference).max() <= found.error <= 1e-2


def test_gains_between_two_delays_in_series_do_not_matter_to_the_certificate():
    """k inside and 1 / k outside: the same loop, in other units of the signal between the delays."""
    lag = control.tf([1.0], [1.0, 1.0])
    errors = [pade_certificate(1 / k * delay(0.2) * (k * lag) * delay(0.3), 3).loop_error for k in (1e-6, 1.0, 1e6)]
    assert errors == pytest.approx([errors[1]] * 3, rel=3e-3)

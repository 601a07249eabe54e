"""Lyapunov-Krasovskii certificates against exact roots, exact rational arithmetic and published bounds."""

import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from random_systems import random_system

from flycontrol.delay.certificate import (
    certify_interval,
    check_matrices,
    largest_certified_delay,
    stability_certificate,
)
from flycontrol.delay.certificate.certify import certify
from flycontrol.delay.certificate.definite import definiteness
from flycontrol.delay.certificate.functional import dissipation, readings, storage
from flycontrol.delay.certificate.history import delayed_signals
from flycontrol.delay.interconnect import delay, feedback, series
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import characteristic_matrix, delay_lti
from flycontrol.errors import InvalidParameterError, UnstableSystemError

slow = pytest.mark.slow


def two_sensor_loop(T=0.0136, b=20.0, kp=900.0, kd=55.0):
    """psi'' = -b psi' - (kp psi + kd psi')(t - T): angle and rate are delayed each for itself, as two sensors would."""
    return delay_lti(
        A=[[0, 1], [0, -b]], B1=[[0], [1]], B2=[[0, 0], [-kp, -kd]], C1=np.eye(2), C2=np.eye(2), tau=[T, T]
    )


def standard_example(h=3.0):
    return delay_lti(
        A=[[-2, 0], [0, -0.9]], B1=[[0], [1]], B2=[[-1, 0], [-1, -1]], C1=np.eye(2), C2=np.eye(2), tau=[h, h]
    )


def delayed_integrator(h=1.0, gain=1.0):
    """x' = -gain x(t - h), stable for h < pi / 2 / gain."""
    return delay_lti(A=[[0]], B1=[[1]], B2=[[-gain]], C1=[[1]], C2=[[1]], tau=h)


def window(h=0.5):
    """x'' = 0.1 x' - 2 x + x(t - h): unstable without delay, stabilised by it (Seuret & Gouaisbaut 2015, example 2)."""
    return delay_lti(A=[[0, 1], [-2, 0.1]], B1=[[0], [1]], B2=[[0], [1]], C1=[[1, 0]], C2=[[1, 0]], tau=h)


def abscissa(system):
    return rightmost_roots(system, 1).abscissa


def with_delay(system, h):
    return replace(system, tau=np.full(system.n_delays, float(h)))


# ---- the published bounds ----


BOUNDS_MS = [(1, 30.20, 0.01), (2, 30.272, 1e-3), (3, 30.2732, 1e-4)]  # order, bound, its last digit


@pytest.mark.parametrize(
    ("order", "bound_ms", "digit"), [(0, 26.61, 0.01), *[pytest.param(*bound, marks=slow) for bound in BOUNDS_MS]]
)
def test_bounds_of_the_benchmark_loop_with_the_whole_state_remembered(order, bound_ms, digit):
    found = largest_certified_delay(two_sensor_loop(), order, full_history=True)
    assert found.proved
    assert 1e3 * found.high == pytest.approx(bound_ms, abs=0.5 * digit)


@pytest.mark.parametrize(("order", "bound_ms", "digit"), BOUNDS_MS)
def test_one_delayed_signal_gives_the_same_bounds_from_order_1_on(order, bound_ms, digit):
    found = largest_certified_delay(two_sensor_loop(), order)
    assert found.pieces[0].signals.sizes == (1,)
    assert 1e3 * found.high == pytest.approx(bound_ms, abs=0.5 * digit)


@pytest.mark.parametrize(
    ("order", "bound"), [(0, 4.4721), (3, 6.1725), *[pytest.param(*p, marks=slow) for p in [(1, 6.0593), (2, 6.1689)]]]
)
def test_bounds_of_the_standard_example(order, bound):
    assert largest_certified_delay(standard_example(), order).high == pytest.approx(bound, abs=5e-5)


def test_the_bound_on_a_delayed_integrator_rises_to_half_pi():
    bounds = [largest_certified_delay(delayed_integrator(), order).high for order in range(4)]
    assert bounds[0] == pytest.approx(np.sqrt(2.0), rel=2e-6)  # Jensen's inequality alone
    assert all(np.diff(bounds) > 0)
    assert np.pi / 2 * (1 - 2e-6) < bounds[3] < np.pi / 2


# ---- what a functional is ----


class Mode(NamedTuple):
    """The solution exp(s t) x0 of a system at t = 0, with the signals' past v(theta) = z exp(-s h theta)."""

    s: complex
    state: np.ndarray
    signals: np.ndarray
    delays: np.ndarray

    @property
    def past(self):
        return lambda theta: self.signals[:, None] * np.exp(-self.s * np.outer(self.delays, theta))


def slowest_mode(system, signals):
    root = rightmost_roots(system, 1).roots[0]
    state = np.linalg.svd(characteristic_matrix(system, root))[2][-1, : system.n_states].conj()
    return Mode(root, state, signals.C @ state, signals.each(signals.delays))


def legendre(k, theta):
    return np.polynomial.legendre.Legendre.basis(k)(2 * theta - 1)


def random_functional(rng, signals, order):
    rows, q = signals.A.shape[0] + order * sum(signals.sizes), sum(signals.sizes)
    same_delay = np.equal.outer(signals.each(signals.delays), signals.each(signals.delays))
    P, S, R = (g @ g.T for g in (rng.normal(size=(k, k)) for k in (rows, q, q)))
    return P, S * same_delay, R * same_delay


def functional_by_quadrature(mode, order, P, S, R):
    """V as it is defined, its integrals by Gauss quadrature."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    theta, weights = (nodes + 1) / 2, weights / 2
    ratio = mode.delays / mode.delays.max()
    v = mode.past(theta)
    slope = -mode.s * mode.delays[:, None] * v
    projections = [ratio * ((v * legendre(k, theta)) @ weights) for k in range(order)]
    X = np.concatenate([mode.state, *projections])
    density = np.einsum("it,ij,jt->t", v.conj(), np.diag(ratio) @ S, v)
    density = density + (1 - theta) * np.einsum("it,ij,jt->t", slope.conj(), np.diag(ratio) @ R, slope)
    return (X.conj() @ P @ X + density @ weights).real


def form_at(mode, signals, order, P, S, R):
    nodes, weights = np.polynomial.legendre.leggauss(60)
    theta, weights = (nodes + 1) / 2, weights / 2
    v = mode.past(theta)
    zeta = [(v * legendre(k, theta)) @ weights for k in range(order)]
    xi = np.concatenate([mode.state, mode.signals * np.exp(-mode.s * mode.delays), *zeta])
    Q = dissipation(readings(signals, signals.delays, float(signals.delays.max()), order), P, S, R)
    return (xi.conj() @ Q @ xi).real


@pytest.mark.parametrize("seed", range(12))
def test_the_form_bounds_the_derivative_of_the_functional_along_an_exact_solution(seed):
    system = random_system(seed, states=3, delays=2, chained=True)
    signals = delayed_signals(system)
    mode = slowest_mode(system, signals)
    unit = float(signals.delays.max())
    for order in (0, 1, 2, 4):
        P, S, R = random_functional(np.random.default_rng(seed), signals, order)
        V = functional_by_quadrature(mode, order, P, S, R)
        rate = 2 * mode.s.real * unit * V  # V runs like exp(2 Re(s) t)
        assert rate <= -form_at(mode, signals, order, P, S, R) + 1e-10 * (abs(rate) + V)


@pytest.mark.parametrize("seed", range(6))
def test_at_high_order_nothing_of_the_derivative_is_given_away(seed):
    system = random_system(seed, states=3, delays=2, chained=True)
    signals = delayed_signals(system)
    mode = slowest_mode(system, signals)
    order = 18  # Legendre coefficients of exp(-s h theta) are at rounding there
    P, S, R = random_functional(np.random.default_rng(seed), signals, order)
    V = functional_by_quadrature(mode, order, P, S, R)
    rate = 2 * mode.s.real * float(signals.delays.max()) * V
    assert -form_at(mode, signals, order, P, S, R) == pytest.approx(rate, abs=1e-9 * (abs(rate) + V))


# ---- the check against exact rational arithmetic ----


def exact(matrix):
    return np.array([Fraction(float(entry)) for entry in np.ravel(matrix)], dtype=object).reshape(np.shape(matrix))


def positive_definite_exactly(matrix):
    """All pivots of Gauss's elimination in rational numbers are positive."""
    rest = matrix.copy()
    while len(rest):
        if not rest[0, 0] > 0:
            return False
        rest = rest[1:, 1:] - np.outer(rest[1:, 0], rest[0, 1:]) / rest[0, 0]
    return True


def theorem_5(certificate):
    """Theta_N and -Phi_N of Seuret & Gouaisbaut 2015, Theorem 5, in their notation and in rational numbers, time in h.

    Their Legendre polynomials run from now to the past's end with L_k(0) = 1, so that odd projections change sign.
    """
    c, N = certificate, certificate.order
    n = len(c.signals.A)
    h = Fraction(float(c.high[0]))
    A, A_d = h * exact(c.signals.A), h * exact(c.signals.B) @ exact(c.signals.C)
    eye, nothing = exact(np.eye(n)), exact(np.zeros((n, n)))
    flip = np.repeat([(-1) ** max(0, k - 1) for k in range(N + 1)], n)
    P, S, R = exact(c.P) * np.outer(flip, flip), exact(c.S), exact(c.R)

    def gamma(k):
        def entry(i):
            return -(2 * i + 1) * (1 - (-1) ** (k + i)) if i <= k else 0

        return np.hstack([eye, -((-1) ** k) * eye, *[entry(i) * eye for i in range(N)]])

    F = np.hstack([A, A_d, *[nothing] * N])
    G = np.vstack([
        np.hstack([eye, nothing, *[nothing] * N]),
        *[np.hstack([nothing, nothing, *[eye if i == k else nothing for i in range(N)]]) for k in range(N)],
    ])  # fmt: skip
    H = np.vstack([F, *[gamma(k) for k in range(N)]])
    Phi = G.T @ P @ H
    Phi = Phi + Phi.T + F.T @ R @ F
    Phi[:n, :n] += S
    Phi[n : 2 * n, n : 2 * n] -= S
    for k in range(N + 1):
        Phi = Phi - (2 * k + 1) * gamma(k).T @ R @ gamma(k)
    Theta = P.copy()
    for k in range(N):
        place = slice(n * (k + 1), n * (k + 2))
        Theta[place, place] += (2 * k + 1) * S
    return Theta, -Phi


@pytest.mark.parametrize("order", range(4))
@pytest.mark.parametrize(("system", "delays"), [(standard_example, (1.0, 4.4)), (two_sensor_loop, (0.0136, 0.0266))])
def test_what_is_proved_satisfies_the_published_theorem_in_exact_rational_arithmetic(system, delays, order):
    for h in delays:
        certificate = stability_certificate(system(h), order, full_history=True)
        assert certificate.proved
        Theta, minus_Phi = theorem_5(certificate)
        for matrix in (Theta, minus_Phi, exact(certificate.S), exact(certificate.R)):
            assert positive_definite_exactly(matrix)


def test_at_the_largest_certified_delay_the_proof_still_stands_in_exact_rational_arithmetic():
    certificate = largest_certified_delay(standard_example(), 2, full_history=True).pieces[-1]
    Theta, minus_Phi = theorem_5(certificate)
    assert positive_definite_exactly(Theta)
    assert positive_definite_exactly(minus_Phi)


def test_a_matrix_is_called_positive_only_if_it_is_in_exact_rational_arithmetic():
    rng = np.random.default_rng(7)
    verdicts = []
    for exponent in np.linspace(-18, -12, 200):  # smallest eigenvalues around the rounding, of either sign
        U = np.linalg.qr(rng.normal(size=(5, 5)))[0]
        smallest = float(10**exponent) * rng.choice([-1, 1])
        M = (U * [1, 1, 1, 1, smallest]) @ U.T
        M = (M + M.T) / 2
        found = definiteness("M", M, np.zeros_like(M))
        verdicts.append(found.proved)
        assert not found.proved or positive_definite_exactly(exact(M))
        assert found.proved or found.smallest_eigenvalue < 3 * found.margin
    assert any(verdicts)
    assert not all(verdicts)


def test_an_uncertain_entry_takes_its_size_from_the_smallest_eigenvalue():
    M, error = np.diag([1.0, 1e-3]), np.array([[0, 1e-2], [1e-2, 0]])
    assert definiteness("M", M, 0 * error).proved
    assert not definiteness("M", M, error).proved


# ---- a solver's word is not enough ----


@pytest.mark.parametrize("solver", ["SCS", "CLARABEL"])
def test_a_solver_calls_an_impossible_delay_feasible_and_the_check_does_not(solver):
    import cvxpy as cp

    if solver not in cp.installed_solvers():
        pytest.skip(f"{solver} is not installed.")
    signals = delayed_signals(delayed_integrator(3.00005, np.pi / 6))  # exactly stable below 3 s
    order, unit = 3, 3.00005
    r = readings(signals, signals.delays, unit, order)
    P, S, R = cp.Variable((4, 4), symmetric=True), cp.Variable((1, 1)), cp.Variable((1, 1))
    storing = r.state.T @ P @ r.rate
    Q = r.exit.T @ S @ r.exit - r.entry.T @ S @ r.entry - r.slope.T @ R @ r.slope - storing - storing.T
    Q = Q + sum((2 * k + 1) * (mode.T @ R @ mode) for k, mode in enumerate(r.modes))
    floor = 1e-6 * np.eye(4)
    problem = cp.Problem(cp.Minimize(0), [P >> floor, S >= 1e-6, R >= 1e-6, Q >> 0, cp.trace(P) <= 1])
    problem.solve(solver=solver)
    assert problem.status == "optimal"  # the solver is content
    unchecked = certify(signals, signals.delays, signals.delays, order, "CLARABEL")
    claimed = replace(unchecked, P=P.value, S=S.value, R=R.value)
    assert not all(check.proved for check in check_matrices(claimed))


def test_a_solver_that_gives_no_matrices_proves_nothing():
    certificate = stability_certificate(two_sensor_loop(), 1, solver="OSQP")  # knows no semidefinite programs
    assert not certificate.proved
    assert "no matrices" in certificate.status


def test_coupling_between_different_delays_does_not_count():
    system = delay_lti(A=[[-1.0]], B1=[[1]], B2=[[-1.0, -1.0]], C1=[[1]], C2=[[1], [1]], tau=[0.3, 0.7])
    certificate = stability_certificate(system, 1)
    coupled = replace(certificate, S=certificate.S + np.array([[0, 10], [10, 0]]))
    assert check_matrices(coupled) == certificate.checks


def test_the_check_needs_nothing_but_the_matrices():
    certificate = stability_certificate(two_sensor_loop(), 2)
    assert check_matrices(certificate) == certificate.checks
    tampered = replace(certificate, R=100 * certificate.R)
    assert not all(check.proved for check in check_matrices(tampered))


def test_matrices_come_in_the_units_of_the_system_and_read_only():
    certificate = stability_certificate(two_sensor_loop(), 2)
    c, unit = certificate, float(certificate.high[0])
    r = readings(c.signals, c.high, unit, c.order)
    assert np.linalg.eigvalsh(storage(r, np.ones(1), c.P, c.S))[0] > 0
    assert np.linalg.eigvalsh(dissipation(r, c.P, c.S, c.R))[0] > 0
    with pytest.raises(ValueError, match="read-only"):
        c.P[0, 0] = 0.0


# ---- a certificate never says more than the exact spectrum ----


def loops_stable_without_delay(count):
    """Random loops with one delay, stable when it is zero."""
    rng = np.random.default_rng(2015)
    seeds = iter(range(10_000))
    found = []
    while len(found) < count:
        n, q = int(rng.integers(1, 4)), int(rng.integers(1, 3))
        system = random_system(next(seeds), states=n, delays=q)
        if np.linalg.eigvals(system.A + system.B2 @ system.C2).real.max() < -0.05:
            found.append(with_delay(system, rng.uniform(0.05, 1.5)))
    return found


def check_against_the_spectrum(system):
    found = largest_certified_delay(system, 3, up_to=20.0, tolerance=1e-4)
    assert found.proved
    for h in np.linspace(0.02, 1.0, 7) * found.high:
        assert abscissa(with_delay(system, h)) < 0
    if found.high < 20.0:  # some loops stay stable with any delay
        first_crossing = next(
            (h for h in found.high * np.linspace(1.0, 1.25, 26)[1:] if abscissa(with_delay(system, h)) > 0), None
        )
        assert first_crossing is not None, "order 3 should come within a quarter of the exact bound"


@pytest.mark.parametrize("index", range(2))
def test_no_certified_delay_exceeds_the_exact_bound_on_a_few_random_loops(index):
    check_against_the_spectrum(loops_stable_without_delay(2)[index])


@slow
@pytest.mark.parametrize("index", range(2, 40))
def test_no_certified_delay_exceeds_the_exact_bound_on_random_loops(index):
    check_against_the_spectrum(loops_stable_without_delay(40)[index])


@slow
@pytest.mark.parametrize("index", range(10))
def test_the_bound_rises_with_the_order(index):
    system = loops_stable_without_delay(10)[index]
    bounds = [largest_certified_delay(system, order, up_to=20.0, tolerance=1e-4).high for order in range(4)]
    assert all(np.diff(bounds) > -2e-4 * np.array(bounds[1:]))  # twice the tolerance of the search


# ---- intervals ----


def test_matrices_of_an_interval_prove_every_delay_inside():
    piece = certify_interval(standard_example(), 0.0, 6.1, 2).pieces[0]
    for h in (1e-6, 0.5, 2.0, 4.4, 6.05):
        r = readings(piece.signals, np.array([h]), float(piece.high[0]), piece.order)
        assert np.linalg.eigvalsh(dissipation(r, piece.P, piece.S, piece.R))[0] > 0


def test_a_window_of_stabilising_delays_is_covered_by_pieces_without_gaps():
    found = certify_interval(window(), 0.11, 1.7, 4)
    assert found.proved
    assert len(found.pieces) > 1
    ends = [(float(piece.low[0]), float(piece.high[0])) for piece in found.pieces]
    assert ends[0][0] == 0.11
    assert ends[-1][1] == 1.7
    assert all(left[1] == right[0] for left, right in pairwise(ends))


@slow
def test_the_largest_delay_of_a_window_is_reached_piece_by_piece():
    found = largest_certified_delay(window(), 4, low=0.2)
    assert found.high == pytest.approx(1.7178, abs=1e-4)
    assert abscissa(window(found.high)) < 0 < abscissa(window(1.7180))


def test_an_interval_with_an_unstable_delay_between_stable_ends_is_not_proved():
    """x'' = -0.1 x' - x + 0.3 x(t - h): stable about h = 2 and again about h = 8."""
    swinging = delay_lti(A=[[0, 1], [-1, -0.1]], B1=[[0], [1]], B2=[[0], [0.3]], C1=[[1, 0]], C2=[[1, 0]], tau=2.0)
    assert abscissa(with_delay(swinging, 2.0)) < 0 < abscissa(with_delay(swinging, 4.7))
    assert abscissa(with_delay(swinging, 8.0)) < 0
    assert stability_certificate(with_delay(swinging, 2.0), 4).proved
    assert not certify_interval(swinging, 2.0, 8.0, 4).proved


def test_two_equal_delays_in_series_count_as_their_sum():
    plant = delay_lti(A=[[0]], B1=[[1]], C1=[[1]])
    loop = feedback(series(series(plant, delay(0.3)), delay(0.3)))
    found = largest_certified_delay(loop, 3)
    assert found.high == pytest.approx(np.pi / 4, rel=3e-6)
    assert found.pieces[0].signals.delays == pytest.approx([0.6])


def test_several_delays_are_certified_as_they_are():
    system = delay_lti(A=[[-1.0]], B1=[[1]], B2=[[-1.0, -1.0]], C1=[[1]], C2=[[1], [1]], tau=[0.3, 0.7])
    certificate = stability_certificate(system, 3)
    assert certificate.proved
    assert "delays of 0.3 and 0.7 s" in certificate.status
    assert certificate.S.shape == (2, 2)
    assert certificate.S[0, 1] == 0  # signals of different delays are not coupled
    with pytest.raises(InvalidParameterError, match="one delay"):
        certify_interval(system, 0.0, 1.0)


def test_a_loop_stable_for_any_delay_is_certified_to_the_end_of_the_search():
    always_stable = delay_lti(A=[[-2]], B1=[[1]], B2=[[-1]], C1=[[1]], C2=[[1]], tau=1.0)
    found = largest_certified_delay(always_stable, 1, up_to=50.0)
    assert found.high == 50.0
    assert "search ended" in found.status


def test_a_search_that_starts_where_the_order_proves_nothing_says_so():
    found = largest_certified_delay(window(), 0, low=0.2, tolerance=1e-2)  # Jensen's inequality needs stability at 0
    assert not found.proved
    assert "proves nothing" in found.status


# ---- delayed signals ----


@pytest.mark.parametrize("seed", range(8))
def test_the_delayed_signals_have_the_roots_of_the_system(seed):
    system = random_system(seed, states=3, delays=3, chained=True)
    signals = delayed_signals(system)
    for root in rightmost_roots(system, 4).roots:
        factor = np.exp(-root * signals.each(signals.delays))
        reduced = root * np.eye(3) - signals.A - (signals.B * factor) @ signals.C
        values = np.linalg.svd(reduced, compute_uv=False)
        assert values[-1] < 1e-10 * values[0]


def test_a_delayed_feedback_of_two_states_to_one_input_is_one_signal():
    signals = delayed_signals(two_sensor_loop())
    assert signals.sizes == (1,)
    assert np.array_equal(signals.B @ signals.C, [[0, 0], [-900, -55]])


# ---- refusals ----


def test_an_unstable_loop_is_refused_with_its_root():
    with pytest.raises(
        UnstableSystemError, match=r"No certificate of stability can exist at a delay of 0\.031 s.*root"
    ):
        stability_certificate(two_sensor_loop(0.031))
    with pytest.raises(UnstableSystemError, match="without delay"):
        largest_certified_delay(window())
    with pytest.raises(UnstableSystemError, match=r"delay of 2\.0 s"):
        certify_interval(window(), 0.2, 2.0)


def test_a_root_at_the_origin_rules_a_certificate_out():
    drifting = delay_lti(
        A=np.zeros((2, 2)), B1=[[1], [0]], B2=[[-1], [0]], C1=[[1, 0]], C2=[[1, 0]], tau=0.5
    )  # a second state that nothing moves
    with pytest.raises(UnstableSystemError, match="on the imaginary axis"):
        stability_certificate(drifting)


def test_infeasibility_is_said_to_prove_nothing():
    certificate = stability_certificate(two_sensor_loop(0.029), 0)  # stable up to 30.27 ms, but order 0 ends at 25.7 ms
    assert not certificate.proved
    assert "proves nothing about the loop" in certificate.status
    assert "higher order" in certificate.status


def test_a_system_without_a_delay_that_acts_is_refused():
    with pytest.raises(InvalidParameterError, match="eigenvalues of A"):
        stability_certificate(delay_lti(A=[[-1]], B1=[[1]], C1=[[1]]))
    with pytest.raises(InvalidParameterError, match="eigenvalues of A"):
        stability_certificate(delay(0.1))


@pytest.mark.parametrize("order", [-1, 1.5, "three"])
def test_an_order_that_is_no_number_of_projections_is_refused(order):
    with pytest.raises(InvalidParameterError, match="integer >= 0"):
        stability_certificate(two_sensor_loop(), order)


@pytest.mark.parametrize(("low", "high"), [(-0.1, 1.0), (1.0, 1.0), (0.0, np.nan), (0.0, np.inf)])
def test_an_impossible_interval_is_refused(low, high):
    with pytest.raises(InvalidParameterError, match="0 <= low < high"):
        certify_interval(delayed_integrator(), low, high)


def test_a_search_without_room_is_refused():
    with pytest.raises(InvalidParameterError, match="low < up_to"):
        largest_certified_delay(delayed_integrator(), low=0.5, up_to=0.5)


def test_an_unknown_solver_is_refused():
    with pytest.raises(InvalidParameterError, match="not installed"):
        stability_certificate(two_sensor_loop(), solver="ORACLE")


def test_importing_certificates_does_not_import_the_solver():
    code = "import sys, flycontrol.delay.certificate; sys.exit('cvxpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0

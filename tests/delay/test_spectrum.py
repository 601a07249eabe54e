import control
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pd_loop import newton_step, pd_closed
from random_systems import drawn_alike, random_system, random_systems
from scipy.optimize import brentq
from scipy.special import lambertw

from flycontrol.delay.interconnect import append, delay, feedback
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import DelayLTI, delay_lti


def distance_to_root(system: DelayLTI, root: complex) -> float:
    """|f / f'| of the characteristic determinant in 40 digits."""
    with mpmath.workdps(40):
        n, q = system.n_states, system.n_delays

        def f(s):
            M = mpmath.matrix(n + q, n + q)
            lag = [mpmath.exp(-s * mpmath.mpf(float(tau))) for tau in system.tau]
            for i in range(n):
                for j in range(n):
                    M[i, j] = (s if i == j else 0) - mpmath.mpf(float(system.A[i, j]))
                for j in range(q):
                    M[i, n + j] = -mpmath.mpf(float(system.B2[i, j]))
            for i in range(q):
                for j in range(n):
                    M[n + i, j] = -lag[i] * mpmath.mpf(float(system.C2[i, j]))
                for j in range(q):
                    M[n + i, n + j] = (1 if i == j else 0) - lag[i] * mpmath.mpf(float(system.D22[i, j]))
            return mpmath.det(M)

        s = mpmath.mpc(root)
        return float(abs(f(s) / mpmath.diff(f, s, h=mpmath.mpf(10) ** -15)))


def fastest_decay(b: float, T: float) -> tuple[float, float, float]:
    """Gains at which three real roots meet, and where."""
    s0 = (-(b * T + 4) + np.sqrt(b**2 * T**2 + 8)) / (2 * T)
    kd = -np.exp(s0 * T) * (T * (s0**2 + b * s0) + 2 * s0 + b)
    return -(s0**2 + b * s0) * np.exp(s0 * T) - kd * s0, kd, s0


@pytest.mark.parametrize("kT", [0.05, 0.3, 0.5, 1.0, np.pi / 2, 2.0, 20.0])
def test_roots_of_a_delayed_integrator_are_branches_of_lambert_w(kT):
    """s = -k exp(-s T) has the roots W_j(-k T) / T."""
    k, T = kT / 0.25, 0.25
    system = delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[-k]], C1=[[1.0]], C2=[[1.0]], tau=[T])
    found = rightmost_roots(system, 12)
    exact = np.array([lambertw(-kT, j) / T for j in range(-8, 8)])
    exact = exact[np.argsort(-exact.real, kind="stable")][: len(found.roots)]
    assert found.status == "certified"
    for root in exact:
        assert np.abs(found.roots - root).min() < 1e-12 * abs(root)


@pytest.mark.parametrize(
    ("b", "kp", "kd", "T", "count"),
    [
        (20.0, 900.0, 55.0, 0.0136, 40),
        (69.0, 3050.0, 45.0, 3 / 220, 40),
        (69.0, 3050.0, 45.0, 0.2, 40),  # far beyond the largest stable delay: a dozen unstable pairs
        (0.01, 1e-4, 0.02, 50.0, 40),  # seconds instead of milliseconds
        (1e-3, 1e6, 1.0, 1e-3, 40),  # hardly damped
        (176.0, 1.0, 0.0, 0.0136, 2),  # one root next to the origin, one near -b, the others fourteen delays away
    ],
)
def test_each_root_satisfies_the_characteristic_equation(b, kp, kd, T, count):
    found = rightmost_roots(pd_closed(b, kp, kd, T), count)
    assert len(found.roots) >= count
    assert max(newton_step(root, b, kp, kd, T) / abs(root) for root in found.roots) < 1e-12


def test_as_many_roots_are_given_as_were_asked_for_or_the_status_says_so():
    found = rightmost_roots(pd_closed(176.0, 1.0, 0.0, 0.0136), 10)
    assert len(found.roots) >= 10 or found.status != "certified"


@pytest.mark.parametrize("seed", range(8))
def test_roots_of_random_systems_are_roots_in_forty_digits(seed):
    system = random_system(seed, 1 + seed % 4, 1 + seed % 3, chained=seed % 2 == 0)
    found = rightmost_roots(system, 8)
    assert found.status == "certified"
    # simple roots, but the determinant of a random matrix may be ill conditioned: a hundredfold of rounding is allowed
    assert max(distance_to_root(system, root) / abs(root) for root in found.roots) < 1e-12


def test_delays_a_thousandfold_apart_are_resolved_together():
    system = delay_lti(
        A=[[-3.0]], B1=[[1.0]], B2=[[-1.0, -2.0]], C1=[[1.0]], C2=[[1.0], [1.0]], tau=[0.002, 2.0]
    )  # fmt: skip
    found = rightmost_roots(system, 10)
    assert found.status == "certified"
    assert max(distance_to_root(system, root) / abs(root) for root in found.roots) < 1e-12


@pytest.mark.parametrize(("b", "T"), [(69.0, 0.0136), (20.0, 0.0136), (0.0, 1.0), (3.0, 0.7)])
def test_at_the_gains_of_fastest_decay_three_roots_meet(b, T):
    kp, kd, s0 = fastest_decay(b, T)
    roots = rightmost_roots(pd_closed(b, kp, kd, T), 3).roots
    # a triple root moves by the cube root of rounding, eps^(1/3) = 6e-6, and an eigenvalue solver by 5e-5
    assert np.abs(roots[:3] - s0).max() < 1e-4 * abs(s0)


def test_the_standard_example_of_two_states_loses_stability_at_its_known_delay():
    """x' = [[-2, 0], [0, -0.9]] x + [[-1, 0], [-1, -1]] x(t - h) is stable up to h = 6.1726."""

    def abscissa(h):
        return rightmost_roots(
            delay_lti(
                A=[[-2.0, 0.0], [0.0, -0.9]], B1=np.zeros((2, 1)), B2=[[-1.0, 0.0], [-1.0, -1.0]], C1=[[1.0, 0.0]],
                C2=np.eye(2), tau=[h, h],
            )
        ).abscissa  # fmt: skip

    # the second state alone decides: w^2 = 1 - 0.9^2, h = acos(-0.9) / w
    exact = np.arccos(-0.9) / np.sqrt(1 - 0.9**2)
    found = brentq(abscissa, 5.0, 7.0, xtol=1e-12)
    assert found == pytest.approx(exact, rel=1e-11)
    assert f"{found:.4f}" in ("6.1725", "6.1726")


@drawn_alike
@given(random_systems(chained=True), st.floats(1e-3, 1e3))
def test_roots_scale_with_the_unit_of_time(system, scale):
    faster = delay_lti(
        A=system.A * scale, B1=system.B1, B2=system.B2 * scale, C1=system.C1, C2=system.C2, D12=system.D12,
        D21=system.D21, D22=system.D22, tau=system.tau / scale,
    )  # fmt: skip
    slow, fast = rightmost_roots(system, 6), rightmost_roots(faster, 6)
    size = np.abs(slow.roots).max()
    many = min(len(slow.roots), len(fast.roots))
    np.testing.assert_allclose(fast.roots[:many] / scale, slow.roots[:many], atol=1e-9 * size)


@drawn_alike
@given(random_systems(states=3, delays=2), st.floats(-3.0, 1.0))
def test_a_state_beside_the_system_adds_its_own_pole_and_no_other(system, pole):
    beside = append(system, delay_lti(A=[[pole]], B1=[[0.0]], C1=[[0.0]]))
    alone, together = rightmost_roots(system, 4), rightmost_roots(beside, 6)
    assert together.status == "certified"
    expected = np.append(alone.roots, pole)
    for root in expected[expected.real > together.line]:
        assert np.abs(together.roots - root).min() < 1e-7 * (1 + abs(root))


@drawn_alike
@given(random_systems(chained=True))
def test_roots_come_in_conjugate_pairs_by_falling_real_part(system):
    found = rightmost_roots(system, 7)
    roots = found.roots
    assert (np.diff(roots.real) < 1e-9 * np.abs(roots).max()).all()
    complex_ones = roots[roots.imag != 0]
    np.testing.assert_array_equal(complex_ones[0::2], complex_ones[1::2].conj())
    assert (complex_ones[0::2].imag > 0).all()
    assert (roots.real > found.line).all()


def test_without_delay_the_roots_are_the_eigenvalues_of_a():
    system = random_system(3, 4, 0)
    found = rightmost_roots(system, 10)
    assert found.status == "certified"
    np.testing.assert_allclose(np.sort_complex(found.roots), np.sort_complex(np.linalg.eigvals(system.A)), rtol=1e-13)


def test_a_delayed_signal_that_reaches_no_state_adds_no_root():
    system = delay_lti(A=[[-2.0]], B1=[[1.0]], C1=[[1.0]], C2=[[1.0]], D12=[[1.0]], tau=[0.3])
    np.testing.assert_allclose(rightmost_roots(system, 5).roots, [-2.0], rtol=1e-12)


def test_two_delays_in_series_around_a_loop_have_the_roots_of_one_delay_of_their_sum():
    """psi'' = -psi' - 10 psi(t - 0.15), the delay once whole and once as a chain of 0.05 and 0.1."""
    split = delay_lti(
        A=[[0.0, 1.0], [0.0, -1.0]], B1=[[0.0], [1.0]], B2=[[0.0, 0.0], [0.0, -1.0]], C1=[[0.0, 0.0]],
        C2=[[10.0, 0.0], [0.0, 0.0]], D12=[[0.0, 1.0]], D22=[[0.0, 0.0], [1.0, 0.0]], tau=[0.05, 0.1],
    )  # fmt: skip
    whole = pd_closed(1.0, 10.0, 0.0, 0.15)
    np.testing.assert_allclose(rightmost_roots(split, 6).roots, rightmost_roots(whole, 6).roots, rtol=1e-10)


@pytest.mark.slow
def test_a_loop_whose_roots_are_out_of_reach_has_no_abscissa_rather_than_a_stable_one():
    """The gain of 1e50 puts roots where no count can be afforded."""
    found = rightmost_roots(feedback(control.tf([1e50], [1.0, 1.0]) * delay(1.0)), 3)
    assert not found.certified
    assert np.isnan(found.abscissa)


@pytest.mark.slow
def test_no_more_roots_are_returned_than_asked_for_but_for_a_conjugate():
    found = rightmost_roots(feedback(control.tf([2.0], [1.0, 1.0]) * delay(1e6)), 8)
    assert len(found.roots) <= 9
    assert found.certified == found.status.startswith("certified")


def test_certified_is_what_the_status_says():
    assert rightmost_roots(delay(0.3) * control.tf([1.0], [1.0, 1.0]), 1).certified
    assert not rightmost_roots(feedback(delay(0.3) * control.tf([1.0], [1.0, 1.0])), 1, certify=False).certified

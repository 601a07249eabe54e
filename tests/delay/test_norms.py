import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pd_loop import pd_closed
from random_systems import drawn_alike, random_system
from scipy.linalg import solve_continuous_lyapunov

from flycontrol.delay.convert import from_control
from flycontrol.delay.expansion import expansion
from flycontrol.delay.interconnect import append, delay, feedback, parallel, series
from flycontrol.delay.norms import h2_norm, hinf_norm, linfnorm, system_norm
from flycontrol.delay.peak_gain import peak_between
from flycontrol.delay.response import response
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import DelayLTI, delay_lti
from flycontrol.errors import InvalidParameterError, UnstableSystemError


def stable_systems(count: int, inputs: int = 1, outputs: int = 1) -> list[DelayLTI]:
    """Random systems with delays in their dynamics, at inputs and at outputs, decaying at 0.05 1/s or faster."""
    found: list[DelayLTI] = []
    seed = 0
    while len(found) < count:
        drawn = random_system(seed, 1 + seed % 4, 1 + seed % 3, inputs, outputs, chained=True)
        damped = delay_lti(
            A=drawn.A - 2 * np.eye(drawn.n_states), B1=drawn.B1, B2=drawn.B2, C1=drawn.C1, C2=drawn.C2,
            D12=drawn.D12, D22=drawn.D22, tau=drawn.tau,
        )  # fmt: skip
        if rightmost_roots(damped, 1).abscissa < -0.05:
            found.append(damped)
        seed += 1
    return found


def gains(system: DelayLTI, omega: np.ndarray) -> np.ndarray:
    return np.linalg.norm(system(1j * omega), 2, axis=(1, 2))


@pytest.mark.parametrize(("inputs", "outputs"), [(1, 1), (2, 1), (2, 3)])
def test_the_hinf_norm_is_the_largest_gain_by_brute_force(inputs, outputs):
    omega = np.linspace(0.0, 60.0, 30_001)
    for system in stable_systems(12, inputs, outputs):
        found, dense = hinf_norm(system), gains(system, omega).max()
        assert found.status == "certified"
        assert dense <= found.upper * (1 + 1e-12)
        assert found.lower == pytest.approx(gains(system, np.array([found.frequency]))[0], rel=1e-10)
        # the grid's spacing of 2 ms^-1 misses the top of a peak of unit width by less
        assert dense >= found.lower * (1 - 1e-4)
        assert found.upper <= found.lower * (1 + 1e-6)


@pytest.mark.parametrize("tol", [1e-3, 1e-9])
def test_the_bounds_enclose_to_the_accuracy_that_is_asked_for(tol):
    for system in stable_systems(4):
        exact = hinf_norm(system, 1e-10)
        found = hinf_norm(system, tol)
        assert found.lower <= exact.upper
        assert found.upper >= exact.lower
        assert found.upper <= found.lower * (1 + tol)


@pytest.mark.parametrize("damping", [1e-2, 1e-4, 1e-6])
def test_a_narrow_resonance_has_the_peak_of_the_textbook(damping):
    """1 / (2 z sqrt(1 - z^2)) at sqrt(1 - 2 z^2) for 1 / (s^2 + 2 z s + 1), also behind a delay."""
    plant = from_control(control.tf([1.0], [1.0, 2 * damping, 1.0])) * delay(3.0)
    found = hinf_norm(plant)
    assert found.lower == pytest.approx(1 / (2 * damping * np.sqrt(1 - damping**2)), rel=1e-9)
    assert found.frequency == pytest.approx(np.sqrt(1 - 2 * damping**2), rel=1e-7)


@drawn_alike
@given(st.integers(0, 2**32 - 1), st.integers(1, 5))
def test_without_delay_norms_are_those_of_the_hamiltonian_and_of_lyapunovs_equation(seed, n):
    rng = np.random.default_rng(seed)
    A, B, C = rng.normal(size=(n, n)), rng.normal(size=(n, 2)), rng.normal(size=(2, n))
    A -= (np.linalg.eigvals(A).real.max() + 0.1) * np.eye(n)
    system = delay_lti(A=A, B1=B, C1=C)
    P = solve_continuous_lyapunov(A, -B @ B.T)
    assert h2_norm(system).value == pytest.approx(np.sqrt(np.trace(C @ P @ C.T)), rel=1e-8)
    found = hinf_norm(system)
    for gamma, crossed in ((found.lower * (1 - 1e-7), True), (found.upper * (1 + 1e-7), False)):
        hamiltonian = np.block([[A, B @ B.T / gamma], [-C.T @ C / gamma, -A.T]])
        distance = np.abs(np.linalg.eigvals(hamiltonian).real).min() / np.abs(hamiltonian).max()
        assert (distance < 1e-9) == crossed or 1e-10 < distance < 1e-6  # a touch is known to the root of rounding


@pytest.mark.parametrize(
    "plant", [([2.0, 1.0], [1.0, 3.0, 5.0]), ([1.0], [1.0, 0.1, 4.0]), ([1.0, -4.0], [1.0, 2.0, 9.0, 1.0])]
)
def test_without_delay_norms_are_those_of_python_control(plant):
    theirs = control.tf(*plant)
    ours = from_control(theirs)
    assert system_norm(ours) == pytest.approx(control.system_norm(theirs, 2, print_warning=False), rel=1e-6)
    # both have a default tolerance of 1e-6
    assert system_norm(ours, "inf") == pytest.approx(control.system_norm(theirs, "inf", print_warning=False), rel=3e-6)


@pytest.mark.parametrize("gain", [0.1, 0.5, 1.0, 1.5, 1.57])
def test_the_h2_norm_of_a_delayed_integrator_loop_is_that_of_kuechler_and_mensch(gain):
    """x' = -k x(t - 1) + u: the variance under white noise is (1 + sin k) / (2 k cos k)."""
    system = delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[-gain]], C1=[[1.0]], C2=[[1.0]], tau=[1.0])
    found, exact = h2_norm(system, 1e-9), np.sqrt((1 + np.sin(gain)) / (2 * gain * np.cos(gain)))
    assert abs(found.value - exact) <= found.error + 1e-13 * exact
    assert found.error < 1e-9 * exact


def impulse_energy(system: DelayLTI) -> float:
    """Energy of the derivative of the step responses, panel by panel, until the slowest mode has decayed by e^-40."""
    end = -20.0 / rightmost_roots(system, 1).abscissa
    x, weight = np.polynomial.legendre.leggauss(24)
    total = 0.0
    for unit in np.eye(system.n_inputs):
        found = response(system, end, inputs=unit[None, :])
        for length, panel in zip(found.lengths, found.series, strict=True):
            for series_of_output in panel:
                slope = np.polynomial.Chebyshev(series_of_output).deriv()(x) * 2 / length
                total += float(weight @ slope**2) * length / 2
    return total


@pytest.mark.parametrize(("inputs", "outputs"), [(1, 1), (2, 2)])
def test_the_h2_norm_is_the_energy_of_the_impulse_response(inputs, outputs):
    """Two computations with nothing in common: an integral over frequency, and the method of steps."""
    for system in stable_systems(5, inputs, outputs):
        found = h2_norm(system)
        assert found.status == "certified"
        assert found.value**2 == pytest.approx(impulse_energy(system), rel=1e-7)


def test_the_h2_norm_of_the_benchmark_loop_is_the_energy_of_its_impulse_response():
    assert h2_norm(pd_closed()).value ** 2 == pytest.approx(impulse_energy(pd_closed()), rel=1e-8)


@pytest.mark.parametrize(
    "system",
    [
        delay_lti(A=[[-1.0]], B1=[[1.0]], C1=[[1.0]], D11=[[0.1]]),
        parallel(delay_lti(A=[[-1.0]], B1=[[1.0]], C1=[[1.0]]), 1e-3 * delay(0.2)),
        series(delay(0.1), delay(0.2)),
    ],
)
def test_any_feedthrough_makes_the_h2_norm_infinite_and_says_so(system):
    found = h2_norm(system)
    assert found.value == np.inf
    assert "directly, delayed or not" in found.status
    assert system_norm(system) == np.inf


def test_feedthroughs_that_cancel_are_none():
    lag = delay_lti(A=[[-1.0]], B1=[[1.0]], C1=[[1.0]])
    system = lag + delay(0.3) - series(delay(0.1), delay(0.2))
    assert h2_norm(system).value == pytest.approx(np.sqrt(0.5), rel=1e-8)


@pytest.mark.parametrize("seed", range(6))
def test_the_expansion_is_that_of_the_transfer_matrix_at_high_frequencies(seed):
    """What is left falls with the third power: the mean over ten thousand frequencies, since it swings."""
    system = random_system(seed, 3, 3, 2, 2, chained=True)
    left: list[float] = []
    for size in (1e3, 1e4):
        s = 1j * np.linspace(size, 1.1 * size, 10_000)
        D, H1, H2 = (part(s) for part in expansion(system))
        rest = system(s) - D - H1 / s[:, None, None] - H2 / s[:, None, None] ** 2
        left.append(float(np.abs(rest).mean()))
    assert left[0] / left[1] == pytest.approx(1000, rel=0.05)


def test_a_gain_that_is_only_approached_has_its_peak_at_infinite_frequency():
    found = hinf_norm(from_control(control.tf([1.0, 0.0], [1.0, 1.0])))
    assert (found.lower, found.frequency, found.status) == (1.0, np.inf, "certified")


def test_a_direct_path_beside_a_delayed_one_peaks_at_their_sum():
    assert linfnorm(1.0 - 0.5 * delay(0.3)).lower == pytest.approx(1.5, rel=1e-9)


def test_delays_that_may_or_may_not_come_into_phase_are_bounded_and_the_status_says_so():
    found = linfnorm(1.0 - 0.5 * delay(0.3) - 0.3 * delay(0.44))
    assert "come into phase" in found.status
    dense = gains(1.0 - 0.5 * delay(0.3) - 0.3 * delay(0.44), np.linspace(0, 2 * np.pi / 0.02, 200_001)).max()
    assert found.lower <= dense * (1 + 1e-9)  # a full period
    assert dense <= found.upper


def test_systems_side_by_side_have_the_larger_peak_and_the_sum_of_energies():
    one, two = from_control(control.tf([1.0], [1.0, 1.0])), from_control(control.tf([1.0], [1.0, 0.4, 1.0]))
    both = append(one * delay(0.1), two)
    assert hinf_norm(both).lower == pytest.approx(hinf_norm(two).lower, rel=1e-9)
    assert h2_norm(both).value ** 2 == pytest.approx(h2_norm(one).value ** 2 + h2_norm(two).value ** 2, rel=1e-7)


def test_a_gain_of_nothing_is_zero():
    nothing = delay_lti(A=[[-1.0]], B1=[[0.0]], C1=[[1.0]])
    assert (hinf_norm(nothing).upper, h2_norm(nothing).value) == (0.0, 0.0)


def test_the_peak_of_a_band_is_that_of_its_edge_beside_the_resonance():
    plant = from_control(control.tf([1.0], [1.0, 0.02, 1.0]))
    found = peak_between(plant, 1.5, 4.0)
    assert (found.lower, found.frequency) == pytest.approx((gains(plant, np.array([1.5]))[0], 1.5), rel=1e-9)


@pytest.mark.parametrize("norm", [hinf_norm, h2_norm, system_norm])
def test_an_unstable_system_is_refused_in_a_sentence(norm):
    with pytest.raises(UnstableSystemError, match=r"has 2 pole\(s\) with Re s > 0.*no norm"):
        norm(pd_closed(T=0.035))


@pytest.mark.parametrize("norm", [hinf_norm, h2_norm, linfnorm])
def test_an_integrator_is_refused(norm):
    with pytest.raises(UnstableSystemError, match="imaginary axis, at 0 rad/s"):
        norm(series(delay(0.1), from_control(control.tf([1.0], [1.0, 0.0]))))


def test_the_peak_on_the_axis_of_an_unstable_system_is_linfnorm():
    plant = from_control(control.tf([3.0], [1.0, -1.0]))
    assert linfnorm(plant).lower == pytest.approx(3.0, rel=1e-9)


@pytest.mark.parametrize("p", [1, "nuc", -np.inf])
def test_other_norms_are_refused(p):
    with pytest.raises(InvalidParameterError, match='p = 2 or p = "inf"'):
        system_norm(feedback(0.5 * delay(0.1) * from_control(control.tf([1.0], [1.0, 1.0]))), p)


@pytest.mark.parametrize(("norm", "tol"), [(hinf_norm, 1e-13), (h2_norm, 0.0), (linfnorm, np.nan), (h2_norm, 1.0)])
def test_an_accuracy_beyond_rounding_is_refused(norm, tol):
    with pytest.raises(InvalidParameterError, match="tolerance of a norm"):
        norm(from_control(control.tf([1.0], [1.0, 1.0])), tol)

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pd_loop import pd_open
from random_systems import drawn_alike, random_system

from flycontrol.delay.convert import from_control
from flycontrol.delay.frequency import active_range, evaluate, frequency_response
from flycontrol.delay.interconnect import delay
from flycontrol.delay.margins import margins
from flycontrol.delay.system import delay_lti
from flycontrol.errors import InvalidParameterError, NeutralSystemError


def resonant(damping: float, peak: float):
    """Gain `peak` at the top of a resonance near 1 rad/s, behind a delay."""
    return from_control(control.tf([2 * damping * np.sqrt(1 - damping**2) * peak], [1.0, 2 * damping, 1.0])) * delay(
        2.0
    )


@drawn_alike
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.floats(0.05, 20.0))
def test_gain_crossovers_are_the_imaginary_eigenvalues_of_the_hamiltonian(seed, n, gain):
    """Delays at inputs and outputs leave |L| to the rational part: |C (jw - A)^-1 B| = 1 where H has eigenvalue jw."""
    rng = np.random.default_rng(seed)
    A, B, C = rng.normal(size=(n, n)), rng.normal(size=(n, 1)), gain * rng.normal(size=(1, n))
    loop = delay(0.3) * delay_lti(A=A, B1=B, C1=C) * delay(0.2)
    values = np.linalg.eigvals(np.block([[A, B @ B.T], [-C.T @ C, -A.T]]))
    scale = np.abs(values).max()
    if (np.abs(values.real) < 1e-5 * scale).sum() == (np.abs(values.real) < 1e-9 * scale).sum():  # none is doubtful
        crossings = np.sort(values.imag[(np.abs(values.real) < 1e-9 * scale) & (values.imag > 0)])
        assert margins(loop).gain_crossovers == pytest.approx(crossings, rel=1e-7)


@pytest.mark.parametrize("damping", [1e-1, 1e-3, 1e-5])
@pytest.mark.parametrize("excess", [1e-2, 1e-6, 1e-10])
def test_a_resonance_that_just_exceeds_one_is_crossed_twice(damping, excess):
    """|L|^2 = 1 is a quadratic in w^2: (1 - w^2)^2 + (2 z w)^2 = k^2."""
    middle = 1 - 2 * damping**2
    spread = 2 * damping * np.sqrt(1 - damping**2) * np.sqrt(excess * (2 + excess))
    doubt = 1e-9 + 3e-16 / (damping * excess)  # rounding of w^2 - 1 moves |L| by its inverse damping
    found = margins(resonant(damping, 1 + excess)).gain_crossovers
    assert found == pytest.approx(np.sqrt([middle - spread, middle + spread]), rel=1e-12, abs=spread * doubt)


@pytest.mark.parametrize("damping", [1e-1, 1e-3, 1e-5])
@pytest.mark.parametrize("short", [1e-2, 1e-6, 1e-10])
def test_a_resonance_that_just_falls_short_of_one_is_not_crossed(damping, short):
    assert len(margins(resonant(damping, 1 - short)).gain_crossovers) == 0


@pytest.mark.parametrize("seed", range(30))
def test_all_crossovers_of_random_loops_with_inner_delays_are_those_of_a_dense_grid(seed):
    drawn = random_system(seed, 1 + seed % 4, 1 + seed % 3)
    loop = delay_lti(A=drawn.A, B1=drawn.B1, B2=drawn.B2, C1=3 * drawn.C1, C2=drawn.C2, tau=drawn.tau) * delay(0.7)
    found = margins(loop, floor=0.05)
    omega = np.linspace(1e-4, 400.0, 400_001)
    L = evaluate(loop, omega)
    gain = omega[:-1][np.diff(np.abs(L) > 1)]
    phase = omega[:-1][np.diff(L.imag > 0) & (L.real[:-1] < 0) & (np.abs(L[:-1]) > 0.05)]
    step = omega[1] - omega[0]
    assert found.gain_crossovers == pytest.approx(gain, abs=step)
    assert found.phase_crossovers[found.phase_crossovers > 0] == pytest.approx(phase, abs=step)
    assert np.abs(evaluate(loop, found.gain_crossovers)) == pytest.approx(1.0, abs=1e-11)
    at_180 = evaluate(loop, found.phase_crossovers)
    assert (np.abs(at_180.imag) < 1e-10 * np.abs(at_180)).all()
    assert found.modulus_margin <= np.abs(1 + L).min() * (1 + 1e-12)
    assert found.modulus_margin >= np.abs(1 + L).min() - 1e-3 * (1 + np.abs(L).max())


def test_a_crossover_far_below_every_rate_of_the_loop_is_found():
    """1e-9 / (s (s + 1)) crosses at 1e-9 rad/s."""
    loop = from_control(control.tf([1e-9], [1.0, 1.0, 0.0])) * delay(0.1)
    assert margins(loop).gain_crossovers == pytest.approx([1e-9], rel=1e-9)


def test_poles_on_the_axis_are_passed_by_on_both_sides():
    """k / (s^2 + 1): |L| = 1 at w^2 = 1 +- k."""
    loop = from_control(control.tf([0.3], [1.0, 0.0, 1.0])) * delay(1e-3)
    assert margins(loop).gain_crossovers == pytest.approx(np.sqrt([0.7, 1.3]), rel=1e-12)


def test_a_negative_gain_at_rest_is_a_phase_crossover_at_zero_frequency():
    loop = from_control(control.tf([-0.5], [1.0, 1.0]))
    found = margins(loop)
    assert found.phase_crossovers[0] == 0.0
    assert found.gain_margin == pytest.approx(2.0, rel=1e-12)
    assert (found.modulus_margin, found.modulus_frequency) == (pytest.approx(0.5, rel=1e-12), 0.0)


def test_a_negative_direct_path_limits_the_gain_at_infinite_frequency():
    """-(s + 1) / (2 (s + 4)): at rest -1/8, at infinite frequency -1/2."""
    found = margins(from_control(control.tf([-0.5, -0.5], [1.0, 4.0])))
    assert found.gain_margin == pytest.approx(2.0, rel=1e-12)
    assert (found.modulus_margin, found.modulus_frequency) == (0.5, np.inf)


@pytest.mark.parametrize("gain", [1e-1, 1e-4, 1e-7])
def test_a_gain_margin_far_above_the_inverse_floor_is_a_number(gain):
    """gain exp(-s) / (s + 1): the phase is -180 deg at w + atan w = pi."""
    loop = gain * from_control(control.tf([1.0], [1.0, 1.0])) * delay(1.0)
    w = 2.028757838110434  # its root
    assert w + np.arctan(w) == pytest.approx(np.pi, abs=1e-14)
    assert margins(loop).gain_margin == pytest.approx(np.hypot(1.0, w) / gain, rel=1e-11)


def test_a_loop_whose_phase_never_reaches_minus_180_has_no_gain_margin():
    assert margins(from_control(control.tf([30.0], [1.0, 2.0, 1.0]))).gain_margin == np.inf


def test_bode_and_nichols_data_start_and_end_where_they_are_asked_to():
    found = frequency_response(pd_open(), 1.0, 500.0)
    assert (found.omega[0], found.omega[-1]) == pytest.approx((1.0, 500.0), rel=1e-12)
    assert found.decibels == pytest.approx(20 * np.log10(found.magnitude), rel=1e-12)
    # the phase of (kd s + kp) exp(-s T) / (s (s + b)) from its factors, without any unwrapping
    w = found.omega
    exact = np.arctan2(55.0 * w, 900.0) - 0.0136 * w - np.pi / 2 - np.arctan2(w, 20.0)
    assert found.phase == pytest.approx(exact, abs=1e-10)


def test_the_range_of_a_response_left_out_holds_every_gain_crossover():
    for seed in range(10):
        loop = random_system(seed, 3, 2)
        loop = delay_lti(A=loop.A, B1=loop.B1, B2=loop.B2, C1=3 * loop.C1, C2=loop.C2, tau=loop.tau)
        low, high = active_range(loop)
        crossings = margins(loop).gain_crossovers
        assert ((crossings > low) & (crossings < high)).all()
        assert frequency_response(loop).omega[[0, -1]] == pytest.approx([low, high], rel=1e-9)


@pytest.mark.parametrize("damping", [1e-2, 1e-4, 1e-6])
def test_a_response_shows_the_top_of_every_resonance(damping):
    found = frequency_response(resonant(damping, 1.0), 0.01, 100.0)
    assert found.magnitude.max() == pytest.approx(1.0, abs=2e-3)  # points are closer than 0.1 in log L


def test_a_loop_of_gain_one_at_all_frequencies_is_refused():
    with pytest.raises(InvalidParameterError, match="whole band"):
        margins(from_control(control.tf([-1.0, 1.0], [1.0, 1.0])))


def test_a_direct_path_with_more_gain_than_one_through_a_delay_is_refused():
    with pytest.raises(NeutralSystemError, match="neutral system"):
        margins(1.5 * delay(0.1) * from_control(control.tf([1.0, 1.0], [1.0, 2.0])))


@pytest.mark.parametrize("floor", [0.0, 1.0, -0.1, np.nan])
def test_a_floor_that_is_none_is_refused(floor):
    with pytest.raises(InvalidParameterError, match="between 0 and 1"):
        margins(pd_open(), floor)

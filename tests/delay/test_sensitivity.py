import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pd_loop import pd_open
from random_systems import drawn_alike, random_points, random_system

from flycontrol.delay.convert import from_control
from flycontrol.delay.count import count_right_of
from flycontrol.delay.disk_margins import disk_margins
from flycontrol.delay.interconnect import delay, feedback
from flycontrol.delay.margins import margins
from flycontrol.delay.sensitivity import complementary_sensitivity, gangof4, sensitivity
from flycontrol.delay.system import delay_lti
from flycontrol.errors import InvalidParameterError, UnstableSystemError

PLANTS = [
    control.tf([25.0], [1.0, 10.0, 10.0, 10.0]),
    control.tf([4.0], [1.0, 3.0, 3.0, 1.0]),
    control.tf([30.0, 200.0], [1.0, 12.0, 20.0, 0.0]),
    control.tf([3.0, 6.0], [1.0, 0.0, -1.0]),
]


@drawn_alike
@given(st.integers(0, 2**32 - 1), st.integers(1, 2), st.integers(1, 2))
def test_the_four_functions_are_those_of_the_transfer_matrices(seed, p, m):
    P, C = random_system(seed, 3, 1, m, p), random_system(seed + 1, 2, 1, p, m)
    found, s = gangof4(P, C), random_points(seed)
    for point in s:
        plant, controller = P(point), C(point)
        inverse = np.linalg.inv(np.eye(p) + plant @ controller)
        tolerance = 1e-9 * np.linalg.cond(np.eye(p) + plant @ controller)
        for name, expected in (
            ("S", inverse),
            ("T", inverse @ plant @ controller),
            ("CS", controller @ inverse),
            ("PS", inverse @ plant),
        ):
            np.testing.assert_allclose(
                getattr(found, name)(point), expected, atol=tolerance * max(1.0, np.abs(expected).max()), rtol=0
            )


def test_sensitivity_and_its_complement_add_up_to_one():
    loop = pd_open()
    s = random_points(3)
    both = sensitivity(loop)(s) + complementary_sensitivity(loop)(s)
    np.testing.assert_allclose(both[:, 0, 0], 1.0, rtol=1e-12)


def test_without_delay_peaks_are_those_of_python_control():
    P, C = control.tf([1.0], [1.0, 1.0, 0.0]), control.tf([2.0, 1.0], [0.1, 1.0])
    found = gangof4(P, C).peaks()
    S = control.feedback(1, P * C)
    for ours, theirs in ((found.S, S), (found.T, 1 - S), (found.CS, C * S), (found.PS, P * S)):
        peak = control.system_norm(control.minreal(theirs, verbose=False), "inf", print_warning=False)
        assert ours.lower == pytest.approx(peak, rel=3e-6)  # its default tolerance is 1e-6


def test_the_peak_of_the_sensitivity_is_the_inverse_of_the_modulus_margin():
    found = gangof4(control.tf([1.0], [1.0, 20.0, 0.0]) * delay(0.0136), 900.0).peaks().S
    nearest = margins(900.0 * control.tf([1.0], [1.0, 20.0, 0.0]) * delay(0.0136))
    assert found.lower == pytest.approx(1 / nearest.modulus_margin, rel=1e-10)
    assert found.frequency == pytest.approx(nearest.modulus_frequency, rel=1e-6)


def test_a_pd_controller_without_a_proper_form_reads_the_derivative_from_the_plant():
    """C = [kp, kd] on (psi, psi') is a gain matrix; T at the plant's input is that of the scalar loop."""
    plant = delay_lti(A=[[0.0, 1.0], [0.0, -20.0]], B1=[[0.0], [1.0]], C1=np.eye(2))
    found, s = gangof4(plant * delay(0.0136), np.array([[900.0, 55.0]])), random_points(5)
    scalar = pd_open()(s)[:, 0, 0]
    np.testing.assert_allclose(
        (found.CS(s) @ plant(s) * np.exp(-0.0136 * s)[:, None, None])[:, 0, 0], scalar / (1 + scalar), rtol=1e-10
    )


@pytest.mark.parametrize("skew", [-1.0, -0.3, 0.0, 0.5, 1.0])
@pytest.mark.parametrize("plant", PLANTS)
def test_without_delay_disk_margins_are_those_of_python_control(plant, skew):
    found = disk_margins(from_control(plant), skew)
    grid = np.geomspace(1e-3, 1e3, 2001)
    if np.isfinite(found.frequency):
        grid = np.append(grid, found.frequency * (1 + 1e-4 * np.linspace(-1, 1, 201)))
    alpha, gain_in_decibels, phase_in_degrees = control.disk_margins(plant, np.unique(grid), skew)
    symmetric = min(found.highest_gain, 1 / found.lowest_gain)
    assert found.disk_margin == pytest.approx(alpha, rel=1e-5)
    assert 20 * np.log10(symmetric) == pytest.approx(gain_in_decibels, rel=1e-4)
    assert np.rad2deg(found.phase_margin) == pytest.approx(phase_in_degrees, rel=1e-4)


@pytest.mark.parametrize("skew", [-1.0, 0.0, 1.0, 2.5])
def test_every_factor_in_the_disk_leaves_the_loop_stable_and_its_edge_does_not(skew):
    """Real factors by the closed loop's root count; the edge is reached where S + (skew - 1)/2 has its peak."""
    loop = pd_open(b=69.0, kp=3050.0, kd=45.0)
    found = disk_margins(loop, skew)
    for factor in np.linspace(max(found.lowest_gain, 0.01), min(found.highest_gain, 50.0), 9)[1:-1]:
        assert count_right_of(feedback(float(factor) * loop), 0.0).roots == 0
    S = 1 / (1 + loop(1j * found.frequency)[0, 0])
    d = 1 / (S + (skew - 1) / 2)
    f = (1 + (1 - skew) / 2 * d) / (1 - (1 + skew) / 2 * d)
    assert abs(d) == pytest.approx(found.disk_margin, rel=2e-6)
    assert f * loop(1j * found.frequency)[0, 0] == pytest.approx(-1.0, rel=1e-9)


def test_disk_margins_are_no_larger_than_the_classical_ones():
    for kd in (20.0, 45.0, 70.0):
        loop = pd_open(b=69.0, kp=3050.0, kd=kd)
        classical = margins(loop)
        for skew in (-1.0, 0.0, 1.0):
            found = disk_margins(loop, skew)
            assert found.highest_gain <= classical.gain_margin
            assert found.lowest_gain >= classical.gain_reduction_margin
            assert found.phase_margin <= classical.phase_margin


def test_the_disk_of_skew_one_is_the_modulus_margin_and_that_of_minus_one_the_peak_of_t():
    loop = pd_open()
    assert disk_margins(loop, 1.0).disk_margin == pytest.approx(margins(loop).modulus_margin, rel=2e-6)
    T = gangof4(loop, 1.0).peaks().T
    assert disk_margins(loop, -1.0).disk_margin == pytest.approx(1 / T.upper, rel=2e-6)


def test_an_unstable_loop_has_no_disk_margin_and_no_peaks():
    with pytest.raises(UnstableSystemError, match="no disk margin"):
        disk_margins(pd_open(T=0.035))
    with pytest.raises(UnstableSystemError, match="no norm"):
        gangof4(pd_open(T=0.035), 1.0).peaks()


def test_a_controller_of_the_wrong_shape_is_refused_with_both_shapes():
    with pytest.raises(InvalidParameterError, match=r"\(2, 1\) needs a controller of shape \(1, 2\), got \(2, 2\)"):
        gangof4(random_system(1, outputs=2), random_system(2, inputs=2, outputs=2))


def test_a_disk_without_a_finite_skew_is_refused():
    with pytest.raises(InvalidParameterError, match="skew"):
        disk_margins(pd_open(), np.nan)

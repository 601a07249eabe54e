from dataclasses import replace

import control
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pd_loop import KD, KP, B, T, crossover, largest_delay, pd_closed, pd_open
from random_systems import drawn_alike, random_system
from scipy.optimize import brentq

from flycontrol.delay.frequency import evaluate, frequency_response
from flycontrol.delay.interconnect import delay, feedback, series
from flycontrol.delay.margins import margins
from flycontrol.delay.pade import from_control
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import DelayLTI, delay_lti
from flycontrol.errors import InvalidParameterError

few = settings(drawn_alike, max_examples=8)


@st.composite
def stable_pd(draw) -> tuple[float, float, float, float]:
    """(b, kp, kd, T) of a stable loop: a reaction time of 1 to 30 ms, everything else on the scale that it sets."""
    T = 10 ** draw(st.floats(-3.0, -1.5))
    b, kp, kd = draw(st.floats(0.01, 3.0)) / T, draw(st.floats(0.02, 1.0)) / T**2, draw(st.floats(0.0, 1.0)) / T
    assume(0.98 * largest_delay(b, kp, kd) > T)
    return b, kp, kd, T


def scaled(loop: DelayLTI, gain: float) -> DelayLTI:
    return series(loop, delay_lti(A=np.zeros((0, 0)), B1=np.zeros((0, 1)), C1=np.zeros((1, 0)), D11=[[gain]]))


def on_the_imaginary_axis(system: DelayLTI) -> float:
    """|Re| of the rightmost root over its size."""
    root = rightmost_roots(system, 2).roots[0]
    return abs(root.real) / abs(root)


@few
@given(stable_pd())
def test_pd_control_has_the_crossover_and_the_delay_margin_of_the_closed_form(loop):
    b, kp, kd, T = loop
    found = margins(pd_open(*loop))
    assert found.gain_crossovers == pytest.approx([crossover(b, kp, kd)], rel=1e-12)
    assert found.delay_margin == pytest.approx(largest_delay(b, kp, kd) - T, rel=1e-10)
    assert found.phase_margin == pytest.approx(crossover(b, kp, kd) * (largest_delay(b, kp, kd) - T), rel=1e-10)


@few
@given(stable_pd())
def test_spending_the_delay_margin_puts_a_root_on_the_imaginary_axis(loop):
    b, kp, kd, T = loop
    assert on_the_imaginary_axis(pd_closed(b, kp, kd, T + margins(pd_open(*loop)).delay_margin)) < 1e-9


@few
@given(stable_pd())
def test_spending_the_phase_margin_as_a_delay_puts_a_root_on_the_imaginary_axis(loop):
    b, kp, kd, T = loop
    found = margins(pd_open(*loop))
    further = found.phase_margin / found.gain_crossovers[0]
    assert on_the_imaginary_axis(feedback(pd_open(b, kp, kd, T + further))) < 1e-9


@few
@given(stable_pd())
def test_spending_the_gain_margin_puts_a_root_on_the_imaginary_axis(loop):
    found = margins(pd_open(*loop))
    assume(np.isfinite(found.gain_margin))  # it may be larger than 1 / floor
    assert on_the_imaginary_axis(feedback(scaled(pd_open(*loop), found.gain_margin))) < 1e-9


def test_a_gain_margin_above_a_hundred_is_a_number():
    """Every loop with delay has one: its phase falls without end."""
    assert np.isfinite(margins(pd_open(1.0, 10.0, 1.0, 0.0121)).gain_margin)


def test_spending_the_gain_reduction_margin_puts_a_root_on_the_imaginary_axis():
    """(s + 1)^2 / s^3 needs gain: conditionally stable from 1/2 on."""
    loop = from_control(2.0 * control.tf([1.0, 2.0, 1.0], [1.0, 0.0, 0.0, 0.0]))
    found = margins(loop)
    assert found.gain_reduction_margin == pytest.approx(0.25, rel=1e-9)
    assert on_the_imaginary_axis(feedback(scaled(loop, found.gain_reduction_margin))) < 1e-9


@few
@given(st.integers(0, 2**32 - 1), st.floats(0.2, 5.0))
def test_whatever_loop_is_stable_loses_its_stability_with_its_delay_margin(seed, gain):
    loop = scaled(random_system(seed, 3, 1), gain)
    loop = replace(loop, D12=0 * loop.D12, D21=0 * loop.D21)  # strictly proper: closing it leaves it retarded
    assume(rightmost_roots(feedback(loop), 2).abscissa < -1e-3)
    spare = margins(loop, floor=0.5).delay_margin
    if np.isfinite(spare):
        assert on_the_imaginary_axis(feedback(series(loop, delay(spare)))) < 1e-9
        assert rightmost_roots(feedback(series(loop, delay(0.99 * spare))), 2).abscissa < 0
    else:  # no delay whatever harms it
        for seconds in (0.1, 1.0, 10.0):
            assert rightmost_roots(feedback(series(loop, delay(seconds))), 2).abscissa < 0


@pytest.mark.parametrize(
    "plant",
    [
        control.tf([4.0], [1.0, 3.0, 3.0, 1.0]),
        control.tf([30.0, 200.0], [1.0, 12.0, 20.0, 0.0]),
        control.tf([2.0, 4.0, 2.0], [1.0, 0.0, 0.0, 0.0]),
        control.tf([1.0, 0.2, 4.0], [1.0, 0.3, 9.0, 1.0, 2.0]),
    ],
)
def test_without_delay_margins_are_those_of_python_control(plant):
    gain, phase, _, at_180, at_1, _ = control.stability_margins(plant, returnall=True)
    found = margins(from_control(plant), floor=1e-3)
    assert found.gain_crossovers == pytest.approx(np.sort(at_1), rel=1e-6)  # it takes roots of polynomials
    if len(gain):
        assert found.phase_crossovers == pytest.approx(np.sort(at_180[gain < 1e3]), rel=1e-6)
        assert found.gain_margin == pytest.approx(min([g for g in gain if g > 1], default=np.inf), rel=1e-6)
    lags = np.deg2rad(phase) % (2 * np.pi)
    assert found.phase_margin == pytest.approx(lags.min(initial=np.inf), rel=1e-6)


@few
@given(stable_pd())
def test_the_modulus_margin_is_the_smallest_distance_on_a_dense_grid(loop):
    w = crossover(*loop[:3]) * np.geomspace(1e-2, 1e2, 40_001)
    dense = np.abs(1 + evaluate(pd_open(*loop), w)).min()
    found = margins(pd_open(*loop)).modulus_margin
    # the grid's ratio is 1.00023: its minimum is at most about 1e-7 above the true one
    assert dense * (1 - 1e-5) - 1e-6 < found <= dense * (1 + 1e-12)


def resonant(damping: float) -> DelayLTI:
    """Three flexible modes at 3, 10 and 31 rad/s behind a delay."""
    s = control.tf("s")
    modes = [0.6 * w * s / (s**2 + 2 * damping * w * s + w**2) * 2 * damping for w in (3.0, 10.0, 31.0)]
    return series(delay(0.13), from_control(4.0 * (modes[0] + modes[1] + modes[2])))


@pytest.mark.parametrize("damping", [0.05, 0.01, 0.001])
def test_every_crossover_of_a_resonant_plant_with_delay_is_found(damping):
    loop = resonant(damping)
    w = np.unique(np.concatenate([
        np.geomspace(1e-1, 3e3, 100_001),
        *[mode * (1 + damping * np.linspace(-9, 9, 20_001)) for mode in (3.0, 10.0, 31.0)],
    ]))  # fmt: skip
    w = w[np.append(True, np.diff(w) > 1e-9 * w[1:])]  # no two so close that rounding alone flips a sign
    L = evaluate(loop, w)
    gain = w[:-1][np.diff(np.abs(L) > 1)]
    real = w[:-1][np.diff(L.imag > 0) & (L.real[:-1] < 0) & (np.abs(L[:-1]) > 0.01)]
    found = margins(loop, floor=0.01)
    assert len(gain) >= 6
    assert found.gain_crossovers == pytest.approx(gain, rel=1e-3 * damping + 1e-4)
    assert found.phase_crossovers == pytest.approx(real, rel=1e-3 * damping + 1e-4)


@pytest.mark.parametrize("damping", [1e-3, 1e-4])
def test_a_narrow_resonance_beside_its_antiresonance_is_not_stepped_over(damping):
    """Far from it the pair leaves neither size nor phase changed, so a coarse grid shows nothing at all."""
    zero, pole = 10.0, 10.2
    lag = control.tf([0.4], [1.0, 1.0])
    pair = control.tf([1.0, 2 * damping * zero, zero**2], [1.0, 2 * damping * pole, pole**2])
    loop = from_control(10.0 * lag * pair)
    w = pole * (1 + np.linspace(-0.05, 0.05, 400_001))
    crossings = w[:-1][np.diff(np.abs(evaluate(loop, w)) > 1)]
    assert len(crossings) >= 2
    found = margins(loop).gain_crossovers
    near = found[(found > w[0]) & (found < w[-1])]
    assert near == pytest.approx(crossings, rel=1e-6)


def test_phase_crossovers_of_the_benchmark_loop_are_complete_above_the_floor():
    loop = pd_open()
    found = margins(loop, floor=0.01)
    w = np.linspace(1.0, 2e4, 400_001)
    L = evaluate(loop, w)
    dense = w[:-1][np.diff(L.imag > 0) & (L.real[:-1] < 0) & (np.abs(L[:-1]) > 0.01)]
    assert found.phase_crossovers == pytest.approx(dense, abs=0.1)  # twice the grid's step
    for omega in found.phase_crossovers:  # the phase condition itself: -wT - atan(b/w) ... = an odd multiple of pi
        angle = np.arctan2(KD * omega, KP) - omega * T - np.pi / 2 - np.arctan2(omega, B)
        assert np.cos(angle) == pytest.approx(-1.0, abs=1e-14)


def test_a_loop_below_gain_one_has_no_gain_crossover_and_infinite_delay_margin():
    loop = series(delay(0.3), delay_lti(A=[[-1.0]], B1=[[1.0]], C1=[[0.9]]))
    found = margins(loop)
    assert len(found.gain_crossovers) == 0
    assert found.delay_margin == np.inf
    assert found.phase_margin == np.inf
    # 0.9 < 1 at all frequencies: the gain margin is where the phase first reaches -180 deg
    w = brentq(lambda w: 0.3 * w + np.arctan(w) - np.pi, 1.0, 20.0)
    assert found.gain_margin == pytest.approx(np.hypot(1.0, w) / 0.9, rel=1e-12)


def test_the_frequency_response_never_moves_by_more_than_its_turn():
    found = frequency_response(pd_open(), 1.0, 1e4, turn=0.05)
    logs = np.log(found.magnitude) + 1j * found.phase
    assert np.abs(np.diff(logs)).max() <= 0.05 + 1e-12
    np.testing.assert_allclose(found.value, evaluate(pd_open(), found.omega), rtol=1e-12)


def test_margins_of_two_loops_at_once_are_refused():
    with pytest.raises(InvalidParameterError, match=r"got shape \(outputs, inputs\) = \(1, 2\)"):
        margins(random_system(1, inputs=2))


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (2.0, 1.0), (-1.0, 1.0), (1.0, np.nan)])
def test_an_empty_frequency_range_is_refused(low, high):
    with pytest.raises(InvalidParameterError, match="0 < low < high"):
        frequency_response(pd_open(), low, high)


def test_margins_say_whether_the_closed_loop_is_stable_by_its_exact_poles():
    for gain in (0.1, 1.0, 3.0, 30.0):
        loop = scaled(pd_open(), gain)
        found = margins(loop)
        right = int((rightmost_roots(feedback(loop), 12).roots.real > 0).sum())
        assert found.unstable == right
        assert found.stable == (right == 0)
        assert ("unstable" in found.status) == (right > 0)
        assert found.status in repr(found)


def test_margins_on_the_boundary_claim_no_stability():
    loop = series(delay(np.pi / 2), from_control(control.tf([1.0], [1.0, 0.0])))
    found = margins(loop)
    assert found.unstable is None
    assert not found.stable
    assert "boundary" in found.status


LATE_DIRECT = 0.5 * control.tf([1.0, 1.0], [1.0, 2.0]) * delay(0.1)


def test_a_delayed_direct_path_is_said_to_cross_for_ever_and_up_to_where_all_are_given():
    found = margins(LATE_DIRECT)
    w = np.linspace(1e-3, found.complete_to, 200_001)
    L = evaluate(LATE_DIRECT, w)
    dense = w[:-1][np.diff(L.imag > 0) & (L.real[:-1] < 0)]
    assert found.phase_crossovers == pytest.approx(dense, abs=1e-3)
    assert f"up to {found.complete_to:.4g} rad/s" in found.remark
    assert abs(evaluate(LATE_DIRECT, np.array([1e4]))[0]) > found.floor  # and further on it is no smaller
    assert found.stable  # |L| < 1 everywhere, and the plant is stable


def test_crossovers_are_complete_where_the_direct_path_is_undelayed_or_absent():
    for loop in (pd_open(), from_control(control.tf([-0.5, 1.0], [1.0, 2.0]))):
        found = margins(loop)
        assert found.complete_to == np.inf
        assert found.remark == ""

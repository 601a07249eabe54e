import numpy as np
import pytest

from flycontrol.errors import InvalidParameterError
from flycontrol.model.gains import (
    PulseTask,
    fastest_decay,
    fastest_pd,
    fastest_proportional,
    largest_stable_delay,
    most_robust_pd,
)
from flycontrol.model.recovery import pulse_for_peak, recovery_curve, recovery_time
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg, ms

B, T = 69.0, 3 / 220
TASK = PulseTask(duration=T / 3, peak=20 * deg, tolerance=2 * deg)


@pytest.mark.parametrize(("b", "figure"), [(69.0, 99), (100.0, 81), (125.0, 72), (150.0, 66), (176.0, 62)])
def test_the_best_p_alone_takes_no_longer_than_published(b, figure):
    best = fastest_proportional(b, T, TASK)
    assert best.kd == 0.0
    # the figure is rounded to a millisecond, and a finer search may win up to one more
    assert figure - 1.5 < best.recovery_time / ms < figure + 0.5


def test_the_best_p_is_the_best_of_a_thousand_gains_by_the_general_code():
    best = fastest_proportional(B, T, TASK)
    for kp in np.linspace(0.6, 1.6, 41) * best.kp:
        loop = YawLoop.from_rates(b=B, kp=kp, kd=0.0, delay=T)
        assert recovery_time(loop, pulse_for_peak(loop, TASK.duration, TASK.peak)) > best.recovery_time - 0.01 * ms


def test_no_p_alone_at_the_nominal_damping_meets_60_ms():
    assert fastest_proportional(B, T, TASK).recovery_time > 60 * ms


def test_the_fastest_pd_recovers_in_44_ms_at_about_the_published_gains():
    best = fastest_pd(B, T, TASK)
    assert f"{best.recovery_time / ms:.0f}" == "44"
    # recovery is flat around its optimum: the published gains stand to two digits
    assert best.kp == pytest.approx(3780.0, rel=0.02)
    assert best.kd == pytest.approx(71.0, rel=0.02)


def test_the_fastest_pd_with_a_modulus_margin_of_a_half_recovers_in_50_ms():
    best = fastest_pd(B, T, TASK, modulus_margin=0.5)
    assert f"{best.recovery_time / ms:.0f}" == "50"
    assert best.modulus_margin > 0.5 - 1e-3  # the search reads |1 + L| from a grid


def test_a_required_modulus_margin_is_kept():
    assert fastest_pd(B, T, TASK, modulus_margin=0.5).modulus_margin >= 0.5


def test_at_the_gains_of_fastest_decay_recovery_takes_91_ms():
    """kp 1868, kd 27.1, decay 72 1/s at T = 13.6 ms: decay is not recovery."""
    kp, kd, s0 = fastest_decay(B, 13.6 * ms)
    assert (f"{kp:.0f}", f"{kd:.1f}", f"{-s0:.0f}") == ("1868", "27.1", "72")
    loop = YawLoop.from_rates(b=21e-12 / 3.06e-13, kp=1868.0, kd=27.1, delay=T)
    assert f"{recovery_time(loop, pulse_for_peak(loop, T / 3, 20 * deg)) / ms:.0f}" == "91"


@pytest.mark.parametrize(("b", "delay"), [(B, T), (20.0, 0.0136), (0.0, 1.0)])
def test_no_neighbouring_gains_decay_faster_than_the_fastest(b, delay):
    kp, kd, s0 = fastest_decay(b, delay)
    for turn in np.linspace(0, 2 * np.pi, 12, endpoint=False):
        near = YawLoop.from_rates(
            b=b, kp=kp * (1 + 0.02 * np.cos(turn)), kd=kd * (1 + 0.02 * np.sin(turn)), delay=delay
        )
        assert near.poles(2).real.max() > s0


def test_at_the_gains_of_fastest_decay_the_characteristic_function_vanishes_with_two_derivatives():
    kp, kd, s = fastest_decay(B, T)
    lag = np.exp(-s * T)
    f = s**2 + B * s + (kd * s + kp) * lag
    first = 2 * s + B + (kd - T * (kd * s + kp)) * lag
    second = 2 + (-2 * T * kd + T**2 * (kd * s + kp)) * lag
    assert np.abs([f / s**2, first / s, second]).max() < 1e-12


@pytest.fixture(scope="module")
def nominal():
    """Gains by the rule behind the parameter file: recovery within 60 ms from 40 deg, as robust as that allows."""
    return most_robust_pd(B, T, PulseTask(duration=T / 3, peak=40 * deg, tolerance=2 * deg), 60 * ms)


def test_the_nominal_rule_leads_to_about_3050_and_45_with_modulus_margin_0_56(nominal):
    assert nominal.recovery_time <= 60 * ms
    assert f"{nominal.modulus_margin:.2f}" == "0.56"
    # the optimum is flat along the deadline: 1 % in kp and 3 % in kd lie within the rounding of the margin
    assert nominal.kp == pytest.approx(3050.0, rel=0.01)
    assert nominal.kd == pytest.approx(45.0, rel=0.03)


def test_the_rounded_nominal_gains_meet_the_deadline_from_every_peak_and_give_up_half_a_percent_of_margin(nominal):
    rounded = YawLoop.from_rates(b=B, kp=3050.0, kd=45.0, delay=T)
    peaks = np.linspace(2.1, 40.0, 200) * deg
    assert recovery_curve(rounded, T / 3, peaks).times.max() < 60 * ms
    margin = rounded.margins().modulus_margin
    assert f"{margin:.4f}" == "0.5605"
    assert nominal.modulus_margin - 0.005 < margin < nominal.modulus_margin


def test_no_random_gains_beat_the_nominal_rule(nominal):
    rng = np.random.default_rng(1)
    for kp, kd in zip(rng.uniform(2400, 3800, 60), rng.uniform(30, 65, 60), strict=True):
        loop = YawLoop.from_rates(b=B, kp=kp, kd=kd, delay=T)
        in_time = recovery_time(loop, pulse_for_peak(loop, T / 3, 40 * deg)) <= 60 * ms
        assert not in_time or loop.margins().modulus_margin < nominal.modulus_margin + 1e-4


@pytest.mark.parametrize(
    ("b", "kp", "kd"), [(69.0, 3050.0, 45.0), (20.0, 900.0, 55.0), (0.0, 100.0, 10.0), (150.0, 50.0, -20.0)]
)
def test_the_closed_form_largest_delay_puts_a_root_on_the_imaginary_axis(b, kp, kd):
    loop = YawLoop.from_rates(b=b, kp=kp, kd=kd, delay=largest_stable_delay(b, kp, kd))
    root = loop.poles(2)[0]
    assert abs(root.real) < 1e-9 * abs(root)


@pytest.mark.parametrize(
    ("b", "kp", "kd"), [(69.0, 0.0, 45.0), (69.0, -1.0, 45.0), (69.0, 100.0, -69.0), (1.0, np.nan, 1.0)]
)
def test_the_closed_form_refuses_gains_that_are_unstable_without_delay(b, kp, kd):
    with pytest.raises(InvalidParameterError, match="kp > 0 and b"):
        largest_stable_delay(b, kp, kd)


def test_the_best_proportional_control_stands_on_a_cliff_and_says_so():
    best = fastest_proportional(B, T, TASK)
    loop = YawLoop.from_rates(b=B, kp=1.01 * best.kp, kd=0.0, delay=T)
    beyond = recovery_time(loop, pulse_for_peak(loop, T / 3, TASK.peak), TASK.tolerance)
    assert best.nearby >= beyond * (1 - 1e-9)
    assert best.nearby > 1.3 * best.recovery_time

from itertools import pairwise

import numpy as np
import pytest

from flycontrol.delay.frequency import evaluate
from flycontrol.delay.pade import pade
from flycontrol.model.gains import PulseTask, fastest_proportional, largest_stable_delay
from flycontrol.model.loci import delay_locus
from flycontrol.model.loop_shape import loop_shape
from flycontrol.model.recovery import pulse_response, recovery_time
from flycontrol.model.study import study
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg, ms

B, KP, KD, T = 69.0, 3050.0, 45.0, 3 / 220
TOLD: list[tuple[int, int, str]] = []  # what the study of the fixture said of its progress
TASK = PulseTask(duration=T / 3, peak=20 * deg, tolerance=2 * deg)


def fly(delay: float = T) -> YawLoop:
    return YawLoop.from_rates(b=B, kp=KP, kd=KD, delay=delay)


@pytest.fixture(scope="module")
def nominal():
    return study(
        fly(),
        TASK,
        [69.0, 176.0],
        deadline=60 * ms,
        progress=lambda done, total, what: TOLD.append((done, total, what)),
    )


def test_recovery_time_rises_sharply_and_then_levels_off(nominal):
    """Mean slope over 20 to 40 deg at most a fifth of that over 3 to 6 deg."""
    low, mid, strong, strongest = np.interp(np.array([3, 6, 20, 40]) * deg, nominal.curve.peaks, nominal.curve.times)
    assert (strongest - strong) / 20 <= 0.2 * (mid - low) / 3


def test_p_alone_misses_the_deadline_at_the_nominal_damping_and_meets_it_from_a_named_damping_on(nominal):
    assert nominal.damping_table[0].proportional.recovery_time > 60 * ms
    assert nominal.damping_table[0].derivative.recovery_time < 60 * ms
    threshold = nominal.proportional_suffices_from
    assert threshold > 176.0  # 62 ms at 176 1/s
    assert fastest_proportional(1.02 * threshold, T, TASK).recovery_time < 60 * ms
    assert fastest_proportional(0.98 * threshold, T, TASK).recovery_time > 60 * ms


def test_the_largest_stable_delay_of_the_closed_form_is_the_delay_and_its_margin(nominal):
    assert nominal.closed_form_largest_delay == pytest.approx(T + nominal.result.margins.delay_margin, rel=1e-11)


def test_the_loop_shape_is_the_open_loop_and_its_pade_keeps_the_gain(nominal):
    shape = nominal.shape
    exact = (KP + KD * 1j * shape.exact.omega) * np.exp(-1j * shape.exact.omega * T)
    exact = exact / (1j * shape.exact.omega * (1j * shape.exact.omega + B))
    np.testing.assert_allclose(shape.exact.value, exact, rtol=1e-11)
    np.testing.assert_allclose(np.abs(shape.pade), np.abs(exact), rtol=1e-9)  # an all-pass changes the phase alone


def test_recoveries_are_one_response_scaled_to_each_peak(nominal):
    found = nominal.recoveries
    whole = pulse_response(fly().closed_loop(), nominal.result.pulse, 0.1)
    one = whole(found.time[found.time <= 0.1])[0]
    for peak, yaw in zip(found.peaks, found.yaw, strict=True):
        np.testing.assert_allclose(yaw[: len(one)], one * peak / TASK.peak, atol=1e-9)
    # the first 2 pi / bandwidth of a delay is where an approximation of order 4 errs, by some hundredths of a degree
    assert np.abs(found.yaw_pade - found.yaw).max() < 0.02 * found.peaks.max()


def test_strengths_and_peaks_follow_the_task(nominal):
    np.testing.assert_allclose(nominal.recoveries.peaks / deg, [5, 10, 20, 30, 40], rtol=1e-12)
    assert (np.diff(nominal.curve.peaks) > 0).all()
    assert nominal.curve.peaks[0] > TASK.tolerance
    assert nominal.curve.peaks[-1] == pytest.approx(45 * deg, rel=1e-12)


def test_the_curve_passes_through_the_recovery_of_the_nominal_pulse(nominal):
    at_20 = np.interp(20 * deg, nominal.curve.peaks, nominal.curve.times)
    assert at_20 == pytest.approx(nominal.result.recovery_time, rel=1e-4)  # between two of its peaks
    assert nominal.result.recovery_time == recovery_time(fly(), nominal.result.pulse)


def test_pade_poles_of_rising_order_approach_the_exact_ones(nominal):
    exact = nominal.result.poles[:3]
    errors = [np.abs(nominal.pade_poles[n][:3] - exact).max() for n in (1, 2, 4)]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-3 * np.abs(exact).max()


def test_loci_hold_the_loops_own_poles(nominal):
    for locus, own in ((nominal.gain_locus, 1.0), (nominal.delay_locus, T)):
        here = locus.branches[:, np.flatnonzero(locus.values == own)[0]]
        for pole in nominal.result.poles[:3]:
            if pole.imag >= 0:
                assert np.nanmin(np.abs(here - pole)) < 1e-10 * abs(pole)


def test_loci_cross_the_axis_where_the_margins_end(nominal):
    (gain,), (delay,) = nominal.gain_locus.crossings, nominal.delay_locus.crossings
    assert gain.value == pytest.approx(nominal.result.margins.gain_margin, rel=1e-10)
    assert delay.value == pytest.approx(T + nominal.result.margins.delay_margin, rel=1e-10)
    assert (nominal.gain_locus.status, nominal.delay_locus.status) == ("certified", "certified")


def test_a_locus_of_a_short_delay_reaches_to_where_stability_ends():
    early = fly(delay=0.5 * ms)
    (end,) = delay_locus(early).crossings
    assert end.value == pytest.approx(largest_stable_delay(B, KP, KD), rel=1e-10)


def test_the_phase_of_pade_is_off_by_one_degree_from_the_stated_frequency_on(nominal):
    w = nominal.shape.pade_errs_from

    def off(omega):
        L = fly().open_loop()
        return np.degrees(np.abs(np.angle(evaluate(pade(L, 4), omega) / evaluate(L, omega))))

    assert off(np.array([w]))[0] == pytest.approx(1.0, rel=1e-9)
    assert off(np.linspace(1.0, 0.999 * w, 50)).max() < 1.0


def test_nyquist_encirclements_are_the_unstable_poles(nominal):
    assert (nominal.shape.nyquist.count, nominal.shape.nyquist.status) == (0, "certified")
    unstable = loop_shape(fly(delay=0.05), 4)
    assert unstable.nyquist.closed_loop_unstable == (fly(delay=0.05).poles(8).real > 0).sum() > 0
    assert unstable.negative_crossings.min() < -1


def test_an_unstable_loop_is_studied_without_what_only_a_stable_one_has():
    unstable = study(fly(delay=0.05), TASK, [69.0, 176.0], deadline=60 * ms)
    assert not unstable.result.stable
    assert unstable.recoveries is None
    assert unstable.curve is None
    assert np.isfinite(unstable.closed_form_largest_delay)
    assert unstable.gain_locus.branches.shape[1] == len(unstable.gain_locus.values)


def test_progress_is_told_from_nothing_to_everything(nominal):
    assert TOLD[0][0] == 0
    assert TOLD[-1][0] == TOLD[-1][1]
    assert all(before[0] <= after[0] for before, after in pairwise(TOLD))
    assert all(what for _, _, what in TOLD)

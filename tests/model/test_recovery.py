"""Recovery of heading at b = 69 1/s, T = 3/220 s, pulse T/3: the published figures and an independent integration."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from flycontrol.errors import InvalidParameterError, UnstableSystemError
from flycontrol.model.perturbation import TorquePulse
from flycontrol.model.recovery import pulse_for_peak, pulse_response, recovery_curve, recovery_time
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg, ms

B, T = 69.0, 3 / 220
PULSE = T / 3


def loop(kp: float, kd: float, b: float = B, delay: float = T) -> YawLoop:
    return YawLoop.from_rates(b=b, kp=kp, kd=kd, delay=delay)


def method_of_steps(kp, kd, torque, end, *, pulse=PULSE, delay=T, b=B):
    """Yaw from DOP853 at 1e-12, restarted at every multiple of the delay after either edge of the pulse.

    Independent of the package: psi'' = -b psi' - (kp psi + kd psi')(t - T) + N.
    """
    kinks = np.unique(np.round(np.concatenate([np.arange(0, end, delay), pulse + np.arange(0, end, delay), [end]]), 15))
    kinks = kinks[kinks <= end]
    pieces = []
    state = np.zeros(2)
    for start, stop in pairwise(kinks):
        middle = (start + stop) / 2
        past = next((p[2] for p in pieces if p[0] <= middle - delay < p[1]), None)

        def slope(t, x, past=past, push=torque if middle < pulse else 0.0):
            psi, rate = past(t - delay) if past else (0.0, 0.0)
            return [x[1], -b * x[1] - kp * psi - kd * rate + push]

        step = (stop - start) / 8
        found = solve_ivp(
            slope, (start, stop), state, method="DOP853", rtol=1e-12, atol=1e-15, max_step=step, dense_output=True
        )
        pieces.append((start, stop, found.sol))
        state = found.y[:, -1]

    def yaw(times):
        k = np.clip(np.searchsorted(kinks, times, side="right") - 1, 0, len(pieces) - 1)
        return np.array([pieces[i][2](t)[0] for i, t in zip(k, times, strict=True)])

    return yaw


@pytest.mark.parametrize(
    ("kp", "kd", "delay", "pulse"),
    [
        (3050.0, 45.0, T, PULSE),
        (3523.0, 64.0, T, PULSE),
        (900.0, 20.0, 0.013123, 0.0047111),  # edges and delay off any sampling grid
        (3050.0, 45.0, 0.00971, 0.0317),  # a pulse longer than the delay
    ],
)
def test_yaw_agrees_with_an_independent_method_of_steps_to_1e_7_deg(kp, kd, delay, pulse):
    torque = 20 * deg / 3e-5  # peaks at some tens of degrees
    exact = method_of_steps(kp, kd, torque, 0.1, pulse=pulse, delay=delay)
    t = np.linspace(0.0, 0.0999, 801)  # the 8 kHz of a camera, unrelated to edges and delay
    whole = pulse_response(loop(kp, kd, delay=delay).closed_loop(), TorquePulse(duration=pulse, torque=torque), 0.1)
    yaw = exact(t)
    assert np.abs(yaw).max() > 10 * deg
    assert np.abs(whole(t)[0] - yaw).max() < 1e-7 * deg


def times_in_ms(kp, kd, peaks):
    return [f"{t / ms:.1f}" for t in recovery_curve(loop(kp, kd), PULSE, np.array(peaks) * deg).times]


def test_gains_3523_and_64_recover_in_the_published_times():
    assert times_in_ms(3523.0, 64.0, [2.2, 3, 5, 10, 20, 25]) == ["27.1", "33.4", "39.2", "44.2", "47.4", "48.1"]


def test_gains_3050_and_45_recover_in_the_published_times():
    expected = ["29.7", "37.4", "45.0", "51.8", "56.5", "58.4", "59.5"]
    assert times_in_ms(3050.0, 45.0, [2.2, 3, 5, 10, 20, 30, 40]) == expected


def test_gains_3523_and_64_jump_to_88_ms_at_29_9_deg_where_the_second_swing_leaves_the_band():
    curve = recovery_curve(loop(3523.0, 64.0), PULSE, np.array([29.8, 29.9, 29.95, 30.0]) * deg)
    assert f"{curve.jumps[0] / deg:.1f}" == "29.9"
    assert f"{100 * 2 * deg / curve.jumps[0]:.2f}" == "6.68"
    assert curve.times[1] < 50 * ms
    assert round(curve.times[2] / ms) == 88
    later = np.sort(curve.swings[1:])[-1]
    assert f"{100 * later:.2f}" == "6.68"


def test_gains_3050_and_45_never_jump_below_40_deg():
    assert not recovery_curve(loop(3050.0, 45.0), PULSE, np.array([5.0, 40.0]) * deg).jumps.size


@pytest.mark.parametrize(
    ("kp", "kd", "peak"), [(3050.0, 45.0, 20.0), (3523.0, 64.0, 30.5), (3523.0, 64.0, 5.0), (1500.0, 0.0, 20.0)]
)
def test_recovery_is_the_last_sample_outside_of_a_dense_independent_response(kp, kd, peak):
    pulse = pulse_for_peak(loop(kp, kd), PULSE, peak * deg)
    t = np.linspace(0.0, 0.16, 32_001)
    yaw = method_of_steps(kp, kd, pulse.torque, 0.16)(t)
    assert np.abs(yaw).max() == pytest.approx(peak * deg, rel=1e-5)  # the samples' own resolution of the peak
    last = t[np.abs(yaw) > 2 * deg].max()
    found = recovery_time(loop(kp, kd), pulse)
    assert last <= found <= last + 0.16 / 32_000


@pytest.mark.parametrize(("kp", "kd"), [(3050.0, 45.0), (3523.0, 64.0), (1500.0, 0.0), (900.0, 20.0)])
def test_the_pulse_for_a_peak_peaks_there(kp, kd):
    pulse = pulse_for_peak(loop(kp, kd), PULSE, 20 * deg)
    near = pulse_response(loop(kp, kd).closed_loop(), pulse, 0.06)(np.linspace(0.0, 0.06, 600_001))[0]
    assert near.max() == pytest.approx(20 * deg, rel=1e-9)  # 1e-7 s off a flat peak cost 1e-12


@settings(derandomize=True, deadline=None, max_examples=15)
@given(st.floats(0.1, 50.0))
def test_recovery_depends_on_strength_and_band_only_through_their_ratio(factor):
    fly, pulse = loop(3050.0, 45.0), TorquePulse(duration=PULSE, torque=3e4)
    once = recovery_time(fly, pulse, 2 * deg)
    assert recovery_time(fly, pulse.times(factor), 2 * factor * deg) == pytest.approx(once, rel=1e-9)
    assert recovery_time(fly, pulse.times(-1.0), 2 * deg) == pytest.approx(once, rel=1e-12)


def test_one_curve_gives_the_times_of_single_recoveries():
    fly, peaks = loop(3523.0, 64.0), np.array([2.5, 7.0, 33.0]) * deg
    curve = recovery_curve(fly, PULSE, peaks)
    singly = [recovery_time(fly, pulse_for_peak(fly, PULSE, peak)) for peak in peaks]
    np.testing.assert_allclose(curve.times, singly, rtol=1e-9)


def test_recovery_never_gets_shorter_with_strength():
    curve = recovery_curve(loop(3523.0, 64.0), PULSE, np.linspace(2.01, 60, 400) * deg)
    assert (np.diff(curve.times) >= 0).all()


def test_a_deflection_inside_the_band_needs_no_recovery():
    fly = loop(3050.0, 45.0)
    assert recovery_time(fly, pulse_for_peak(fly, PULSE, 1.99 * deg)) == 0.0


def test_an_unstable_loop_is_refused_in_a_sentence():
    unstable = loop(3050.0, 45.0, delay=0.1)
    for ask in (
        lambda: recovery_time(unstable, TorquePulse(duration=PULSE)),
        lambda: pulse_for_peak(unstable, PULSE, 20 * deg),
        lambda: recovery_curve(unstable, PULSE, [20 * deg]),
    ):
        with pytest.raises(UnstableSystemError, match=r"unstable \(rightmost pole at \+"):
            ask()


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan])
def test_a_band_without_width_is_refused(tolerance):
    with pytest.raises(InvalidParameterError, match="must be > 0 rad"):
        recovery_time(loop(3050.0, 45.0), TorquePulse(duration=PULSE), tolerance)


@pytest.mark.parametrize(("duration", "torque"), [(0.0, 1.0), (-1.0, 1.0), (np.nan, 1.0), (1.0, np.inf)])
def test_a_pulse_that_no_coil_can_make_is_refused(duration, torque):
    with pytest.raises(InvalidParameterError, match=r"TorquePulse\."):
        TorquePulse(duration=duration, torque=torque)

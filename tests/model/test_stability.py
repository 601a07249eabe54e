import numpy as np
import pytest

from flycontrol.model.gains import PulseTask
from flycontrol.model.recovery import pulse_response
from flycontrol.model.stability import Mode, assess
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg, ms

T = 3 / 220
TASK = PulseTask(duration=T / 3, peak=20 * deg, tolerance=2 * deg)


def fly(delay: float = T) -> YawLoop:
    return YawLoop.from_rates(b=69.0, kp=3050.0, kd=45.0, delay=delay)


def test_the_published_fly_is_stable_and_recovers_within_60_ms_and_15_wingbeats():
    result = assess(fly(), TASK)
    assert result.stable
    assert result.reason is None
    assert result.recovery_time < 60 * ms
    assert result.recovery_time * 220 < 15


def test_the_pulse_of_a_result_deflects_its_loop_to_the_peak_of_the_task():
    result = assess(fly(), TASK)
    value, _ = pulse_response(fly().closed_loop(), result.pulse, 0.1).largest()
    assert value == pytest.approx(20 * deg, rel=1e-4)


def test_an_unstable_loop_is_a_result_with_a_reason_and_without_margins():
    result = assess(fly(delay=0.05), TASK)
    assert not result.stable
    assert result.margins is None
    assert result.recovery_time is None
    assert result.pulse is None
    assert "unstable" in result.reason
    assert f"{result.poles[0].real:+.4g}" in result.reason


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_the_verdict_changes_at_the_largest_stable_delay(factor):
    edge = T + fly().margins().delay_margin
    assert assess(fly(delay=factor * edge), TASK).stable == (factor < 1)


def test_the_poles_of_a_result_lie_within_their_stated_errors():
    result = assess(fly(), TASK)
    s = result.poles
    lag = np.exp(-s * T)
    f = s**2 + 69.0 * s + (3050.0 + 45.0 * s) * lag
    slope = 2 * s + 69.0 + (45.0 - T * (3050.0 + 45.0 * s)) * lag
    # double precision evaluates the equation itself to about 1e-15 of its largest term
    assert (np.abs(f / slope) <= result.pole_errors + 1e-12 * np.abs(s)).all()


def test_a_pair_of_poles_is_one_mode_and_modes_come_slowest_first():
    modes = assess(fly(), TASK).modes
    assert all(mode.root.imag >= 0 for mode in modes)
    times = [mode.time_constant for mode in modes]
    assert times == sorted(times, reverse=True)


def test_a_modes_figures_are_those_of_its_root():
    mode = Mode(root=complex(-30.0, 40.0))
    assert mode.time_constant == pytest.approx(1 / 30.0)
    assert mode.frequency == pytest.approx(40.0 / (2 * np.pi))
    assert mode.damping_ratio == pytest.approx(0.6)


def test_a_loop_too_slow_to_follow_is_stable_without_a_recovery_and_says_why():
    slow = assess(YawLoop.from_rates(b=69.0, kp=0.5, kd=45.0, delay=T), TASK)
    assert slow.stable
    assert slow.margins is not None
    assert slow.recovery_time is None
    assert "not settled" in slow.reason

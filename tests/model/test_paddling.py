import numpy as np
import pytest

from flycontrol.model.paddling import paddling
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.wingbeats import segment_wingbeats
from flycontrol.units import deg

RATE, FREQUENCY = 7500.0, 187.5


def flight(d_alpha: float, glitch: float = 0.0) -> Recording:
    """Attack angle 45 deg with square-edged pitch; `glitch` is added to the right pitch near reversal only."""
    time = np.arange(600) / RATE
    phase = 2 * np.pi * FREQUENCY * time
    eta = 90 * deg - 45 * deg * np.tanh(20 * np.sin(phase))
    near_reversal = np.abs(np.sin(phase)) < 0.15
    wings = {
        side: WingAngles(
            stroke=-70 * deg * np.cos(phase),
            deviation=np.zeros_like(time),
            pitch=eta + sign * d_alpha + (glitch * near_reversal if sign > 0 else 0.0),
        )
        for side, sign in (("left", -1), ("right", 1))
    }
    return Recording(name="made", rate=RATE, time=time, source_sha256="", **wings)


def test_d_alpha_is_what_the_right_wing_has_more_on_the_forward_stroke():
    recording = flight(3 * deg)
    found = paddling(recording, segment_wingbeats(recording))
    np.testing.assert_allclose(found.d_alpha, 3 * deg, rtol=1e-9)
    excess = found.mean_attack_right - found.mean_attack_left
    # right minus left is twice d_alpha forward and minus twice backward, as Fig. 7d plots it
    np.testing.assert_allclose(excess, np.tile([6 * deg, -6 * deg], (len(excess), 1)), rtol=1e-6)


def test_mean_attack_angles_are_those_of_the_sweeps_middle():
    recording = flight(0.0)
    found = paddling(recording, segment_wingbeats(recording))
    np.testing.assert_allclose(found.mean_attack_left, 45 * deg, atol=0.5 * deg)


def test_what_happens_at_reversal_hardly_counts():
    recording = flight(0.0, glitch=30 * deg)
    found = paddling(recording, segment_wingbeats(recording))
    # 15 deg of d_alpha in two of forty samples: 0.75 deg evenly averaged, weighted by sin^2 < 0.15^2 a fiftieth of it
    assert np.mean(found.series) > 0.7 * deg
    assert np.max(np.abs(found.d_alpha)) < 0.1 * deg


def test_the_mean_wing_speed_of_a_sine_stroke_is_four_amplitudes_a_wingbeat():
    recording = flight(0.0)
    found = paddling(recording, segment_wingbeats(recording))
    assert found.mean_wing_speed == pytest.approx(4 * 70 * deg * FREQUENCY, rel=5e-3)

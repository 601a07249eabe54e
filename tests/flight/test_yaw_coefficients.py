from dataclasses import replace

import numpy as np
import pytest

from flycontrol.flight.yaw_coefficients import yaw_coefficients
from flycontrol.model.morphology import drosophila_hydei
from flycontrol.model.stroke import WingMotion
from flycontrol.units import deg

FLY = drosophila_hydei()
PHASE = 2 * np.pi * (np.arange(2000) + 0.5) / 2000
OMEGA = 2 * np.pi * 189.0


def flat_sine_stroke(attack: float = 45 * deg) -> WingMotion:
    """Sine stroke in the stroke plane at one attack angle, pitch switched at reversal."""
    rate = 70 * deg * OMEGA * np.sin(PHASE)
    zero = np.zeros_like(PHASE)
    return WingMotion(
        stroke=-70 * deg * np.cos(PHASE),
        deviation=zero,
        pitch=np.where(rate > 0, attack, np.pi - attack),
        stroke_rate=rate,
        deviation_rate=zero,
        pitch_rate=zero,
    )


def test_a_sine_stroke_multiplies_eq_5_by_pi_squared_over_eight():
    """gamma/beta = C_D' <phi'^2> / (2 C_D <|phi'|>), and <phi'^2> = (pi^2/8) <|phi'|>^2, hinges on the yaw axis."""
    found = yaw_coefficients(replace(FLY, right_hinge=(0.0, 0.0, 0.0)), flat_sine_stroke(), np.zeros(3))
    assert found.turn_gain_over_wing_speed == pytest.approx(np.pi**2 / 8 * found.drag_slope_ratio, rel=1e-4)
    assert found.mean_wing_speed == pytest.approx(4 * 70 * deg * 189.0, rel=1e-5)


def test_hinges_out_to_the_side_lower_the_turn_gain_by_about_a_fifth():
    on_axis = yaw_coefficients(replace(FLY, right_hinge=(0.0, 0.0, 0.0)), flat_sine_stroke(), np.zeros(3))
    apart = yaw_coefficients(FLY, flat_sine_stroke(), np.zeros(3))
    assert 0.1 < 1 - apart.turn_gain / on_axis.turn_gain < 0.25


def test_damping_and_paddling_are_positive_and_roll_does_not_yaw_a_stroke_symmetric_fore_and_aft():
    low = replace(FLY, right_hinge=(0.0, FLY.right_hinge[1], FLY.right_hinge[2]))
    found = yaw_coefficients(low, flat_sine_stroke(), np.zeros(3))
    assert found.damping > 0
    assert found.paddling > 0
    assert abs(found.roll_to_yaw) < 1e-3 * found.damping

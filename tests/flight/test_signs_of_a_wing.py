"""Which way each wing motion pushes and turns the fly; x forward, y right, z down, yaw to the right > 0."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flycontrol.flight.aerodynamics import BodyMotion, FlightLoads, flight_loads
from flycontrol.flight.blades import beta_blades
from flycontrol.flight.coefficients import dickinson1999
from flycontrol.model.morphology import drosophila_hydei, pitch_rotation
from flycontrol.model.stroke import WingMotion, attack_angle
from flycontrol.units import deg

FLY = drosophila_hydei()
SPEED = 1000.0  # rad/s
RADIUS = FLY.second_moment_radius * FLY.wing_length


def instant(sweep: float = 0.0, pitch: float = 45 * deg, rise: float = 0.0, stroke: float = 0.0) -> WingMotion:
    zero = np.zeros(1)
    return WingMotion(
        stroke=zero + stroke, deviation=zero, pitch=zero + pitch, stroke_rate=zero + sweep, deviation_rate=zero + rise,
        pitch_rate=zero,
    )  # fmt: skip


def loads(left: WingMotion, right: WingMotion) -> FlightLoads:
    return flight_loads(FLY, left, right, BodyMotion(velocity=np.zeros((1, 3)), angular_velocity=np.zeros((1, 3))))


@pytest.mark.parametrize(("way", "pitch"), [(1, 45 * deg), (-1, 135 * deg)])
def test_on_both_half_strokes_the_wing_lifts_and_drags_by_the_coefficients_at_its_attack_angle(way, pitch):
    """Attack angle eta forward and 180 deg - eta backward: 45 deg on both; lift up, drag against the sweep."""
    motion = instant(way * SPEED, pitch)
    attack = attack_angle(motion.pitch, motion.stroke_rate)
    assert attack[0] == pytest.approx(45 * deg)
    lift, drag = (float(c[0]) for c in dickinson1999(attack))
    pressure = 0.5 * 1.19 * FLY.wing_area * (SPEED * RADIUS) ** 2
    force = loads(motion, motion).right.total.force[0]
    np.testing.assert_allclose(force, pressure * np.array([-way * drag, 0.0, -lift]), atol=1e-9 * pressure)


def test_drag_of_the_right_wing_turns_right_going_forward_and_left_going_back():
    still = instant()
    assert loads(still, instant(SPEED)).right.total.torque[0, 2] > 0
    assert loads(still, instant(-SPEED, 135 * deg)).right.total.torque[0, 2] < 0


def test_more_lift_on_the_right_rolls_left():
    motion = instant(SPEED)
    assert loads(instant(0.8 * SPEED), motion).total.torque[0, 0] < 0


def test_lift_ahead_pitches_up_and_lift_behind_pitches_down():
    forward, backward = (instant(SPEED, stroke=stroke) for stroke in (40 * deg, -40 * deg))
    assert loads(forward, forward).total.torque[0, 1] > loads(backward, backward).total.torque[0, 1]


def test_a_wing_that_rises_is_pushed_down():
    motion = instant(rise=SPEED, pitch=0.0)
    assert loads(motion, motion).right.total.force[0, 2] > 0


def test_a_turn_about_each_axis_is_right_handed_in_forward_right_down():
    """Yaw > 0 carries the nose to the right, pitch > 0 up, roll > 0 the right wing down."""
    forward, right, down = np.eye(3)
    assert np.dot(Rotation.from_rotvec(0.1 * down).apply(forward), right) > 0
    assert np.dot(Rotation.from_rotvec(0.1 * right).apply(forward), down) < 0
    assert np.dot(Rotation.from_rotvec(0.1 * forward).apply(right), down) > 0


def test_the_stroke_plane_is_pitched_nose_down_from_the_body():
    """v_S = Ry(angle) v_B: the body's nose stands above the stroke plane."""
    nose_S = pitch_rotation(FLY.stroke_plane_angle) @ np.array([1.0, 0.0, 0.0])
    assert nose_S[2] == pytest.approx(-np.sin(FLY.stroke_plane_angle))


def test_the_beta_blades_give_the_pressure_its_radius():
    blades = beta_blades(FLY.wing_length, FLY.mean_chord, FLY.second_moment_radius)
    assert np.sum(blades.area * blades.radius**2) == pytest.approx(FLY.wing_area * RADIUS**2, rel=1e-12)

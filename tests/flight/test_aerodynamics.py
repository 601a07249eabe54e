from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.special import beta as beta_function

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.flight.aerodynamics import BodyMotion, FlightLoads, QuasiSteadyModel, flight_loads
from flycontrol.flight.blades import BladeElements, beta_blades, table_blades
from flycontrol.flight.coefficients import dickinson1999, wang2004
from flycontrol.model.morphology import drosophila_hydei
from flycontrol.model.planform import ChordTable
from flycontrol.model.stroke import WingMotion, wing_axes
from flycontrol.units import deg

FLY = drosophila_hydei()
OMEGA = 2 * np.pi * 189.0
PHASE = 2 * np.pi * np.arange(400) / 400


def stroke(paddling: float = 0.0, lag: float = 0.1) -> WingMotion:
    """A sine stroke with a figure-of-eight deviation and a sine pitch."""
    return WingMotion(
        stroke=-70 * deg * np.cos(PHASE) - 4 * deg,
        deviation=10 * deg * np.sin(2 * PHASE),
        pitch=90 * deg - 45 * deg * np.sin(PHASE + lag) + paddling,
        stroke_rate=70 * deg * OMEGA * np.sin(PHASE),
        deviation_rate=20 * deg * OMEGA * np.cos(2 * PHASE),
        pitch_rate=-45 * deg * OMEGA * np.cos(PHASE + lag),
    )


def still_air(velocity=(0.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 0.0), n: int = len(PHASE)) -> BodyMotion:
    return BodyMotion(velocity=np.tile(velocity, (n, 1)), angular_velocity=np.tile(angular_velocity, (n, 1)))


def mean_torque(loads: FlightLoads) -> np.ndarray:
    return loads.total.torque.mean(axis=0)


def test_a_mirror_symmetric_stroke_makes_no_yaw_no_roll_and_no_side_force():
    forward_flight = still_air(velocity=(0.3, 0.0, -0.1), angular_velocity=(0.0, 5.0, 0.0))
    total = flight_loads(FLY, stroke(), stroke(), forward_flight).total
    rounding = 1e-12 * FLY.weight
    assert np.max(np.abs(total.force[:, 1])) < rounding
    assert np.max(np.abs(total.torque[:, [0, 2]])) < rounding * FLY.wing_length


def test_a_left_right_swap_flips_roll_yaw_and_side_force_and_nothing_else():
    one, other = stroke(paddling=5 * deg), stroke(lag=0.3)
    there = flight_loads(FLY, one, other, still_air(angular_velocity=(3.0, 2.0, 7.0), velocity=(0.2, 0.1, 0.0))).total
    back = flight_loads(FLY, other, one, still_air(angular_velocity=(-3.0, 2.0, -7.0), velocity=(0.2, -0.1, 0.0))).total
    np.testing.assert_allclose(there.force, back.force * [1, -1, 1], atol=1e-12 * FLY.weight)
    np.testing.assert_allclose(there.torque, back.torque * [-1, 1, -1], atol=1e-15 * FLY.weight)


def test_paddling_turns_right():
    loads = flight_loads(FLY, stroke(-5 * deg), stroke(+5 * deg), still_air())
    assert mean_torque(loads)[2] > 0.01 * FLY.weight * FLY.wing_length


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_rotation_of_the_body_is_resisted_about_every_axis(axis):
    rate = 10.0 * np.eye(3)[axis]
    plus = mean_torque(flight_loads(FLY, stroke(), stroke(), still_air(angular_velocity=rate)))
    minus = mean_torque(flight_loads(FLY, stroke(), stroke(), still_air(angular_velocity=-rate)))
    assert (plus - minus)[axis] < 0


def test_a_sine_stroke_of_the_fly_lifts_between_half_and_twice_its_weight():
    lift = -flight_loads(FLY, stroke(), stroke(), still_air()).total.force[:, 2].mean()
    assert 0.5 < lift / FLY.weight < 2.0


def test_six_nodes_equal_two_thousand_even_blades():
    # near reversal every blade has its own attack angle and some meet the air tail first: the load is no polynomial
    # in r there, but small; over the wingbeat the difference is that of the even blades' midpoint rule
    moving = still_air(velocity=(0.3, 0.1, -0.1), angular_velocity=(10.0, -5.0, 30.0))
    few = flight_loads(FLY, stroke(3 * deg), stroke(), moving).total
    many = flight_loads(FLY, stroke(3 * deg), stroke(), moving, blades=even_blades(2000)).total
    for six, even in ((few.force, many.force), (few.torque, many.torque)):
        assert np.max(np.abs(six - even)) < 5e-4 * np.max(np.abs(even))
        assert np.max(np.abs((six - even).mean(axis=0))) < 1e-5 * np.max(np.abs(even))


def even_blades(count: int) -> BladeElements:
    """Midpoint blades of the same beta distribution, written down independently."""
    r2 = FLY.second_moment_radius
    r1 = (r2 / 0.929) ** (1 / 0.732)
    k = r1 * (1 - r1) / (r2**2 - r1**2) - 1
    p, q = r1 * k, (1 - r1) * k
    x = (np.arange(count) + 0.5) / count
    chord = FLY.mean_chord * x ** (p - 1) * (1 - x) ** (q - 1) / beta_function(p, q)
    return BladeElements(radius=FLY.wing_length * x, area=chord * FLY.wing_length / count)


def test_the_nodes_have_the_wings_area_and_second_moment():
    blades = beta_blades(3e-3, 1e-3, 0.58)
    assert blades.area.sum() == pytest.approx(3e-6, rel=1e-14)
    assert np.sqrt(np.sum(blades.area * blades.radius**2) / 3e-6) / 3e-3 == pytest.approx(0.58, rel=1e-12)


def test_nodes_of_a_chord_table_integrate_its_moments_exactly():
    span, chord = np.array([0.0, 0.2, 0.7, 1.0]), np.array([0.1, 0.6, 1.0, 0.0])
    blades = table_blades(span, chord, length=1.0, area=1.0, nodes=5)
    fine = (np.arange(200_000) + 0.5) / 200_000
    weight = np.interp(fine, span, chord)
    for power in range(10):  # five nodes: exact to degree nine
        moment = np.sum(weight * fine**power) / np.sum(weight)
        assert np.sum(blades.area * blades.radius**power) == pytest.approx(moment, rel=1e-8)


def test_at_constant_speed_gamma_over_beta_is_omega_times_the_slope_over_twice_the_drag():
    """Eq. 2: with the hinges on the yaw axis, d psi'/d d_alpha = omega C_D' / (2 C_D) exactly."""
    speed, alpha, step = 900.0, 45 * deg, 1e-4
    coaxial = replace(FLY, right_hinge=(0.0, 0.0, 0.0))
    blades = beta_blades(FLY.wing_length, FLY.mean_chord, FLY.second_moment_radius)

    def yaw_torque(paddling: float, yaw_rate: float) -> float:
        body = still_air(angular_velocity=(0.0, 0.0, yaw_rate), n=2)
        left, right = (constant_speed(speed, alpha, side * paddling) for side in (-1, 1))
        return float(mean_torque(flight_loads(coaxial, left, right, body, blades=blades))[2])

    gamma = (yaw_torque(step, 0.0) - yaw_torque(-step, 0.0)) / (2 * step)
    beta = -(yaw_torque(0.0, step) - yaw_torque(0.0, -step)) / (2 * step)
    drag = dickinson1999(np.array([alpha - step, alpha, alpha + step])).drag
    expected = speed * (drag[2] - drag[0]) / (2 * step) / (2 * drag[1])
    assert gamma / beta == pytest.approx(expected, rel=1e-7)
    assert gamma / beta / speed == pytest.approx(0.92, abs=0.01)


def constant_speed(speed: float, alpha: float, paddling: float) -> WingMotion:
    """Mid-stroke of a forward and of a backward half stroke."""
    zero = np.zeros(2)
    return WingMotion(
        stroke=zero,
        deviation=zero,
        pitch=np.array([alpha, np.pi - alpha]) + paddling,
        stroke_rate=np.array([speed, -speed]),
        deviation_rate=zero,
        pitch_rate=zero,
    )


def test_drag_opposes_the_motion_and_lift_takes_no_power():
    """Power of the air on a wing on a fixed body: -1/2 rho C_D u^3 summed over blades, whatever the lift."""
    motion = stroke(7 * deg)
    loads = flight_loads(replace(FLY, right_hinge=(0.0, 0.0, 0.0)), motion, motion, still_air())
    sweep = motion.stroke_rate * np.cos(motion.deviation)
    axes = wing_axes(motion, "right")
    spin = np.cross(axes.span, sweep[:, None] * axes.forward + motion.deviation_rate[:, None] * axes.upward)
    power = np.sum(loads.right.total.torque * spin, axis=1)
    blades = beta_blades(FLY.wing_length, FLY.mean_chord, FLY.second_moment_radius)
    speed = np.hypot(sweep, motion.deviation_rate)
    tilt = np.arctan2(motion.deviation_rate, sweep)
    attack = np.abs(np.mod(motion.pitch - tilt + np.pi / 2, np.pi) - np.pi / 2)
    expected = -0.5 * 1.19 * np.sum(blades.area * blades.radius**3) * dickinson1999(attack).drag * speed**3
    np.testing.assert_allclose(power, expected, rtol=1e-9)


def test_dickinsons_and_wangs_coefficients_agree_on_what_both_measured():
    attack = np.linspace(10, 80, 15) * deg
    at_45 = dickinson1999(np.array([45 * deg]))
    # sin(88.65 deg) and cos(81.98 deg) by hand
    assert at_45.lift[0] == pytest.approx(0.225 + 1.58 * 0.999722, rel=1e-5)
    assert at_45.drag[0] == pytest.approx(1.92 - 1.55 * 0.139520, rel=1e-5)
    assert np.all(wang2004(attack).drag > 0)
    assert np.corrcoef(dickinson1999(attack).lift, wang2004(attack).lift)[0, 1] > 0.99


def test_the_terms_of_a_wing_sum_to_its_total():
    loads = flight_loads(FLY, stroke(), stroke(), still_air())
    for field in fields(loads.left.total):
        parts = sum(getattr(term, field.name) for term in loads.left.terms.values())
        np.testing.assert_array_equal(parts, getattr(loads.left.total, field.name))


def test_unknown_coefficients_and_unequal_lengths_are_refused_in_a_sentence():
    with pytest.raises(InvalidParameterError, match="choose one of dickinson1999, wang2004"):
        QuasiSteadyModel(coefficients="nobody1900")  # pyright: ignore[reportArgumentType]
    with pytest.raises(InvalidInputError, match="same instants"):
        flight_loads(FLY, stroke(), stroke(), still_air(n=3))


def test_the_air_sees_the_chords_of_a_table():
    """About a fixed hinge all blades move alike: translation's force is as the integral of c r^2, area times r2^2."""
    tables = [ChordTable(span=(0.0, 1.0), chord=(1.0, 1.0)), ChordTable(span=(0.0, 1.0), chord=(0.0, 1.0))]
    forces = [
        flight_loads(replace(FLY, chord_table=table), stroke(), stroke(), still_air()).left.terms["translational"].force
        for table in tables
    ]
    assert np.allclose(forces[1] / (1 / 2), forces[0] / (1 / 3), rtol=1e-12, atol=1e-12 * FLY.weight)

"""The quasi-steady terms of the compiled blades: signs, symmetry, closed forms, an independent implementation."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_fly import ASYMMETRIC, FLY, FREQUENCY, MELANOGASTER, SYMMETRIC, rms, swapped

from flycontrol.flight.aerodynamics import BodyMotion, FlightLoads, flight_loads
from flycontrol.flight.coefficient_series import coefficient_series
from flycontrol.flight.coefficients import COEFFICIENTS
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.multibody.freedoms import HELD
from flycontrol.flight.quasi_steady import TERMS, QuasiSteadyModel
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.flight.state_vector import level_start
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import Trajectory, wing_motion_of
from flycontrol.model.wing_stroke import paddling
from flycontrol.units import deg

EVERY_STEP = MarchSettings(samples=200)


def held_flight(stroke: StrokeKinematics, velocity=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0)) -> Trajectory:
    """One wingbeat of a body that keeps its velocity and angular velocity."""
    start = replace(level_start(stroke, velocity), angular_velocity_S=np.array(spin, dtype=float))
    return simulate_flight(replace(FLY, body=HELD), stroke, 1, start=start, settings=EVERY_STEP)


def at_rest(angles, rates, accelerations=(0.0, 0.0, 0.0)) -> Trajectory:
    """One instant of both wings alike on a body at rest."""
    motion = wing_motion_of(np.array([angles], dtype=float), np.array([rates], dtype=float))
    one = held_flight(SYMMETRIC)
    first = {name: getattr(one, name)[:1] for name in (
        "time", "phase", "position_W", "q_WS", "velocity_S", "angular_velocity_S", "acceleration_S",
        "angular_acceleration_S",
    )}  # fmt: skip
    turned = np.array([accelerations], dtype=float)
    return replace(one, **first, left=motion, right=motion, left_acceleration=turned, right_acceleration=turned)


def mean_torque(loads: FlightLoads) -> np.ndarray:
    return loads.total.torque[:-1].mean(axis=0)


@pytest.mark.parametrize("name", list(COEFFICIENTS))
def test_the_series_are_the_coefficients(name):
    attack = np.linspace(0.0, np.pi / 2, 2001)
    z = np.sin(attack - np.pi / 4)
    even_lift, odd_lift, even_drag, odd_drag, arc = (np.polyval(s[::-1], z**2) for s in coefficient_series(name))
    expected = COEFFICIENTS[name](attack)
    np.testing.assert_allclose(even_lift + z * odd_lift, expected.lift, atol=2e-10)
    np.testing.assert_allclose(even_drag + z * odd_drag, expected.drag, atol=2e-10)
    np.testing.assert_allclose(z * arc, attack - np.pi / 4, atol=1e-10)


@pytest.mark.parametrize("name", list(COEFFICIENTS))
def test_translational_loads_are_those_of_the_plain_blade_elements(name):
    """NumPy, arctangent, sine and world axes, against velocity ratios and the wing's axes; force on the pitch axis."""
    air = QuasiSteadyModel(coefficients=name, centre_of_pressure=(MELANOGASTER.pitch_axis, 0.0))
    flight = held_flight(ASYMMETRIC, velocity=(0.4, 0.2, -0.3), spin=(20.0, -30.0, 40.0))
    ours = loads_along(replace(FLY, air=air), flight)
    body = BodyMotion(velocity=flight.velocity_S, angular_velocity=flight.angular_velocity_S)
    theirs = flight_loads(MELANOGASTER, flight.left, flight.right, body, air)
    for side in ("left", "right"):
        one, other = getattr(ours, side).terms["translational"], getattr(theirs, side).terms["translational"]
        np.testing.assert_allclose(one.force, other.force, atol=1e-9 * rms(other.force))
        np.testing.assert_allclose(one.torque, other.torque, atol=1e-9 * rms(other.torque))


def test_a_mirror_symmetric_flight_has_no_side_force_no_roll_and_no_yaw_in_any_term():
    loads = loads_along(FLY, held_flight(SYMMETRIC, velocity=(0.3, 0.0, -0.2), spin=(0.0, 15.0, 0.0)))
    for term in TERMS:
        total = loads.left.terms[term], loads.right.terms[term]
        np.testing.assert_array_equal(total[0].force * [1, -1, 1], total[1].force)
        np.testing.assert_array_equal(total[0].torque * [-1, 1, -1], total[1].torque)


def test_a_left_right_swap_flips_side_force_roll_and_yaw_of_every_term():
    there = loads_along(FLY, held_flight(ASYMMETRIC, velocity=(0.3, 0.1, -0.2), spin=(5.0, 15.0, -9.0)))
    back = loads_along(FLY, held_flight(swapped(ASYMMETRIC), velocity=(0.3, -0.1, -0.2), spin=(-5.0, 15.0, 9.0)))
    for term in TERMS:
        np.testing.assert_array_equal(there.left.terms[term].force * [1, -1, 1], back.right.terms[term].force)
        np.testing.assert_array_equal(there.left.terms[term].torque * [-1, 1, -1], back.right.terms[term].torque)


def test_paddling_turns_right_and_a_turning_body_is_resisted():
    straight = mean_torque(loads_along(FLY, held_flight(SYMMETRIC)))
    paddled = mean_torque(loads_along(FLY, held_flight(SYMMETRIC.modulated(*paddling(5 * deg)))))
    assert paddled[2] - straight[2] > 0.01 * MELANOGASTER.weight * MELANOGASTER.wing_length
    for axis in range(3):
        turning = mean_torque(loads_along(FLY, held_flight(SYMMETRIC, spin=20.0 * np.eye(3)[axis])))
        assert (turning - straight)[axis] < 0


def test_going_forward_at_45_deg_the_right_wing_lifts_and_its_drag_turns_right():
    load = loads_along(FLY, at_rest((0.0, 0.0, np.pi / 4), (1000.0, 0.0, 0.0))).right.terms["translational"]
    assert load.force[0, 0] < 0  # backward
    assert load.force[0, 2] < 0  # up
    assert load.torque[0, 2] > 0  # right


def test_rotational_force_is_rho_C_R_c2_times_spin_and_speed():
    """Mid-stroke, chord level: F = rho C_R phi' eta' integral of c^2 r dr, upward for a nose that rises."""
    sweep, spin = 900.0, 400.0
    load = loads_along(FLY, at_rest((0.0, 0.0, 0.0), (sweep, 0.0, spin))).right.terms["rotational"]
    plan = MELANOGASTER.planform
    expected = 1.19 * np.pi * (0.75 - MELANOGASTER.pitch_axis) * sweep * spin * plan.moment(2, 1)
    np.testing.assert_allclose(load.force[0], [0.0, 0.0, -expected], rtol=1e-12, atol=1e-12 * expected)


def test_carried_air_resists_acceleration_by_its_moments_of_inertia():
    """Vertical chord at rest: pi rho / 4 times the integral of c^2 r^2 dr, and of c^4 ((x0 - 1/2)^2 + 1/32) dr."""
    plan, sweep, flip = MELANOGASTER.planform, 1e6, 2e6
    hinge_at_centre = replace(MELANOGASTER, right_hinge=(0.0, 0.0, 0.0))
    fly = FlappingFly(morphology=hinge_at_centre)
    swept = loads_along(fly, at_rest((0.0, 0.0, np.pi / 2), (0.0, 0.0, 0.0), (sweep, 0.0, 0.0))).right
    expected = np.pi / 4 * 1.19 * plan.moment(2, 2) * sweep
    assert swept.terms["added_mass"].torque[0, 2] == pytest.approx(expected, rel=1e-12)  # phi is a turn about -z
    flipped = loads_along(fly, at_rest((0.0, 0.0, np.pi / 2), (0.0, 0.0, 0.0), (0.0, 0.0, flip))).right
    x = MELANOGASTER.pitch_axis - 0.5
    expected = np.pi / 4 * 1.19 * (x**2 + 1 / 32) * plan.moment(4) * flip
    assert flipped.terms["added_mass"].torque[0, 1] == pytest.approx(-expected, rel=1e-12)


def test_dissipation_opposes_the_flip():
    spin = 3000.0
    load = loads_along(FLY, at_rest((0.0, 0.0, np.pi / 2), (0.0, 0.0, spin))).right.terms["dissipative"]
    expected = np.pi / 16 * 1.19 * MELANOGASTER.planform.moment(4) * 0.2 * (FREQUENCY + spin) * spin
    np.testing.assert_allclose(load.torque[0], [0.0, -expected, 0.0], rtol=1e-12, atol=1e-12 * expected)
    np.testing.assert_array_equal(load.force, 0.0)


def test_terms_that_a_model_leaves_out_are_zero_and_the_others_stay():
    flight = held_flight(ASYMMETRIC)
    every = loads_along(FLY, flight)
    for kept in TERMS:
        alone = loads_along(replace(FLY, air=QuasiSteadyModel(terms=(kept,))), flight)
        for term in TERMS:
            expected = every.left.terms[term].force if term == kept else 0.0
            np.testing.assert_array_equal(alone.left.terms[term].force, expected)


def test_six_blades_are_as_good_as_forty():
    """All terms; the kinks at reversal, where blades meet the air tail first, are what is left."""
    flight = held_flight(ASYMMETRIC, velocity=(0.4, 0.2, -0.3), spin=(20.0, -30.0, 40.0))
    six = loads_along(FLY, flight).total
    forty = loads_along(replace(FLY, air=QuasiSteadyModel(nodes=40)), flight).total
    for name in ("force", "torque"):
        one, other = getattr(six, name), getattr(forty, name)
        assert np.max(np.abs(one - other)) < 1e-3 * np.max(np.abs(other))
        assert np.max(np.abs((one - other)[:-1].mean(axis=0))) < 5e-5 * np.max(np.abs(other))

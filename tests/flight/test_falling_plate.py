"""The falling plate: conservation, closed forms, symmetry, scaling, and the published transition to tumbling."""

from dataclasses import replace
from math import cos, pi, sin, sqrt, tanh

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import simpson

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.flight.coefficients import wang2004
from flycontrol.flight.falling_plate import (
    IDEAL_FLUID,
    FallingPlate,
    PlateCoefficients,
    effective_inertias,
    plate_acceleration,
    plate_of,
    steady_fall_modes,
)
from flycontrol.flight.plate_fall import PlateMotion, plate_fall
from flycontrol.units import deg

START = PlateMotion(angle=0.5, velocity=(0.3, -0.8), rate=0.4)
CIRCULATION_ALONE = replace(IDEAL_FLUID, translation=1.2, rotation=pi)
CARD = FallingPlate(inertia_ratio=1.1)

speeds = st.floats(-3.0, 3.0)


@pytest.mark.parametrize("coefficients", [IDEAL_FLUID, CIRCULATION_ALONE])
@pytest.mark.parametrize("beta", [0.0, 0.3])
def test_without_dissipation_energy_is_conserved_whatever_the_circulation(coefficients, beta):
    plate = FallingPlate(inertia_ratio=1.5, thickness_ratio=beta, coefficients=coefficients)
    fallen = plate_fall(plate, START, 20.0, tolerance=1e-12)
    largest = np.max(np.abs(fallen.position[:, 1]))
    assert largest > 1.0
    np.testing.assert_allclose(fallen.energy, fallen.energy[0], atol=1e-10 * largest)


def test_what_energy_is_lost_is_the_work_of_drag_and_of_the_dissipative_torque():
    plate = FallingPlate(inertia_ratio=1.3, thickness_ratio=0.1)
    fallen = plate_fall(plate, START, 10.0, samples=20_001, tolerance=1e-12)
    c, (u, v), w = plate.coefficients, fallen.velocity.T, fallen.rate
    drag = (c.drag * (u**2 + v**2) - c.drag_swing * (u**2 - v**2)) * np.hypot(u, v) / pi
    lost = simpson(drag + (c.dissipation[0] + c.dissipation[1] * np.abs(w)) * w**2, x=fallen.time)
    assert fallen.energy[0] - fallen.energy[-1] == pytest.approx(lost, rel=1e-8)


def test_in_an_ideal_fluid_the_impulse_falls_with_the_weight_and_keeps_its_horizontal_part():
    plate = FallingPlate(inertia_ratio=1.5, thickness_ratio=0.2, coefficients=IDEAL_FLUID)
    fallen = plate_fall(plate, START, 10.0, tolerance=1e-12)
    along, across, _ = effective_inertias(plate)
    p, q = along * fallen.velocity[:, 0], across * fallen.velocity[:, 1]
    c, s = np.cos(fallen.angle), np.sin(fallen.angle)
    np.testing.assert_allclose(p * c - q * s, p[0] * c[0] - q[0] * s[0], atol=1e-9)
    np.testing.assert_allclose(p * s + q * c, p[0] * s[0] + q[0] * c[0] - fallen.time, atol=1e-9)


@pytest.mark.parametrize("beta", [0.0, 0.25])
def test_dropped_broadside_it_reaches_its_terminal_speed_as_a_hyperbolic_tangent(beta):
    """(I* + 1) v' = -1 + v^2 / W^2 from rest: v = -W tanh(t / (W (I* + 1))), W = sqrt(pi / (A + B))."""
    plate = FallingPlate(inertia_ratio=0.7, thickness_ratio=beta)
    fallen = plate_fall(plate, PlateMotion(angle=0.0), 30.0, samples=301, tolerance=1e-11)
    speed = sqrt(pi / 2.4)
    expected = [-speed * tanh(t / (speed * 1.7)) for t in fallen.time]
    np.testing.assert_allclose(fallen.velocity[:, 1], expected, atol=1e-9)
    assert plate.broadside_speed == pytest.approx(speed, rel=1e-15)
    assert -fallen.velocity[-1, 1] == pytest.approx(speed, rel=1e-9)


def test_the_published_steady_falls_are_fixed_points():
    """Speeds 2.8025 edgewise and 1.1441 broadside (andersen2005transitions, Eq. 6.1 and 6.2)."""
    assert CARD.edgewise_speed == pytest.approx(2.8025, abs=5e-5)
    assert CARD.broadside_speed == pytest.approx(1.1441, abs=5e-5)
    for state in ((-CARD.edgewise_speed, 0.0, 0.0, pi / 2), (0.0, -CARD.broadside_speed, 0.0, 0.0)):
        np.testing.assert_allclose(plate_acceleration(CARD, *state), 0.0, atol=1e-15)


@given(u=speeds, v=speeds, w=speeds, theta=st.floats(-4.0, 4.0), beta=st.floats(0.0, 0.9))
def test_the_mirror_image_of_a_motion_is_a_motion_and_so_is_its_half_turn(u, v, w, theta, beta):
    plate = FallingPlate(inertia_ratio=1.2, thickness_ratio=beta)
    here = np.array(plate_acceleration(plate, u, v, w, theta))
    np.testing.assert_array_equal(plate_acceleration(plate, -u, v, -w, -theta), here * [-1, 1, -1])
    np.testing.assert_allclose(plate_acceleration(plate, -u, -v, w, theta + pi), here * [-1, -1, 1], atol=1e-14)


@given(u=speeds, v=speeds)
def test_without_rotation_lift_and_drag_are_those_of_wang2004_on_a_chord_of_2a(u, v):
    """Force / (rho_f a U^2) = |(u, v)| (C_L (-v, u) sign(-u v) - C_D (u, v)): chord 2a times one half is a."""
    speed = float(np.hypot(u, v))
    fluid = FallingPlate(inertia_ratio=1.2, thickness_ratio=0.1)
    ideal = replace(fluid, coefficients=IDEAL_FLUID)
    change = np.subtract(plate_acceleration(fluid, u, v, 0.0, 0.3), plate_acceleration(ideal, u, v, 0.0, 0.3))
    force = pi * np.array(effective_inertias(fluid))[:2] * change[:2]
    lift, drag = wang2004(np.arctan2(np.abs(v), np.abs(u)))
    expected = speed * (lift * np.sign(-u * v) * np.array([-v, u]) - drag * np.array([u, v]))
    np.testing.assert_allclose(force, expected, atol=1e-12)


def test_a_plate_in_si_units_obeys_newton_with_kirchhoffs_added_masses():
    """Aluminium in water; masses and forces a unit of span, written down in SI units."""
    a, b, rho, rho_f, g = 5e-3, 0.5e-3, 2700.0, 1000.0, 9.81
    plate = plate_of(2 * a, 2 * b, rho, rho_f)
    u, v, w, theta = 0.12, -0.2, 9.0, 0.4
    mass, inertia = pi * rho * a * b, pi * rho * a * b * (a**2 + b**2) / 4
    along, across = mass + pi * rho_f * b**2, mass + pi * rho_f * a**2
    about = inertia + pi * rho_f * (a**2 - b**2) ** 2 / 8
    weight, speed = pi * (rho - rho_f) * a * b * g, np.hypot(u, v)
    circulation = 2 * pi * a**2 * w - 2 * 1.2 * a * u * v / speed
    drag = rho_f * a * (1.4 - (u**2 - v**2) / speed**2) * speed
    torque = pi * rho_f * a**4 * (0.2 * plate.speed / a + 0.2 * abs(w)) * w
    expected = (
        (across * w * v - rho_f * circulation * v - weight * sin(theta) - drag * u) / along,
        (-along * w * u + rho_f * circulation * u - weight * cos(theta) - drag * v) / across,
        ((along - across) * u * v - torque) / about,
    )
    found = plate_acceleration(plate, u / plate.speed, v / plate.speed, w * plate.time, theta)
    scale = plate.speed / plate.time
    np.testing.assert_allclose(np.multiply(found, [scale, scale, 1 / plate.time**2]), expected, rtol=1e-12)


def test_a_plate_four_times_as_large_falls_the_same_way_at_half_the_pace():
    """Speeds go with the root of the size, times too."""
    small, large = plate_of(0.01, 0.001, 2700.0, 1000.0), plate_of(0.04, 0.004, 2700.0, 1000.0)
    one = plate_fall(small, PlateMotion(angle=0.4, velocity=(0.01, -0.02)), 0.5)
    other = plate_fall(large, PlateMotion(angle=0.4, velocity=(0.02, -0.04)), 1.0)
    np.testing.assert_allclose(other.time, 2 * one.time, rtol=1e-12)
    np.testing.assert_allclose(other.position, 4 * one.position, atol=1e-9)
    np.testing.assert_allclose(other.angle, one.angle, atol=1e-9)


def test_a_fluttering_card_turns_back_twice_a_swing_and_keeps_no_net_rotation():
    late = plate_fall(CARD, START, 300.0, samples=30_001).after(150.0)
    assert late.swing < pi
    assert abs(late.turns) * 2 * pi < late.swing
    halves = np.diff(late.level_times)
    np.testing.assert_allclose(halves, halves.mean(), rtol=1e-5)
    period = late.level_times[2] - late.level_times[0]
    shifted = np.interp(late.time[:-1] + period, late.time, late.angle, right=np.nan)
    np.testing.assert_allclose(shifted[np.isfinite(shifted)], late.angle[:-1][np.isfinite(shifted)], atol=1e-3)


def test_a_tumbling_card_turns_one_way_and_drifts():
    late = plate_fall(FallingPlate(inertia_ratio=1.4), START, 300.0, samples=30_001).after(150.0)
    assert np.all(np.diff(late.angle) > 0) or np.all(np.diff(late.angle) < 0)
    halves = np.diff(late.level_times)
    assert abs(late.turns) == pytest.approx((late.time[-1] - late.time[0]) / (2 * halves.mean()), abs=0.5)
    drift = late.position[-1, 0] - late.position[0, 0]
    assert abs(drift) > -(late.position[-1, 1] - late.position[0, 1])


def test_the_published_period_doubling_lies_between_1_4_and_1_45():
    """Alike half turns at I* = 1.4, every second one longer at 1.45 (andersen2005transitions, Fig. 3)."""
    halves = [
        np.diff(plate_fall(FallingPlate(inertia_ratio=i), START, 300.0, samples=30_001).after(200.0).level_times)
        for i in (1.4, 1.45)
    ]
    assert np.ptp(halves[0]) < 1e-3 * halves[0].mean()
    assert abs(halves[1][0] - halves[1][1]) > 0.1 * halves[1].mean()
    np.testing.assert_allclose(halves[1][2:], halves[1][:-2], rtol=1e-3)


def test_the_published_critical_inertia_parts_flutter_from_tumbling():
    """1.2190 flutters, 1.2192 tumbles (andersen2005transitions, section 6.2)."""
    below, above = (
        plate_fall(FallingPlate(inertia_ratio=i), START, 300.0, tolerance=1e-11).after(100.0) for i in (1.2190, 1.2192)
    )
    assert below.swing < 1.2 * pi
    assert abs(above.turns) > 2


def test_the_edgewise_fall_at_the_critical_inertia_has_the_published_modes():
    """0.3813, -0.5854 and -0.9861 +- 2.5949 i, to every printed digit at 1.2191466, which is printed as 1.2191."""
    modes = steady_fall_modes(FallingPlate(inertia_ratio=1.2191466), "edgewise")
    np.testing.assert_allclose(modes[:2], [0.3813, -0.5854], rtol=0, atol=5e-5)
    np.testing.assert_allclose(modes[2:].real, -0.9861, rtol=0, atol=5e-5)
    np.testing.assert_allclose(np.abs(modes[2:].imag), 2.5949, rtol=0, atol=5e-5)


@pytest.mark.parametrize("inertia", [1.5, 3.0, 10.0])
def test_broadside_fall_becomes_stable_at_the_closed_form_of_the_hopf_bifurcation(inertia):
    """mu_1 = (2 I* + 1) / (8 W (I* - 1)) for a thin card with 2 C_T = A + B and C_R = pi, Eq. 6.3."""
    critical = (2 * inertia + 1) / (8 * CARD.broadside_speed * (inertia - 1))
    assert critical == pytest.approx(0.25 * sqrt(3 / (5 * pi)) * (2 * inertia + 1) / (inertia - 1), rel=1e-14)

    def growth(friction: float) -> float:
        coefficients = PlateCoefficients(dissipation=(friction, 0.2))
        return steady_fall_modes(FallingPlate(inertia_ratio=inertia, coefficients=coefficients), "broadside")[0].real

    assert abs(growth(critical)) < 1e-9
    assert growth(0.99 * critical) > 1e-4 > -1e-4 > growth(1.01 * critical)


@pytest.mark.slow
def test_a_chaotic_card_has_the_published_lyapunov_exponent():
    """0.13 +- 0.01 at I* = 2.2: growth of a small departure, drawn back every 4 a/U, over 2400 a/U, to 0.009."""
    card, size = FallingPlate(inertia_ratio=2.2), 1e-6

    def later(state: np.ndarray) -> np.ndarray:
        u, v, w, theta = state.tolist()
        fallen = plate_fall(card, PlateMotion(angle=theta, rate=w, velocity=(u, v)), 4.0, samples=2, tolerance=1e-10)
        return np.array([*fallen.velocity[-1], fallen.rate[-1], fallen.angle[-1]])

    here = np.array([0.0, -0.01, 0.0, 0.5])
    for _ in range(25):
        here = later(here)
    departure, growth = np.array([size, 0.0, 0.0, 0.0]), []
    for _ in range(600):
        there, here = later(here + departure), later(here)
        growth.append(np.log(np.linalg.norm(there - here) / size))
        departure = size * (there - here) / np.linalg.norm(there - here)
    assert np.mean(growth) / 4.0 == pytest.approx(0.13, abs=0.02)


def test_edgewise_fall_is_never_stable_and_modes_scale_with_time():
    for inertia in (0.3, 1.0, 3.0, 10.0):
        assert steady_fall_modes(FallingPlate(inertia_ratio=inertia), "edgewise")[0].real > 0
    slow = replace(CARD, half_width=3.0, speed=2.0)
    np.testing.assert_allclose(steady_fall_modes(slow, "edgewise") * 1.5, steady_fall_modes(CARD, "edgewise"))


def test_impossible_plates_and_falls_are_refused_in_a_sentence():
    with pytest.raises(InvalidParameterError, match=r"inertia_ratio must be > 0, got 0\.0"):
        FallingPlate(inertia_ratio=0.0)
    with pytest.raises(InvalidParameterError, match="thickness over width, from 0 to 1"):
        FallingPlate(inertia_ratio=1.0, thickness_ratio=1.2)
    with pytest.raises(InvalidParameterError, match="denser than its fluid"):
        plate_of(0.01, 0.001, 900.0, 1000.0)
    with pytest.raises(InvalidParameterError, match="wider than it is thick"):
        plate_of(0.001, 0.01, 2700.0, 1000.0)
    with pytest.raises(InvalidParameterError, match="drag would push"):
        PlateCoefficients(drag=0.5)
    with pytest.raises(InvalidParameterError, match="dissipation must be >= 0"):
        PlateCoefficients(dissipation=(-0.1, 0.2))
    with pytest.raises(InvalidInputError, match="duration > 0 s and 2 samples"):
        plate_fall(CARD, PlateMotion(angle=10 * deg), 0.0)

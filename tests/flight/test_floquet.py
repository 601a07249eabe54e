"""Periodic hover: what repeats, what grows, and two ways to the same multipliers."""

from dataclasses import replace

import numpy as np
import pytest
from hovering_fly import floquet, linearised, orbit, trim
from simulated_fly import ASYMMETRIC, FLY

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.body_coordinates import (
    LATERAL,
    LONGITUDINAL,
    attitude,
    attitude_angles,
    coordinates_of,
    state_at,
)
from flycontrol.flight.floquet import floquet_modes
from flycontrol.flight.linearised_flight import linearised_flight
from flycontrol.flight.multibody.freedoms import YAW_ONLY
from flycontrol.flight.periodic_orbit import FINE, periodic_orbit
from flycontrol.flight.quasi_steady import VACUUM
from flycontrol.flight.simulate import simulate_flight
from flycontrol.flight.state_vector import packed, unpacked
from flycontrol.flight.wingbeat_map import WingbeatMap
from flycontrol.model.stroke_kinematics import StrokeKinematics, hover_stroke
from flycontrol.model.wing_stroke import ModulatedStroke, Modulation, paddling
from flycontrol.units import deg

CROSSED = [np.ix_(LONGITUDINAL, LATERAL), np.ix_(LATERAL, LONGITUDINAL)]


def test_the_orbit_of_a_trimmed_stroke_closes_and_stays_in_place():
    """Found with four times the trim's steps: what is left of drift is the step's error over a wingbeat."""
    found = orbit()
    assert found.closure < 1e-12
    assert np.linalg.norm(found.drift_W) < 1e-5
    assert found.turning == pytest.approx(0.0, abs=1e-12)


def test_a_wingbeat_does_not_care_where_a_fly_is_or_heads():
    """Position and heading have the multiplier 1, four times."""
    beat, y = WingbeatMap(FLY, ASYMMETRIC), state_at(ASYMMETRIC, np.array([0.1, 0.2, -0.1, 9.0, 5.0, -7.0, 0.2, -0.1]))
    here = beat(y).end
    elsewhere = y.copy()
    elsewhere[:3] = 0.01, -0.02, 0.03
    elsewhere[3:7] = attitude(np.array(0.2), np.array(-0.1), np.array(1.0))
    there = beat(elsewhere).end
    np.testing.assert_allclose(coordinates_of(there), coordinates_of(here), rtol=0, atol=1e-10)
    turned = [float(attitude_angles(end[3:7])[2]) for end in (here, there)]
    assert turned[1] - turned[0] == pytest.approx(1.0, abs=1e-12)
    cos, sin = np.cos(1.0), np.sin(1.0)  # to the right, seen from above
    travel = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ here[:3]
    np.testing.assert_allclose(there[:3] - elsewhere[:3], travel, atol=1e-15)


@pytest.mark.parametrize("number", range(6))
def test_a_small_disturbance_grows_over_ten_wingbeats_as_its_multiplier_says(number):
    """Flown by the simulator on either side of the orbit, so that what is quadratic drops out."""
    found, start = floquet(), orbit().coordinates
    mode, size = found.modes[number], 1e-2
    ends = []
    for side in (1, -1):
        x = start + side * size * np.real(mode.shape) * orbit().scales
        state = unpacked(state_at(trim().kinematics, x))
        flight = simulate_flight(FLY, trim().kinematics, 10, start=state, settings=replace(FINE, samples=1))
        ends.append(np.array([coordinates_of(packed(flight.state(k))) for k in range(11)]))
    apart = (ends[0] - ends[1]) / (2 * size * orbit().scales)
    said = np.real(mode.shape * np.exp(mode.exponent * found.period * np.arange(11))[:, None])
    np.testing.assert_allclose(apart, said, rtol=0, atol=2e-3 * np.abs(said).max())


def test_the_linearised_flight_has_the_multipliers_of_the_wingbeat_map():
    """Accelerations differentiated phase by phase, against whole wingbeats: within twice the errors that are stated."""
    exponents = np.log(np.linalg.eigvals(linearised().transition).astype(complex)) / linearised().period
    for mode, error in zip(floquet().modes, floquet().errors, strict=True):
        assert np.min(np.abs(exponents - mode.exponent)) < 2 * error
        assert error < 1e-3 * abs(mode.exponent)


def test_the_product_of_the_multipliers_is_the_exponential_of_the_mean_trace():
    """Liouville's formula."""
    shrinks = linearised().period * np.trace(linearised().first_order)
    assert np.log(np.linalg.det(floquet().monodromy)) == pytest.approx(shrinks, rel=1e-4)


def test_what_a_mirror_keeps_and_what_it_turns_do_not_mix():
    scales = orbit().scales
    monodromy = floquet().monodromy * scales / scales[:, None]
    for block in CROSSED:
        assert np.max(np.abs(monodromy[block])) < 1e-13
        crossed = linearised().matrices[(slice(None), *block)] * scales[block[1]] / scales[block[0]]
        assert np.max(np.abs(crossed)) < 1e-8  # of 229 1/s: rounding of accelerations over small differences


def test_without_control_hover_is_lost_in_pitch_and_in_roll():
    """The review speaks of instabilities that flies must suppress."""
    names = [mode.name for mode in floquet().modes]
    assert sorted(names) == [
        "pitch and fore-aft growing oscillation",
        "pitch and fore-aft subsidence",
        "roll and sideways decaying oscillation",
        "roll and sideways divergence",
        "vertical subsidence",
        "yaw subsidence",
    ]
    assert not floquet().stable
    assert len(floquet().multipliers) == 8


def test_with_one_freedom_averaging_to_first_order_is_exact():
    """Exponents of r' = a(t) r are <a>."""
    tethered = replace(FLY, body=YAW_ONLY)
    found = periodic_orbit(tethered, trim().kinematics)
    yaw = min(floquet_modes(found).modes, key=lambda mode: mode.exponent.real)
    assert yaw.name == "yaw subsidence"
    assert yaw.exponent.real == pytest.approx(linearised_flight(found).first_order[5, 5], rel=1e-4)


def test_the_second_order_of_averaging_finds_what_the_first_leaves_out():
    """Twenty times nearer in the lateral modes, whose loads alternate most between half strokes."""
    for name in ("roll and sideways divergence", "roll and sideways decaying oscillation"):
        exact, first, second = (
            next(mode.exponent for mode in modes if mode.name == name)
            for modes in (floquet().modes, linearised().modes(1), linearised().modes(2))
        )
        assert abs(second - exact) < 0.05 * abs(first - exact)
        assert abs(second - exact) < 0.01 * abs(exact)


def test_a_stroke_that_is_not_trimmed_has_a_periodic_flight_that_drifts():
    found = periodic_orbit(FLY, hover_stroke())
    assert np.linalg.norm(found.drift_W) > 0.1
    flight = simulate_flight(FLY, hover_stroke(), 3, start=found.start, settings=replace(FINE, samples=1))
    np.testing.assert_allclose(flight.position_W[3], 3 / 220.0 * found.drift_W, rtol=1e-8, atol=1e-12)


def test_a_lopsided_stroke_has_a_periodic_flight_that_turns():
    stroke = trim().kinematics.modulated(*paddling(1 * deg))
    found = periodic_orbit(FLY, stroke, trim().start)
    assert found.turning > 1.0  # positive paddling turns right
    flight = simulate_flight(FLY, stroke, 2, start=found.start, settings=replace(FINE, samples=1))
    np.testing.assert_allclose(flight.yaw, found.turning * flight.time, atol=1e-9)


def test_what_has_no_periodic_flight_is_refused():
    with pytest.raises(InvalidParameterError, match=r"No periodic flight|runs away"):
        periodic_orbit(replace(FLY, air=VACUUM), trim().kinematics)
    changing = ModulatedStroke(stroke=hover_stroke().right, after=Modulation(stroke_gain=0.1))
    with pytest.raises(InvalidParameterError, match="one that repeats"):
        periodic_orbit(FLY, StrokeKinematics.symmetric(changing, 220.0))

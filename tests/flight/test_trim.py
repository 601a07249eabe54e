"""A trimmed fly stays where it is, carries its weight and refuses what it cannot."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_fly import ASYMMETRIC, FLY, MELANOGASTER

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.multibody.freedoms import HELD, DampedSpring, Hinge
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.flight.trim import hover_trim, tethered_trim
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.morphology import drosophila_hydei
from flycontrol.model.stroke_kinematics import StrokeKinematics, hover_stroke
from flycontrol.model.trajectory import rotation_matrices
from flycontrol.model.wing_stroke import fourier_stroke
from flycontrol.units import deg

FLIES = {"melanogaster": (FLY, 220.0), "hydei": (replace(FLY, morphology=drosophila_hydei()), 189.0)}
AMPLITUDE = ("stroke_amplitude", "stroke_offset", "pitch_offset")
PHASE = np.arange(400) / 400
AS_SERIES = StrokeKinematics.symmetric(fourier_stroke(PHASE, hover_stroke().right(PHASE).angles, 40), 220.0)
TETHERED = replace(FLY, body=HELD)
FINE = MarchSettings(steps=1000, samples=500)


@pytest.mark.parametrize("species", FLIES)
def test_a_trimmed_fly_is_after_a_wingbeat_where_and_as_it_was(species):
    fly, frequency = FLIES[species]
    trim = hover_trim(fly, hover_stroke(frequency))
    flight = simulate_flight(fly, trim.kinematics, 3, start=trim.start)
    for beat in (1, 2, 3):
        now = flight.state(beat * flight.samples_per_wingbeat)
        np.testing.assert_allclose(now.position_W, 0.0, atol=1e-12)
        np.testing.assert_allclose(now.velocity_S, trim.start.velocity_S, atol=1e-10)
        np.testing.assert_allclose(now.angular_velocity_S, trim.start.angular_velocity_S, atol=1e-7)
        np.testing.assert_allclose(now.q_WS, trim.start.q_WS, atol=1e-10)


def test_on_the_trimmed_orbit_the_air_carries_the_weight_of_fly_and_wings():
    """What was averaged is a state; here it is the force itself, by the terms of the air."""
    trim = hover_trim(FLY, hover_stroke(), settings=FINE)
    flight = simulate_flight(FLY, trim.kinematics, 1, start=trim.start, settings=FINE)
    air = loads_along(FLY, flight).left.total.force + loads_along(FLY, flight).right.total.force
    world = np.einsum("nij,nj->ni", rotation_matrices(flight.q_WS), air)[:-1].mean(axis=0) / MELANOGASTER.weight
    np.testing.assert_allclose(world, [0.0, 0.0, 1.0], atol=1e-5)  # kinked loads, 500 samples


def test_held_at_rest_the_trimmed_wings_bear_the_weight():
    trim = tethered_trim(FLY, hover_stroke(), settings=FINE)
    loads = loads_along(FLY, simulate_flight(TETHERED, trim.kinematics, 1, start=trim.start, settings=FINE))
    down = (loads.left.total.force + loads.right.total.force)[:-1, 2].mean()
    assert down == pytest.approx(-MELANOGASTER.weight, rel=1e-5)
    assert trim.balance.largest_load < 1e-12


def test_twice_the_mass_on_the_same_wings_takes_root_two_the_frequency():
    """All mean loads of the held body grow with the square of the frequency; a wing weighs its share of the fly."""
    light = tethered_trim(FLY, hover_stroke()).values
    fat = replace(FLY, morphology=replace(MELANOGASTER, mass=2 * MELANOGASTER.mass))
    heavy = tethered_trim(fat, hover_stroke(300.0)).values
    assert heavy["frequency"] == pytest.approx(np.sqrt(2) * light["frequency"], rel=1e-9)
    assert heavy["stroke_offset"] == pytest.approx(light["stroke_offset"], rel=1e-9)
    assert heavy["pitch_offset"] == pytest.approx(light["pitch_offset"], rel=1e-9)


def test_the_published_fly_hovers_at_a_published_frequency_or_about_a_published_amplitude():
    """218 to 250 Hz at 140 deg from peak to peak; at 220 Hz the calibrated shape takes 1 deg more than the 145 deg."""
    assert 218.0 < hover_trim(FLY, hover_stroke()).values["frequency"] < 250.0
    trim = hover_trim(FLY, hover_stroke(), AMPLITUDE)
    assert 140 * deg < 2 * trim.values["stroke_amplitude"] < 146 * deg
    assert trim.kinematics.frequency == 220.0


def test_a_trim_may_pitch_the_body_and_keeps_the_pitch_that_is_asked_for():
    nose_up = hover_trim(FLY, hover_stroke(), body_pitch=10 * deg)
    flight = simulate_flight(FLY, nose_up.kinematics, 1, start=nose_up.start)
    ahead = rotation_matrices(flight.q_WS)[:-1, 2, 0]
    assert np.arcsin(ahead).mean() == pytest.approx(10 * deg, abs=1e-9)
    freed = hover_trim(FLY, hover_stroke(), ("stroke_amplitude", "stroke_offset", "body_pitch"))
    assert freed.values["body_pitch"] == freed.body_pitch
    assert freed.balance.largest_load < 1e-10
    assert freed.kinematics.right.pitch_offset == 0.0


def test_a_series_of_the_stroke_is_trimmed_like_the_stroke_itself():
    """By modulating it: a relative change of amplitude in place of the amplitude, other angles as changes."""
    itself = hover_trim(FLY, hover_stroke(), AMPLITUDE).values
    series = hover_trim(FLY, AS_SERIES, ("stroke_gain", "stroke_offset", "pitch_offset")).values
    assert 70 * deg * (1 + series["stroke_gain"]) == pytest.approx(itself["stroke_amplitude"], rel=1e-6)
    assert series["stroke_offset"] == pytest.approx(itself["stroke_offset"], rel=1e-5)
    assert series["pitch_offset"] == pytest.approx(itself["pitch_offset"], rel=1e-4)


def test_wings_too_weak_at_any_amplitude_are_refused_with_the_weight_that_they_leave():
    with pytest.raises(InvalidParameterError, match=r"no hover .* stroke_amplitude at the limit, .* -0\.\d+ upward"):
        hover_trim(FLY, hover_stroke(100.0), AMPLITUDE)


def test_what_cannot_be_trimmed_is_refused():
    stroke = hover_stroke()
    with pytest.raises(InvalidParameterError, match="three different ones"):
        hover_trim(FLY, stroke, ("frequency", "frequency", "pitch_offset"))
    with pytest.raises(InvalidParameterError, match="No trim moves"):
        hover_trim(FLY, stroke, limits={"wing_length": (0.0, 1.0)})
    with pytest.raises(InvalidParameterError, match="not within its limits"):
        hover_trim(FLY, stroke, limits={"frequency": (230.0, 250.0)})
    with pytest.raises(InvalidParameterError, match="same stroke for both wings"):
        hover_trim(FLY, ASYMMETRIC)
    with pytest.raises(InvalidParameterError, match="has no pitch_amplitude to move"):
        hover_trim(FLY, AS_SERIES, ("pitch_amplitude", "stroke_offset", "pitch_offset"))
    with pytest.raises(InvalidParameterError, match="against gravity"):
        hover_trim(replace(FLY, gravity_W=(0.0, 0.0, 0.0)), stroke)
    with pytest.raises(InvalidParameterError, match="prescribed wings"):
        hover_trim(replace(FLY, left=Hinge(pitch=DampedSpring(stiffness=2e-9))), stroke)

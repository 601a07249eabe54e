"""Flights in lanes are the flights one by one."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from simulated_fly import ASYMMETRIC, FLY, FREQUENCY, MELANOGASTER, SYMMETRIC, wing_stroke

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.ensemble import FlightPlan, ensemble_chunks, simulate_flights
from flycontrol.flight.kernels.lanes import LANES
from flycontrol.flight.multibody.freedoms import YAW_ONLY, DampedSpring, Hinge
from flycontrol.flight.pulses import BodyPulse
from flycontrol.flight.quasi_steady import QuasiSteadyModel
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.flight.state_vector import level_start, samples_of
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import ModulatedStroke, Modulation
from flycontrol.units import deg


def plans(count: int) -> list[FlightPlan]:
    """Flies of different mass and wings, strokes of different frequency and amplitude, starts and pulses."""
    rng = np.random.default_rng(3)
    made = []
    for k in range(count):
        fly = replace(
            FLY, morphology=replace(MELANOGASTER, mass=1.1e-6 * rng.uniform(0.8, 1.2), pitch_axis=0.2 + k / 99)
        )
        right = ModulatedStroke(
            stroke=wing_stroke(amplitude=rng.uniform(60, 75) * deg), after=Modulation(pitch_offset=k * 0.2 * deg)
        )
        stroke = StrokeKinematics(frequency=FREQUENCY + k, left=wing_stroke(k * 0.1 * deg), right=right)
        start = level_start(stroke, tuple(rng.normal(size=3) * 0.1))
        pulse = BodyPulse(start=1e-3, duration=2e-3, torque_S=tuple(rng.normal(size=3) * 1e-10))
        made.append(FlightPlan(fly=fly, stroke=stroke, start=start, pulses=(pulse,)))
    return made


def test_every_lane_flies_as_it_would_alone():
    together = simulate_flights(plans(LANES + 2), 3)
    for plan, flight in zip(plans(LANES + 2), together, strict=True):
        alone = simulate_flight(plan.fly, plan.stroke, 3, start=plan.start, pulses=plan.pulses)
        ours, theirs = samples_of(flight), samples_of(alone)
        assert ours.shape == theirs.shape
        assert np.max(np.abs(ours - theirs) / np.max(np.abs(theirs), axis=0)) < 1e-9
        assert asdict(flight.step_error) == pytest.approx(asdict(alone.step_error), rel=1e-6)
        assert (flight.wingbeats, flight.status) == (3, "complete")


def test_held_freedoms_are_held_in_lanes():
    fly = replace(FLY, body=YAW_ONLY)
    (flight,) = simulate_flights([FlightPlan(fly=fly, stroke=ASYMMETRIC)], 2)
    alone = simulate_flight(fly, ASYMMETRIC, 2)
    np.testing.assert_array_equal(flight.angular_velocity_S[:, :2], 0.0)
    np.testing.assert_allclose(flight.yaw, alone.yaw, rtol=1e-9, atol=1e-12)


def test_pieces_do_not_change_a_flight():
    plan = plans(2)
    whole = simulate_flights(plan, 5)
    last = list(ensemble_chunks(plan, 5, settings=MarchSettings(chunk=2)))[-1]
    for piece, flight in zip(last, whole, strict=True):
        np.testing.assert_array_equal(piece.q_WS[-1], flight.q_WS[-1])


def test_one_flight_that_diverges_leaves_the_others_alone():
    kick = BodyPulse(start=1.5 / FREQUENCY, duration=1.0, force_S=(1.0, 0.0, 0.0))
    bad, good = FlightPlan(fly=FLY, stroke=SYMMETRIC, pulses=(kick,)), FlightPlan(fly=FLY, stroke=SYMMETRIC)
    stopped, flown = simulate_flights([bad, good], 4, settings=MarchSettings(chunk=1))
    assert "wingbeat 1" in stopped.status
    assert stopped.wingbeats == 1
    assert np.all(np.isfinite(stopped.velocity_S))
    np.testing.assert_allclose(flown.q_WS, simulate_flight(FLY, SYMMETRIC, 4).q_WS, atol=1e-9)


def test_what_lanes_cannot_share_is_refused():
    plan = FlightPlan(fly=FLY, stroke=SYMMETRIC)
    sprung = Hinge(pitch=DampedSpring(stiffness=2e-9))
    with pytest.raises(InvalidParameterError, match="prescribed wings only"):
        simulate_flights([replace(plan, fly=replace(FLY, left=sprung))], 1)
    with pytest.raises(InvalidParameterError, match="must share"):
        simulate_flights([plan, replace(plan, fly=replace(FLY, air=QuasiSteadyModel(nodes=8)))], 1)
    with pytest.raises(InvalidParameterError, match="needs a plan, got none"):
        simulate_flights([], 1)

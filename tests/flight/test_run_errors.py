"""What every run says of its own errors, and what it refuses."""

import re
from dataclasses import replace

import numpy as np
import pytest
from simulated_fly import ASYMMETRIC, FLY, MELANOGASTER, SYMMETRIC

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.ensemble import FlightPlan, simulate_flights
from flycontrol.flight.multibody.freedoms import DampedSpring, Hinge
from flycontrol.flight.pulses import BodyPulse
from flycontrol.flight.quasi_steady import QuasiSteadyModel
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import flight_chunks, simulate_flight
from flycontrol.flight.wing_loads import loads_along


def with_blades(count):
    return replace(FLY, air=QuasiSteadyModel(nodes=count))


@pytest.mark.parametrize("count", [1, 2, 3])
def test_a_run_reports_the_load_that_its_blades_miss(count):
    """Against 200 blades, where the estimate takes 64, which are 3e-5 of the weight off while lift turns round."""
    flight = simulate_flight(with_blades(count), ASYMMETRIC, 1)
    few, many = (loads_along(with_blades(n), flight).total for n in (count, 200))
    apart = np.linalg.norm(few.force - many.force, axis=1)[:-1].max() / MELANOGASTER.weight
    assert flight.quadrature_error is not None
    assert flight.quadrature_error.force == pytest.approx(apart, rel=1e-3, abs=5e-5)


def test_six_blades_miss_a_thousandth_of_the_weight_at_worst_and_a_hundred_thousandth_in_the_mean():
    """The worst is one instant of a stroke reversal, in which the lift turns round somewhere along the wing."""
    error = simulate_flight(FLY, ASYMMETRIC, 1).quadrature_error
    assert error is not None
    assert max(error.force, error.torque) < 1e-3
    assert max(error.mean_force, error.mean_torque) < 1e-5


def test_a_fly_in_lanes_reports_the_errors_that_it_reports_alone():
    flown = [simulate_flights([FlightPlan(fly=FLY, stroke=ASYMMETRIC)], 1)[0], simulate_flight(FLY, ASYMMETRIC, 1)]
    for kind in ("step_error", "quadrature_error"):
        lane, alone = (getattr(flight, kind) for flight in flown)
        for name in type(alone).__slots__:
            # differences of states that agree to rounding, and rounding is what they are measured in
            assert getattr(lane, name) == pytest.approx(getattr(alone, name), rel=1e-3, abs=1e-13)


def test_errors_come_with_the_first_piece_and_not_at_all_when_not_asked_for():
    pieces = list(flight_chunks(FLY, SYMMETRIC, 2, settings=MarchSettings(chunk=1)))
    assert [piece.step_error is None for piece in pieces] == [False, True]
    assert [piece.quadrature_error is None for piece in pieces] == [False, True]
    unasked = simulate_flight(FLY, SYMMETRIC, 1, settings=MarchSettings(estimate_error=False))
    assert unasked.step_error is None
    assert unasked.quadrature_error is None


def test_a_flight_that_ends_in_its_first_wingbeat_has_no_error_of_its_blades():
    kick = BodyPulse(start=0.0, duration=1.0, force_S=(1.0, 0.0, 0.0))
    flight = simulate_flight(FLY, SYMMETRIC, 2, pulses=[kick], settings=MarchSettings(tolerance=1e9))
    assert not flight.complete
    assert flight.wingbeats == 0
    assert flight.quadrature_error is None


def test_the_steps_that_a_refusal_advises_do():
    hinge = Hinge(pitch=DampedSpring(stiffness=2e-8))
    fly = replace(FLY, left=hinge, right=hinge)
    with pytest.raises(InvalidParameterError, match=r"steps a wingbeat .* leave an error of .* rad") as refused:
        simulate_flight(fly, SYMMETRIC, 1, settings=MarchSettings(steps=50, tolerance=1e-5))
    advised = re.search(r"about (\d+) steps would do", str(refused.value))
    assert advised is not None
    steps = int(advised.group(1))
    flight = simulate_flight(fly, SYMMETRIC, 1, settings=MarchSettings(steps=steps, samples=2, tolerance=1e-5))
    assert flight.complete


def test_a_body_that_flies_apart_is_told_with_its_wingbeat_and_reason():
    kick = BodyPulse(start=3.5 / SYMMETRIC.frequency, duration=1.0, torque_S=(0.0, 0.0, 1e-4))
    flight = simulate_flight(FLY, SYMMETRIC, 6, pulses=[kick])
    assert re.match(r"stopped in wingbeat 3: the body moves at .* m/s and turns at .* rad/s", flight.status)
    assert "what was flown until then is kept" in flight.status
    assert flight.wingbeats == 3
    assert np.all(np.isfinite(flight.q_WS))

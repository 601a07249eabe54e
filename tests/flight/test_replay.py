"""Replayed flights: what the body needs against what air and wings supply."""

from dataclasses import replace

import numpy as np
import pytest
from recorded_flight import recorded
from scipy.spatial.transform import Rotation
from simulated_fly import ASYMMETRIC, FLY, MELANOGASTER, rms

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.load_balance import LoadBalance, load_balance, wingbeat_balance, world_balance
from flycontrol.flight.replay import ReplayBandwidth, inner_wingbeats, replayed
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.identify.agreement import agreement
from flycontrol.io.recordings import read_recording
from flycontrol.model.morphology import drosophila_hydei
from flycontrol.model.trajectory import Trajectory
from flycontrol.model.wingbeats import segment_wingbeats

ANGLE = MELANOGASTER.stroke_plane_angle
TORQUE = MELANOGASTER.weight * MELANOGASTER.wing_length  #: a large one [N m]
FLIGHTS = ("20121009_S0003", "20121120_S0001", "20121128_S0003")
HYDEI = FlappingFly(morphology=drosophila_hydei())


@pytest.fixture(scope="module")
def flight() -> Trajectory:
    """Fourteen wingbeats out of balance: the fly tumbles at up to 150 rad/s."""
    return simulate_flight(FLY, ASYMMETRIC, 14, settings=MarchSettings(samples=40))


def largest_errors(flight: Trajectory, bandwidth: ReplayBandwidth) -> tuple[float, float]:
    """Of wingbeat means of required and supplied torque [m g R] and force [m g]."""
    recording = recorded(flight, ANGLE)
    beats = segment_wingbeats(recording)
    inner = inner_wingbeats(beats)
    again = replayed(recording, beats, bandwidth)
    exact, ours = (wingbeat_balance(load_balance(FLY, t), t, inner) for t in (flight, again))
    pairs = [(ours.required, exact.required), (ours.supplied, exact.supplied)]
    torque = max(float(np.max(np.abs(a.torque - b.torque))) for a, b in pairs)
    force = max(float(np.max(np.abs(a.force - b.force))) for a, b in pairs)
    return torque / TORQUE, force / MELANOGASTER.weight


def test_in_a_simulated_flight_the_body_needs_what_air_and_wings_supply(flight):
    for balance in (load_balance(FLY, flight), world_balance(load_balance(FLY, flight), flight)):
        for name in ("force", "torque"):
            needed, supplied = getattr(balance.required, name), getattr(balance.supplied, name)
            np.testing.assert_allclose(supplied, needed, rtol=0, atol=1e-12 * rms(needed))


@pytest.mark.parametrize(
    ("bandwidth", "torque", "force"),
    [(ReplayBandwidth(body=8, wings=12), 3e-4, 3e-4), (ReplayBandwidth(body=3.5, wings=8.5), 2e-3, 2e-3),
     (ReplayBandwidth(), 0.025, 0.02)],
)  # fmt: skip
def test_a_replay_gives_back_the_loads_of_the_flight_that_was_recorded(flight, bandwidth, torque, force):
    """Within what the smoother takes away; by default that is the body's shaking within the wingbeat."""
    errors = largest_errors(flight, bandwidth)
    assert errors[0] < torque
    assert errors[1] < force


def turned(flight: Trajectory, angle: np.ndarray) -> Trajectory:
    """The flight's wings on a body at rest that turns right by `angle` (N,) about the vertical, stroke plane level."""
    level = Rotation.from_quat([1.0, 0.0, 0.0, 0.0])
    q = (Rotation.from_rotvec(-angle[:, None] * [0.0, 0.0, 1.0]) * level).as_quat()[:, [3, 0, 1, 2]]
    return replace(flight, q_WS=q, position_W=np.zeros((len(angle), 3)))


def replayed_turn(flight: Trajectory, angle: np.ndarray) -> tuple[Trajectory, LoadBalance]:
    recording = recorded(turned(flight, angle), ANGLE)
    again = replayed(recording)
    return again, wingbeat_balance(load_balance(FLY, again), again, inner_wingbeats(segment_wingbeats(recording)))


def test_a_steady_turn_to_the_right_has_its_rate_and_needs_no_yaw_torque(flight):
    """About the vertical of a pitched body w x I w is a pitching torque, - I_xz w^2."""
    rate = 30.0
    again, balance = replayed_turn(flight, rate * flight.time)
    middle = slice(len(flight.time) // 4, -len(flight.time) // 4)
    np.testing.assert_allclose(again.angular_velocity_S[middle] - [0, 0, rate], 0.0, rtol=0, atol=1e-3)
    product = MELANOGASTER.inertia_S[0, 2]
    scale = product * rate**2
    np.testing.assert_allclose(balance.required.torque, np.tile([0, scale, 0], (8, 1)), rtol=0, atol=0.01 * scale)


def test_a_turn_to_the_right_that_quickens_needs_yaw_and_roll_torque_by_the_inertia_tensor(flight):
    acceleration = 1000.0
    _, balance = replayed_turn(flight, 0.5 * acceleration * (flight.time - flight.time[-1] / 2) ** 2)
    inertia = MELANOGASTER.inertia_S
    needed = balance.required.torque[:, [0, 2]]
    expected = np.tile(inertia[[0, 2], 2] * acceleration, (8, 1))
    np.testing.assert_allclose(needed, expected, rtol=0.01)


def test_a_body_at_rest_needs_its_weight_carried(flight):
    _, balance = replayed_turn(flight, np.zeros_like(flight.time))
    body = MELANOGASTER.weight * (1 - 2 * MELANOGASTER.wing_body.mass / MELANOGASTER.mass)
    np.testing.assert_allclose(balance.required.force, np.tile([0, 0, -body], (8, 1)), rtol=0, atol=1e-9 * body)


def test_what_a_replay_cannot_do_is_said(flight):
    recording = recorded(flight, ANGLE)
    with pytest.raises(InvalidInputError, match="position"):
        replayed(replace(recording, position_W=None))
    with pytest.raises(InvalidParameterError, match="ReplayBandwidth"):
        ReplayBandwidth(wings=0.0)
    with pytest.raises(InvalidInputError, match="too few"):
        inner_wingbeats(segment_wingbeats(recording), 6)


@pytest.fixture(scope="module")
def real_flights(real_data):
    """Recording, trajectory and inner wingbeats of the three free flights."""
    folder = real_data / "muijres_freeflight"
    recordings = [read_recording(folder / f"{name}.txt", "muijres_freeflight") for name in FLIGHTS]
    beats = [segment_wingbeats(recording) for recording in recordings]
    return [(replayed(r, b), inner_wingbeats(b)) for r, b in zip(recordings, beats, strict=True)]


def real_balances(real_flights, fly=HYDEI) -> list[LoadBalance]:
    return [wingbeat_balance(load_balance(fly, t), t, beats) for t, beats in real_flights]


def yaw(balances) -> tuple[list[np.ndarray], list[np.ndarray]]:
    return [b.supplied.torque[:, 2] for b in balances], [b.required.torque[:, 2] for b in balances]


def test_the_wings_of_real_flights_carry_two_thirds_to_all_of_what_newton_asks(real_flights):
    """A quasi-steady model knows neither this fly's mass nor its wings to better than some 20 %."""
    for trajectory, beats in real_flights:
        world = wingbeat_balance(world_balance(load_balance(HYDEI, trajectory), trajectory), trajectory, beats)
        share = world.supplied.force[:, 2].mean() / world.required.force[:, 2].mean()
        assert 2 / 3 < share < 1.0


def test_the_force_along_the_stroke_planes_normal_follows_newton_in_real_flights(real_flights):
    balances = real_balances(real_flights)
    found = agreement([b.supplied.force[:, 2] for b in balances], [b.required.force[:, 2] for b in balances])
    assert found.correlation.low > 0.7


def test_real_turns_are_seen_in_the_wings_once_the_product_of_inertia_is_there(real_flights):
    """Yaw of the two turning flights; and the slope of what wings supply on what turning needs is one."""
    tilted = agreement(*yaw(real_balances(real_flights[:2])))
    (xx, _, _), (_, yy, _), (_, _, zz) = HYDEI.morphology.inertia
    diagonal = replace(HYDEI.morphology, inertia=((xx, 0.0, 0.0), (0.0, yy, 0.0), (0.0, 0.0, zz)))
    crude = agreement(*yaw(real_balances(real_flights[:2], FlappingFly(morphology=diagonal))))
    assert tilted.correlation.low > 0.4
    assert tilted.correlation.low > crude.correlation.value + 0.2
    assert tilted.slope.low < 1.0 < tilted.slope.high

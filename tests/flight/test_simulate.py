"""Whole flights: what is conserved, in what order the steps converge, and what comes back by inverse dynamics."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from rigid_fly import pinocchio_model
from scipy.interpolate import make_interp_spline
from simulated_fly import ASYMMETRIC, FLY, FREQUENCY, MELANOGASTER, SYMMETRIC, rms

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.multibody.constants import constants_of
from flycontrol.flight.multibody.freedoms import HELD, YAW_ONLY, DampedSpring, Hinge, TorqueDriven
from flycontrol.flight.multibody.inverse import inverse_dynamics
from flycontrol.flight.pulses import BodyPulse
from flycontrol.flight.quasi_steady import TERMS, VACUUM, QuasiSteadyModel
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import flight_chunks, simulate_flight
from flycontrol.flight.state_vector import level_start
from flycontrol.model.morphology import GRAVITY
from flycontrol.model.trajectory import Trajectory, rotation_matrices, wing_angles, wing_rates
from flycontrol.model.wing_stroke import ModulatedStroke, Modulation
from flycontrol.units import deg

LIMP = Hinge(**{angle: TorqueDriven(np.zeros_like) for angle in ("stroke", "deviation", "pitch")})
SPRUNG = Hinge(
    stroke=DampedSpring(stiffness=2e-9, rest_angle=0.0),
    deviation=DampedSpring(stiffness=2e-9, rest_angle=0.0),
    pitch=DampedSpring(stiffness=2e-9),
)
WEIGHTLESS = replace(FLY, air=VACUUM, gravity_W=(0.0, 0.0, 0.0))
SMOOTH = ("added_mass",)
EVERY_STEP = MarchSettings(samples=200)


def settings(steps: int) -> MarchSettings:
    return MarchSettings(steps=steps, samples=1, estimate_error=False)


def in_pinocchio(fly, flight: Trajectory):
    """Model, and (q, v) at every instant."""
    constants = constants_of(fly, FREQUENCY)
    angles = [wing_angles(flight.right), wing_angles(flight.left)]
    rates = [wing_rates(flight.right), wing_rates(flight.left)]
    q = np.hstack([flight.position_W, flight.q_WS[:, 1:], flight.q_WS[:, :1], *angles])
    v = np.hstack([flight.velocity_S, flight.angular_velocity_S, *rates])
    return pinocchio_model(constants.body, constants.wings), q, v


def momentum(fly, flight: Trajectory) -> np.ndarray:
    """(N, 6) linear momentum, and angular momentum about the whole fly's centre of mass, in W, by pinocchio."""
    model, q, v = in_pinocchio(fly, flight)
    data = model.createData()
    return np.array([pin.computeCentroidalMomentum(model, data, *at).vector.copy() for at in zip(q, v, strict=True)])


def energy(fly, flight: Trajectory) -> np.ndarray:
    """(N,) kinetic energy by pinocchio and that of the springs."""
    model, q, v = in_pinocchio(fly, flight)
    data = model.createData()
    kinetic = np.array([pin.computeKineticEnergy(model, data, *at) for at in zip(q, v, strict=True)])
    springs = sum(
        0.5 * joint.stiffness * (wing_angles(flight.wing(side))[:, k] - joint.rest_angle) ** 2
        for side, hinge in (("left", fly.left), ("right", fly.right))
        for k, joint in enumerate(hinge.joints)
        if isinstance(joint, DampedSpring)
    )
    return kinetic + springs


def spinning(stroke=ASYMMETRIC):
    return replace(level_start(stroke, (0.3, -0.2, 0.1)), angular_velocity_S=np.array([30.0, -20.0, 50.0]))


@pytest.mark.parametrize("hinge", [Hinge(), SPRUNG], ids=["prescribed wings", "sprung wings"])
def test_without_air_momentum_is_conserved_to_fourth_order(hinge):
    fly = replace(WEIGHTLESS, left=hinge, right=hinge)
    drift = []
    for steps in (100, 200):
        p = momentum(fly, simulate_flight(fly, ASYMMETRIC, 1, start=spinning(), settings=settings(steps)))
        scale = np.repeat([MELANOGASTER.mass * 0.37, 2.5e-11], 3)  # that of the body's own motion
        drift.append(np.max(np.abs(p[-1] - p[0]) / scale))
    assert drift[1] < 1e-6
    assert drift[0] / drift[1] == pytest.approx(2**4, rel=0.35)


def test_without_air_and_dampers_energy_is_conserved_to_fourth_order():
    fly = replace(WEIGHTLESS, left=SPRUNG, right=SPRUNG)
    drift = []
    for steps in (100, 200):
        e = energy(fly, simulate_flight(fly, ASYMMETRIC, 2, start=spinning(), settings=settings(steps)))
        drift.append(np.max(np.abs(e - e[0])) / e[0])
    assert drift[1] < 1e-6
    assert drift[0] / drift[1] > 2**4 * 0.7  # RK4 loses energy in fifth order where motion is periodic


def test_a_limp_fly_falls_like_a_stone():
    fly = replace(FLY, air=VACUUM, left=LIMP, right=LIMP)
    start = level_start(SYMMETRIC)
    still = replace(start, left_rates=np.zeros(3), right_rates=np.zeros(3))
    flight = simulate_flight(fly, SYMMETRIC, 4, start=still)
    np.testing.assert_allclose(flight.position_W[:, 2], -0.5 * GRAVITY * flight.time**2, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(wing_angles(flight.left), start.left_angles[None].repeat(len(flight.time), 0), atol=1e-9)


@pytest.mark.parametrize("terms", [TERMS, SMOOTH], ids=["all terms", "smooth terms"])
def test_in_air_the_estimated_step_error_is_of_the_size_of_the_error(terms):
    """Kinks at reversal spoil the order of the translational term, and with it the estimate."""
    fly = replace(FLY, air=QuasiSteadyModel(terms=terms))
    some, many = (
        simulate_flight(fly, ASYMMETRIC, 1, settings=MarchSettings(steps=steps, samples=1)) for steps in (200, 3200)
    )
    error = np.linalg.norm(some.velocity_S[-1] - many.velocity_S[-1])
    assert some.step_error is not None
    within = 1.2 if terms == SMOOTH else 20
    assert some.step_error.velocity / within < error < some.step_error.velocity * within
    assert error < 1e-6  # of changes about 0.1 m/s


def test_inverse_dynamics_gives_back_the_torques_that_made_a_motion():
    def torque(amplitude):
        return TorqueDriven(lambda phase: amplitude * np.cos(2 * np.pi * phase + 0.3))

    hinge = Hinge(stroke=torque(8e-9), deviation=torque(1e-9), pitch=DampedSpring(stiffness=2e-9, damping=2e-13))
    fly = replace(FLY, left=hinge, right=hinge)
    pulse = BodyPulse(start=0.0, duration=1.0, torque_S=(1e-10, -2e-10, 3e-10), force_S=(1e-6, 0.0, -2e-6))
    flight = simulate_flight(fly, ASYMMETRIC, 1, pulses=[pulse], settings=MarchSettings(steps=400, samples=50))
    found = inverse_dynamics(fly, flight)
    np.testing.assert_allclose(found.body_force, np.tile(pulse.force_S, (51, 1)), atol=1e-9 * MELANOGASTER.weight)
    np.testing.assert_allclose(found.body_torque, np.tile(pulse.torque_S, (51, 1)), atol=1e-9 * 3e-10)
    for side, torques in (("left", found.left_hinge), ("right", found.right_hinge)):
        motion = flight.wing(side)
        made = np.stack([
            8e-9 * np.cos(2 * np.pi * flight.phase + 0.3),
            1e-9 * np.cos(2 * np.pi * flight.phase + 0.3),
            -2e-9 * (motion.pitch - np.pi / 2) - 2e-13 * motion.pitch_rate,
        ], axis=1)  # fmt: skip
        np.testing.assert_allclose(torques, made, atol=1e-9 * rms(made))


def test_wings_driven_by_the_torques_of_a_prescribed_stroke_follow_it():
    """With smooth terms, so that splines through the torques at the steps hold between them."""
    smooth = replace(FLY, air=QuasiSteadyModel(terms=SMOOTH))
    prescribed = simulate_flight(smooth, ASYMMETRIC, 1, settings=EVERY_STEP)
    needed = inverse_dynamics(smooth, prescribed)

    def driven(torques):
        splines = [make_interp_spline(prescribed.phase, column, k=5) for column in torques.T]
        return Hinge(
            stroke=TorqueDriven(splines[0]), deviation=TorqueDriven(splines[1]), pitch=TorqueDriven(splines[2])
        )

    fly = replace(smooth, left=driven(needed.left_hinge), right=driven(needed.right_hinge))
    freed = simulate_flight(fly, ASYMMETRIC, 1, settings=EVERY_STEP)
    for side in ("left", "right"):
        apart = wing_angles(freed.wing(side)) - wing_angles(prescribed.wing(side))
        assert np.max(np.abs(apart)) < 1e-5


def test_a_held_body_stays_and_a_yawing_one_only_yaws():
    held = simulate_flight(replace(FLY, body=HELD), ASYMMETRIC, 2)
    np.testing.assert_array_equal(held.position_W, 0.0)
    np.testing.assert_array_equal(held.angular_velocity_S, 0.0)
    yawing = simulate_flight(replace(FLY, body=YAW_ONLY), ASYMMETRIC, 2)
    np.testing.assert_array_equal(yawing.angular_velocity_S[:, :2], 0.0)
    assert abs(yawing.yaw[-1]) > 1 * deg
    np.testing.assert_allclose(rotation_matrices(yawing.q_WS)[:, 2, 2], -1.0, rtol=1e-12)


def test_a_yaw_pulse_turns_right_by_its_impulse_wherever_its_edges_lie():
    """Without air: I_zz psi' of the whole fly changes by N times the pulse's duration."""
    fly = replace(WEIGHTLESS, body=YAW_ONLY)
    pulse = BodyPulse(start=0.3712 / FREQUENCY, duration=1.1117 / FREQUENCY, torque_S=(0.0, 0.0, 4e-10))
    flight = simulate_flight(fly, SYMMETRIC, 2, pulses=[pulse])
    model, q, _ = in_pinocchio(fly, flight)
    whole = pin.crba(model, model.createData(), q[-1])[5, 5]
    assert whole * flight.angular_velocity_S[-1, 2] == pytest.approx(4e-10 * pulse.duration, rel=1e-7)
    assert flight.yaw[-1] > 0


def test_pieces_of_a_flight_are_the_flight():
    whole = simulate_flight(FLY, ASYMMETRIC, 5, settings=MarchSettings(chunk=50))
    pieces = list(flight_chunks(FLY, ASYMMETRIC, 5, settings=MarchSettings(chunk=2)))
    assert [piece.wingbeats for piece in pieces] == [2, 4, 5]
    np.testing.assert_array_equal(pieces[-1].q_WS[-1], whole.q_WS[-1])
    np.testing.assert_array_equal(pieces[1].time[0], pieces[0].time[-1])


def test_steering_sees_every_wingbeat_and_its_strokes_take_hold():
    seen = []

    def steer(beat, state):
        seen.append(beat)
        right = Modulation(pitch_offset=3 * deg)
        return replace(SYMMETRIC, right=ModulatedStroke(stroke=SYMMETRIC.right, after=right, ramp=(1.0, 2.0)))

    flight = simulate_flight(FLY, steer, 4)
    assert seen == [0, 1, 2, 3]
    apart = flight.right.pitch - flight.left.pitch
    np.testing.assert_allclose(apart[flight.phase <= 1], 0.0, atol=1e-15)
    np.testing.assert_allclose(apart[flight.phase >= 2], 3 * deg, atol=1e-14)


def test_a_step_too_coarse_is_refused_with_the_steps_that_would_do():
    stiff = Hinge(pitch=DampedSpring(stiffness=2e-7))
    fly = replace(FLY, left=stiff, right=stiff)
    with pytest.raises(InvalidParameterError, match=r"about \d+ steps would do|many more steps"):
        simulate_flight(fly, SYMMETRIC, 1, settings=MarchSettings(steps=40, samples=10, tolerance=1e-5))


@pytest.mark.parametrize("wingbeats", [0, 1.5, float("nan"), "3"])
def test_other_than_whole_wingbeats_are_refused(wingbeats):
    with pytest.raises(InvalidParameterError, match="at least one wingbeat, and whole ones, got"):
        simulate_flight(FLY, SYMMETRIC, wingbeats)


def test_a_diverging_flight_stops_and_keeps_what_it_has():
    fly = replace(FLY, air=QuasiSteadyModel(terms=()))
    kick = BodyPulse(start=2.5 / FREQUENCY, duration=1.0, force_S=(1.0, 0.0, 0.0))
    flight = simulate_flight(fly, SYMMETRIC, 10, pulses=[kick])
    assert not flight.complete
    assert "wingbeat 2" in flight.status
    assert flight.wingbeats == 2
    assert np.all(np.isfinite(flight.velocity_S))
    assert len(flight.time) >= 100

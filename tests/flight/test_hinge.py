"""Wings that pitch passively on damped springs: what they keep, what they lose, and which way they turn a fly."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_fly import FLY, FREQUENCY, SYMMETRIC, rms, wing_stroke

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.hinge_fit import at_pitch_axis, fitted_spring
from flycontrol.flight.hinge_motion import passive_wingbeat, sprung
from flycontrol.flight.hinge_transmission import biased_wingbeat, hinge_transmission
from flycontrol.flight.hinge_work import held_wingbeat, pitch_torques, rest_angle, work_loop
from flycontrol.flight.multibody.freedoms import HELD, YAW_ONLY, Hinge
from flycontrol.flight.multibody.inverse import inverse_dynamics
from flycontrol.flight.quasi_steady import TERMS, VACUUM
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.hinge import DampedSpring, HingeStroke, SteeredSpring
from flycontrol.model.stroke import wing_axes
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import fourier_stroke, paddling
from flycontrol.units import deg

SPRING = DampedSpring(stiffness=1.8e-9, damping=1.4e-12, rest_angle=95 * deg)
LIGHT = DampedSpring(stiffness=1.8e-9, rest_angle=95 * deg)  # no damper: the air's alone
NEAR_THE_EDGE: FlappingFly = at_pitch_axis(FLY, 0.1)
FLUTTERING = sprung(NEAR_THE_EDGE, SPRING)
FINE = MarchSettings(steps=800, samples=800)
RESTING = StrokeKinematics.symmetric(HingeStroke(stroke=wing_stroke(), rest_angle=SPRING.rest_angle), FREQUENCY)
STEERED = replace(
    NEAR_THE_EDGE,
    left=Hinge(pitch=SteeredSpring(stiffness=SPRING.stiffness, damping=SPRING.damping)),
    right=Hinge(pitch=SteeredSpring(stiffness=SPRING.stiffness, damping=SPRING.damping)),
)


@pytest.fixture(scope="module")
def beat():
    return passive_wingbeat(FLUTTERING, SYMMETRIC, FINE)


def wing_spin(motion, side):
    """(N, 3) angular velocity of a wing in S, from a spectral derivative of its axes: R' R^T = [w]x."""
    axes = wing_axes(motion, side)
    frame = np.stack([axes.span, axes.chord, axes.normal], axis=-1)
    k = 2j * np.pi * np.fft.rfftfreq(len(frame), 1 / len(frame))
    turning = np.fft.irfft(k[:, None, None] * np.fft.rfft(frame, axis=0), len(frame), axis=0) * FREQUENCY
    skew = np.einsum("nij,nkj->nik", turning, frame)
    return np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)


def test_a_passive_wingbeat_ends_where_it_began_and_stays_so_in_flight(beat):
    flight = simulate_flight(replace(FLUTTERING, body=HELD), SYMMETRIC, 3, start=beat.start, settings=FINE)
    np.testing.assert_allclose(flight.right.pitch[:800], beat.trajectory.right.pitch, atol=1e-12)
    np.testing.assert_allclose(flight.right.pitch[-801:-1], beat.trajectory.right.pitch, atol=1e-9)


def test_over_a_passive_wingbeat_the_spring_works_nothing_and_the_damper_eats_what_air_and_drive_give(beat):
    torques = pitch_torques(FLUTTERING, beat.trajectory)
    spring = -SPRING.stiffness * (torques.pitch - SPRING.rest_angle)
    damper = -SPRING.damping * torques.pitch_rate
    eaten = torques.work(damper)
    assert eaten < 0
    # 1e-7: the sum over 800 samples of a motion with kinks in its third derivative
    assert abs(torques.work(spring)) < 1e-7 * abs(eaten)
    given = sum(torques.work(air) for air in torques.air.values()) - torques.work(torques.inertia)
    assert given == pytest.approx(-eaten, rel=1e-7)


def test_what_the_muscles_put_in_the_air_and_the_dampers_take_out(beat):
    """Of the whole fly, kinetic energy back where it was: integral of (tau_phi phi' + tau_theta theta' + ...) = 0."""
    flight = beat.trajectory
    torques, loads = inverse_dynamics(FLUTTERING, flight), loads_along(FLUTTERING, flight)
    hinge = np.array(FLY.morphology.right_hinge)
    muscles, air, dampers = 0.0, 0.0, 0.0
    for side, at in (("left", hinge * [1, -1, 1]), ("right", hinge)):
        motion = flight.wing(side)
        tau = torques.left_hinge if side == "left" else torques.right_hinge
        muscles += np.mean(tau[:, 0] * motion.stroke_rate + tau[:, 1] * motion.deviation_rate)
        dampers += np.mean(-SPRING.damping * motion.pitch_rate**2)
        total = (loads.left if side == "left" else loads.right).total
        about_hinge = total.torque - np.cross(at, total.force)
        air += np.mean(np.sum(about_hinge * wing_spin(motion, side), axis=1))
    assert muscles > 0 > air
    assert dampers < 0
    assert abs(muscles + air + dampers) < 1e-5 * muscles


def test_inverse_dynamics_of_a_passive_motion_gives_the_spring_back(beat):
    loop = work_loop(pitch_torques(FLUTTERING, beat.trajectory, "left"))
    assert loop.stiffness == pytest.approx(SPRING.stiffness, rel=1e-9)
    assert loop.damping == pytest.approx(SPRING.damping, rel=1e-9)
    assert loop.rest_angle == pytest.approx(SPRING.rest_angle, rel=1e-9)
    assert loop.explained == pytest.approx(1.0, abs=1e-12)
    assert loop.work < 0  # counter-clockwise, by construction


def test_a_known_stiffness_tells_the_rest_angle_from_the_means_alone(beat):
    """The damper's mean is that of eta', which is zero over a wingbeat."""
    torques = pitch_torques(FLUTTERING, beat.trajectory)
    assert rest_angle(torques, SPRING.stiffness) == pytest.approx(SPRING.rest_angle, abs=1e-8)


def test_a_held_wingbeat_is_the_first_of_a_flight_with_the_body_held():
    held = held_wingbeat(FLUTTERING, SYMMETRIC)
    flight = simulate_flight(replace(FLY, body=HELD), SYMMETRIC, 1, settings=MarchSettings(samples=200))
    np.testing.assert_array_equal(held.right.pitch, flight.right.pitch[:-1])
    np.testing.assert_array_equal(held.left_acceleration, flight.left_acceleration[:-1])


def test_the_torque_of_a_term_about_the_pitch_axis_is_that_of_its_load_on_the_wing(beat):
    flight = beat.trajectory
    torques, loads = pitch_torques(FLUTTERING, flight), loads_along(FLUTTERING, flight)
    span, hinge = wing_axes(flight.right, "right").span, np.array(FLY.morphology.right_hinge)
    for term in TERMS:
        load = loads.right.terms[term]
        about_span = np.sum(span * (load.torque - np.cross(hinge, load.force)), axis=1)
        np.testing.assert_allclose(torques.air[term], about_span, atol=1e-10 * rms(torques.hinge))


def test_disturbances_of_pitch_shrink_as_the_damper_alone_says_without_air():
    """Liouville: d(eta, eta')(T) / d(eta, eta')(0) has the determinant exp(-C T / I_ss)."""
    stiff = replace(SPRING, stiffness=8e-9, damping=4e-13)
    fly = replace(sprung(NEAR_THE_EDGE, stiff), air=VACUUM)
    found = passive_wingbeat(fly, SYMMETRIC, FINE)
    shrink = np.exp(-stiff.damping / (fly.morphology.wing_body.span_inertia * FREQUENCY))
    np.testing.assert_allclose(found.multipliers.prod(axis=1), shrink, rtol=1e-4)  # forward differences


def test_a_stiff_spring_leaves_the_wing_at_rest_but_for_the_torque_over_kappa():
    """The departure from the rigid wing's torque over kappa falls with kappa itself."""
    rigid = simulate_flight(replace(NEAR_THE_EDGE, body=HELD), RESTING, 1, settings=FINE)
    needed = inverse_dynamics(NEAR_THE_EDGE, rigid).right_hinge[:-1, 2]
    apart = []
    for stiffness in (2e-7, 8e-7):
        spring = replace(SPRING, stiffness=stiffness, damping=3e-12)
        pitch = passive_wingbeat(sprung(NEAR_THE_EDGE, spring), RESTING, FINE).trajectory.right.pitch
        apart.append(rms(-stiffness * (pitch - spring.rest_angle) - needed) / rms(needed))
    assert apart[0] < 0.05
    assert apart[1] < apart[0] / 3


def test_a_stiff_spring_passes_all_of_a_bias_on_and_no_spring_none_of_it():
    stiff = hinge_transmission(NEAR_THE_EDGE, RESTING, replace(SPRING, stiffness=8e-7, damping=3e-12), settings=FINE)
    assert abs(stiff.mu - 1) < 0.01
    assert abs(stiff.mu_torque - 1) < 0.03
    slack = hinge_transmission(NEAR_THE_EDGE, SYMMETRIC, replace(SPRING, stiffness=0.0))
    assert abs(slack.mu) < 1e-7


def test_opposite_biases_turn_the_fly_by_their_sign_and_change_its_lift_in_second_order_only():
    up, down = (biased_wingbeat(NEAR_THE_EDGE, SYMMETRIC, SPRING, sign * 8 * deg) for sign in (1, -1))
    half, hover = (biased_wingbeat(NEAR_THE_EDGE, SYMMETRIC, SPRING, bias) for bias in (4 * deg, 0.0))
    weight, torque = FLY.morphology.weight, abs(up.torque[2])
    assert up.torque[2] > 0  # the right hinge's rest angle up: to the right
    assert up.d_alpha > 0
    np.testing.assert_allclose(up.force * [1, -1, 1], down.force, atol=1e-8 * weight)
    np.testing.assert_allclose(up.torque * [-1, 1, -1], down.torque, atol=1e-8 * torque)
    np.testing.assert_allclose(hover.torque[[0, 2]], 0.0, atol=1e-8 * torque)
    assert (up.force[2] - hover.force[2]) / (half.force[2] - hover.force[2]) == pytest.approx(4.0, rel=0.05)
    assert up.torque[2] / half.torque[2] == pytest.approx(2.0, rel=0.02)


def test_a_steered_spring_with_a_constant_rest_angle_is_a_damped_spring(beat):
    steered = passive_wingbeat(STEERED, RESTING, FINE).trajectory
    np.testing.assert_allclose(steered.right.pitch, beat.trajectory.right.pitch, atol=1e-9)


def test_steering_moves_the_rest_angles_between_wingbeats_and_a_bias_up_on_the_right_turns_right():
    left, right = paddling(5 * deg)
    hover = passive_wingbeat(STEERED, RESTING)

    def steer(wingbeat, _):
        return RESTING.modulated(left, right) if wingbeat >= 2 else RESTING

    fly = replace(STEERED, body=YAW_ONLY)
    flight = simulate_flight(fly, steer, 6, start=hover.start, settings=MarchSettings(samples=200))
    # yaw alone: before the bias the fly, its wings alike, does not move at all
    np.testing.assert_allclose(flight.yaw[:401], 0.0, atol=1e-12)
    np.testing.assert_allclose(flight.right.pitch[200:400], hover.trajectory.right.pitch, atol=1e-6)
    assert np.all(np.diff(flight.yaw[600::200]) > 1 * deg)
    still = simulate_flight(replace(fly, body=HELD), steer, 6, start=hover.start, settings=MarchSettings(samples=200))
    biased = biased_wingbeat(NEAR_THE_EDGE, RESTING, SPRING, 5 * deg).passive.trajectory
    np.testing.assert_allclose(still.right.pitch[-201:-1], biased.right.pitch, atol=1e-6)
    np.testing.assert_allclose(still.left.pitch[-201:-1], biased.left.pitch, atol=1e-6)


def test_a_fly_on_springs_stops_turning_as_much_slower_as_its_damping_says():
    """ln(psi'_0 / psi'_n) goes with beta / I; the ratio of two flies that pitch alike does without I."""
    found = hinge_transmission(NEAR_THE_EDGE, SYMMETRIC, SPRING)
    hover = passive_wingbeat(FLUTTERING, SYMMETRIC)
    flight = hover.trajectory.right
    angles = np.stack([flight.stroke, flight.deviation, flight.pitch], axis=1)
    as_in_hover = StrokeKinematics.symmetric(fourier_stroke(hover.trajectory.phase, angles, 40), FREQUENCY)

    def decay(fly, stroke):
        start = replace(hover.start, angular_velocity_S=np.array([0.0, 0.0, 5.0]))
        flown = simulate_flight(replace(fly, body=YAW_ONLY), stroke, 4, start=start, settings=MarchSettings(samples=1))
        return np.log(flown.angular_velocity_S[1, 2] / flown.angular_velocity_S[-1, 2])

    slower = decay(FLUTTERING, SYMMETRIC) / decay(NEAR_THE_EDGE, as_in_hover)
    assert slower < 0.7
    assert slower == pytest.approx(found.damping / found.damping_at_given_pitch, rel=0.03)


def test_a_spring_that_made_a_wingbeat_is_found_again(beat):
    flight = beat.trajectory
    angles = np.stack([flight.right.stroke, flight.right.deviation, flight.right.pitch], axis=1)
    seen = StrokeKinematics.symmetric(fourier_stroke(flight.phase, angles, 40), FREQUENCY)
    found = fitted_spring(NEAR_THE_EDGE, seen)
    # the samples' kinks and 200 steps in place of 800 leave hundredths of a degree
    assert found.rms < 0.05 * deg
    assert found.spring.stiffness == pytest.approx(SPRING.stiffness, rel=0.01)
    assert found.spring.damping == pytest.approx(SPRING.damping, rel=0.01)
    assert found.spring.rest_angle == pytest.approx(SPRING.rest_angle, abs=0.5 * deg)
    assert not found.at_limit


def test_what_cannot_be_a_hinge_or_a_passive_wingbeat_is_refused(beat):
    with pytest.raises(InvalidParameterError, match="stiffness and damping >= 0"):
        DampedSpring(stiffness=-1e-9)
    with pytest.raises(InvalidParameterError, match="stiffness and damping >= 0"):
        SteeredSpring(stiffness=float("nan"))
    with pytest.raises(InvalidParameterError, match="rest_angle must be a finite angle"):
        replace(SPRING, rest_angle=float("nan"))
    with pytest.raises(InvalidParameterError, match="rest_angle must be a finite angle"):
        HingeStroke(stroke=wing_stroke(), rest_angle=float("inf"))
    with pytest.raises(InvalidParameterError, match="take more steps a wingbeat or a softer spring"):
        passive_wingbeat(sprung(FLY, replace(SPRING, stiffness=1e-3)), SYMMETRIC)
    with pytest.raises(InvalidParameterError, match="`sprung` makes such a fly"):
        passive_wingbeat(FLY, SYMMETRIC)
    cut = replace(beat.trajectory, time=beat.trajectory.time[:799])
    with pytest.raises(InvalidInputError, match="whole wingbeats of 800 samples, got 799"):
        pitch_torques(FLUTTERING, cut)
    with pytest.raises(InvalidParameterError, match="'left' or the 'right' wing, got 'middle'"):
        pitch_torques(FLUTTERING, beat.trajectory, side="middle")
    for stiffness in (0.0, -1e-9, float("nan")):
        with pytest.raises(InvalidParameterError, match="finite and > 0 N m/rad, got"):
            rest_angle(pitch_torques(FLUTTERING, beat.trajectory), stiffness)
    for rate in (float("nan"), float("inf")):
        with pytest.raises(InvalidParameterError, match="finite yaw rate in rad/s"):
            passive_wingbeat(FLUTTERING, SYMMETRIC, yaw_rate=rate)


@pytest.mark.parametrize("measure", [biased_wingbeat, hinge_transmission])
@pytest.mark.parametrize("bias", [5, -100 * deg, float("nan")])
def test_a_bias_that_cannot_be_in_radians_is_refused(measure, bias):
    with pytest.raises(InvalidParameterError, match=r"in radians, within \+-pi/2, got .*; write 5 \* deg"):
        measure(NEAR_THE_EDGE, SYMMETRIC, SPRING, bias=bias)


def test_a_transmission_over_no_bias_is_refused():
    with pytest.raises(InvalidParameterError, match="a bias other than 0 rad"):
        hinge_transmission(NEAR_THE_EDGE, SYMMETRIC, SPRING, bias=0.0)

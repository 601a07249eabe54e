from dataclasses import fields, replace

import numpy as np
import pytest
from filmed_flights import BARE, CAMERAS, RATE, STROKE_PLANE, apart, drawn, turning_flight
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from flycontrol.errors import InvalidParameterError
from flycontrol.model.pose import mirrored, pose_of_axes
from flycontrol.units import deg, mm
from flycontrol.vision.follower import Fly
from flycontrol.vision.smooth.smooth_curve import smooth_curve
from flycontrol.vision.smoothed_pose import SmoothedPose
from flycontrol.vision.smoothing import smoothed, too_few_to_smooth
from flycontrol.vision.track import track as track_silhouettes
from flycontrol.vision.tracked_frame import Track

#: Standard deviations as a tracker states them: most of those of the wings come from the body's roll.
_WING, _BASE = [2.1 * deg, 1.2 * deg, 1.4 * deg], [6e-3 * mm, 15e-3 * mm, 18e-3 * mm]
SPREAD = np.array([*[6e-3 * mm] * 3, 0.24 * deg, 0.17 * deg, 2.8 * deg, *_WING, *_WING, *_BASE, *_BASE])
LASTING = 2800 / RATE  #: of a tracker's errors, per frame


def lasting(rng, shape):
    """Errors of variance 1 whose correlation after m frames is (1 + kappa m) exp(-kappa m)."""
    frames = np.arange(-40, 41)
    kernel = np.exp(-LASTING * np.abs(frames))  # convolved with itself it is that correlation
    kernel /= np.sqrt(np.sum(kernel**2))
    white = rng.standard_normal((shape[0] + len(kernel) - 1, *shape[1:]))
    return np.apply_along_axis(np.convolve, 0, white, kernel, mode="valid")


def seen_with_errors(pose, rng):
    """A pose as silhouettes show it: the roll of the body badly, the place of its wings in the world well."""
    n = len(pose)
    last, white = lasting(rng, (n, 18)), rng.standard_normal((n, 18))
    body, wing = last + 0.2 * white, 0.7 * (last + white)
    R = pose.body_axes_W @ turned(body[:, 3:6] * [2.8 * deg, 0.17 * deg, 0.17 * deg])
    always = np.array([0.7, -0.7, 0.7])  # of positions, such as legs make it
    x = pose.position_W + 6e-3 * mm * (always + 0.5 * last[:, :3] + 0.1 * white[:, :3])
    wings = [pose.body_axes_W @ turned(0.2 * deg * wing[:, part]) @ np.swapaxes(pose.body_axes_W, 1, 2)
             @ pose.wing_axes_W(side) for side, part in (("left", slice(6, 9)), ("right", slice(9, 12)))]  # fmt: skip
    bases = [np.einsum("nji,nj->ni", R, pose.base_W(side) + 4e-3 * mm * wing[:, part] - x)
             for side, part in (("left", slice(12, 15)), ("right", slice(15, 18)))]  # fmt: skip
    return pose_of_axes(x, R, tuple(wings), tuple(bases), pose.stroke_plane_angle)


def turned(vectors):
    return Rotation.from_rotvec(vectors).as_matrix()


def track_of(pose, spread=SPREAD):
    n = len(pose)
    return Track(
        pose=pose, uncertainty=np.broadcast_to(spread, (n, 18)).copy(),
        status=("tracked",) * n, reasons=("",) * n, overlap=np.ones((n, 3)), precision=np.ones((n, 3)),
    )  # fmt: skip


def unseen(track, frames, status="bridged"):
    states, X, U = list(track.status), track.pose.coordinates.copy(), track.uncertainty.copy()
    for k in frames:
        states[k] = status
    if status == "lost":
        X[frames], U[frames] = np.nan, np.nan
    return replace(track, status=tuple(states), pose=replace(track.pose, coordinates=X), uncertainty=U)


def with_coordinates(track, X):
    return replace(track, pose=replace(track.pose, coordinates=X))


def rotated_pose(pose, Q):
    wings = pose.wing_axes_W("left"), pose.wing_axes_W("right")
    return pose_of_axes(
        pose.position_W @ Q.T, Q @ pose.body_axes_W, tuple(Q @ axes for axes in wings),
        (pose.base_B("left"), pose.base_B("right")), pose.stroke_plane_angle,
    )  # fmt: skip


def rotated(track, Q):
    """Seen in another world, turns of the body known to 2.8 deg about its length and 0.17 deg across."""
    pose = rotated_pose(track.pose, Q)
    U = track.uncertainty.copy()
    U[:, 3] = 0.17 * deg / np.cos(pose.pitch)
    U[:, 4] = 0.17 * deg
    U[:, 5] = np.hypot(2.8 * deg, np.sin(pose.pitch) * U[:, 3])
    return replace(track, pose=pose, uncertainty=U)


def names_of(found):
    return [field.name for field in fields(found)]


def pose_far(frames):
    """Frames that are not within ten of these."""
    return [k for k in range(216) if all(abs(k - other) > 10 for other in frames)]


def rms(values):
    return np.sqrt(np.nanmean(np.square(values), axis=0))


def alike(one: SmoothedPose, other: SmoothedPose, share=1e-3):
    """Two smoothed poses differ by far less than is known of them."""
    assert np.nanmax(np.abs(apart(one.pose, other.pose)) / one.uncertainty) < share
    assert np.nanmax(np.abs(one.rate - other.rate) / one.rate_uncertainty) < share
    assert np.nanmax(np.abs(one.acceleration - other.acceleration) / one.acceleration_uncertainty) < share
    omega = np.abs(one.angular_velocity_B - other.angular_velocity_B)
    assert np.nanmax(omega / one.angular_velocity_uncertainty) < share


@pytest.fixture(scope="module")
def flight():
    pose = turning_flight(6)
    return pose, track_of(seen_with_errors(pose, np.random.default_rng(7)))


@pytest.fixture(scope="module")
def smooth_flight(flight):
    return smoothed(flight[1], RATE)


def test_a_cubic_that_is_known_well_comes_back_with_its_derivatives():
    u = np.linspace(0, 1, 200)
    T = 199 / RATE
    pose = turning_flight(6)[:200]
    X = pose.coordinates.copy()
    X[:, 0] = mm * (1 + 2 * u - 3 * u**2 + u**3)
    found = smoothed(track_of(replace(pose, coordinates=X), spread=1e-4 * SPREAD), RATE)
    assert np.max(np.abs(found.pose.position_W[:, 0] - X[:, 0])) < 1e-4 * SPREAD[0]
    assert found.rate[:, 0] == pytest.approx(mm * (2 - 6 * u + 3 * u**2) / T, abs=1e-3 * mm / T)
    assert found.acceleration[:, 0] == pytest.approx(mm * (6 * u - 6) / T**2, abs=0.05 * mm / T**2)


def test_smoothing_brings_every_coordinate_nearer_to_the_truth(flight, smooth_flight):
    pose, track = flight
    gain = rms(apart(smooth_flight.pose, pose)) / rms(apart(track.pose, pose))
    assert np.all(gain < 1), gain
    assert np.all(gain[[5, 6, 7, 9, 10]] < 0.75)  # roll, and strokes and deviations, which its errors had reached


def test_95_percent_bands_hold_the_truth_as_often_as_they_say(flight, smooth_flight):
    pose, _ = flight
    inside = np.abs(apart(smooth_flight.pose, pose)) < 1.96 * smooth_flight.uncertainty
    assert np.all(np.mean(inside, axis=0) > 0.85), np.mean(inside, axis=0)
    time = np.arange(len(pose)) / RATE
    rate = make_interp_spline(time, np.unwrap(pose.coordinates, axis=0), k=5).derivative()(time)
    known = np.abs(smooth_flight.rate - rate) < 1.96 * smooth_flight.rate_uncertainty
    assert np.all(np.mean(known, axis=0) > 0.85), np.mean(known, axis=0)


def test_derivatives_are_those_of_the_smoothed_curve(smooth_flight):
    X = np.unwrap(smooth_flight.pose.coordinates, axis=0)
    step = 1 / RATE
    # Hermite: the slopes and curvatures at both ends of a step give its length to the fourth order
    for low, high, width in (
        (X, smooth_flight.rate, smooth_flight.rate_uncertainty),
        (smooth_flight.rate, smooth_flight.acceleration, smooth_flight.acceleration_uncertainty),
    ):
        away = np.abs(np.diff(low, axis=0) / step - (high[1:] + high[:-1]) / 2)
        assert np.all(np.median(away / width[1:], axis=0) < 0.5)


def test_time_reversed_gives_the_same_curves_with_rates_reversed(flight, smooth_flight):
    track = flight[1]
    back = smoothed(with_coordinates(track, track.pose.coordinates[::-1]), RATE)
    forth = SmoothedPose(**{
        name: back.pose[::-1] if name == "pose" else getattr(back, name)[::-1] for name in names_of(back)
    })  # fmt: skip
    reversed_rates = replace(forth, rate=-forth.rate, angular_velocity_B=-forth.angular_velocity_B)
    alike(reversed_rates, smooth_flight)


def test_rotating_the_world_rotates_the_result_even_through_upright(flight):
    """Turned so that the fly flies nose up, where yaw and roll jump."""
    track = flight[1]
    forward = track.pose.body_axes_W[108, :, 0]
    nose_up = Rotation.align_vectors([0.0, 0.0, 1.0], forward)[0].as_matrix()
    plain, other = (smoothed(rotated(track, Q), RATE) for Q in (np.eye(3), nose_up))
    assert np.max(other.pose.pitch) > 88 * deg
    there = rotated_pose(plain.pose, nose_up)
    turns = Rotation.from_matrix(np.swapaxes(there.body_axes_W, 1, 2) @ other.pose.body_axes_W).magnitude()
    assert np.max(turns) < 1e-3 * deg
    assert np.max(np.abs(there.position_W - other.pose.position_W)) < 1e-3 * SPREAD[0]
    assert np.max(np.abs(there.coordinates[:, 6:] - other.pose.coordinates[:, 6:]) / SPREAD[6:]) < 1e-2
    away = np.abs(plain.angular_velocity_B - other.angular_velocity_B)
    assert np.max(away / plain.angular_velocity_uncertainty) < 1e-2


def test_yaw_of_another_turn_changes_nothing(flight, smooth_flight):
    track = flight[1]
    X = track.pose.coordinates.copy()
    X[:, 3] += 2 * np.pi * (np.arange(len(X)) % 3)
    alike(smoothed(with_coordinates(track, X), RATE), smooth_flight)


def test_yaw_runs_on_beyond_half_a_turn(flight):
    track = rotated(flight[1], turned(np.array([0.0, 0.0, -120 * deg])))
    assert np.max(np.abs(np.diff(track.pose.yaw))) > 350 * deg
    yaw = smoothed(track, RATE).pose.yaw
    assert np.max(np.abs(np.diff(yaw))) < 5 * deg


def test_a_wing_that_is_pitched_beyond_half_a_turn_does_not_jump(flight):
    pose = flight[0]
    X = pose.coordinates.copy()
    X[:, 8] += 60 * deg
    X[:, 8] = (X[:, 8] + np.pi) % (2 * np.pi) - np.pi
    assert np.ptp(X[:, 8]) > 350 * deg
    found = smoothed(track_of(replace(pose, coordinates=X)), RATE)
    assert not found.set_aside.any()
    assert np.max(np.abs(found.pose.wing("left").pitch - pose.wing("left").pitch - 60 * deg)) < 1.5 * deg


def test_mirrored_flights_give_mirrored_curves(flight, smooth_flight):
    track = flight[1]
    other = smoothed(replace(track, pose=mirrored(track.pose)), RATE)
    away = np.abs(apart(mirrored(smooth_flight.pose), other.pose))
    assert np.max(away / other.uncertainty) < 1e-3
    assert np.allclose(other.angular_velocity_B[:, 1], smooth_flight.angular_velocity_B[:, 1], rtol=1e-3, atol=1e-2)


def test_a_gap_is_bridged_with_bands_that_grow_and_changes_little_outside(flight, smooth_flight):
    pose, track = flight
    gap = np.arange(100, 108)
    for status in ("bridged", "lost"):
        found = smoothed(unseen(track, gap, status), RATE)
        assert np.all(np.isfinite(found.pose.coordinates))
        wider = found.uncertainty[gap] / smooth_flight.uncertainty[gap]
        assert np.all(wider > 0.99)
        assert np.all(np.max(wider, axis=0)[[8, 11]] > 3)  # wings turn over within such a gap
        away = np.abs(apart(found.pose, pose))[gap]
        assert np.all(np.mean(away < 1.96 * found.uncertainty[gap], axis=0)[:6] > 0.85)
        far = np.r_[0:60, 150:200]
        moved = np.abs(apart(found.pose, smooth_flight.pose))[far]
        assert np.all(np.median(moved / found.uncertainty[far], axis=0) < 0.1)


def test_what_the_tracker_expects_of_frames_that_it_did_not_see_is_no_observation(flight):
    track = flight[1]
    X = track.pose.coordinates.copy()
    X[100:108] += 1.0
    alike(*(smoothed(unseen(t, np.arange(100, 108)), RATE) for t in (track, with_coordinates(track, X))))


def test_frames_lost_at_both_ends_and_in_too_long_a_gap_stay_unknown(flight):
    track = flight[1]
    lost = np.r_[0:10, 90:131, 205 : len(track)]
    found = smoothed(unseen(track, lost, "lost"), RATE, longest_gap=40)
    known = np.setdiff1d(np.arange(len(track)), lost)
    for name in names_of(found):
        values = found.pose.coordinates if name == "pose" else getattr(found, name)
        if values.dtype == np.bool_:
            continue
        assert np.all(np.isnan(values[lost]))
        assert np.all(np.isfinite(values[known]))
    bridged = smoothed(unseen(track, lost, "lost"), RATE, longest_gap=41)
    assert np.all(np.isfinite(bridged.pose.coordinates[10:205]))


def test_a_wing_that_is_not_believed_is_bridged_alone_and_unknown_in_too_long_a_gap(flight, smooth_flight):
    pose, track = flight
    X = track.pose.coordinates.copy()
    X[100:106, 9:12] += 1.0
    doubts = [("", "", "hidden") if 100 <= k < 106 else ("", "", "") for k in range(len(track))]
    found = smoothed(replace(with_coordinates(track, X), doubts=tuple(doubts)), RATE)
    assert np.all(np.abs(apart(found.pose, pose))[100:106, 9:12] < 3 * found.uncertainty[100:106, 9:12])
    assert np.all(found.uncertainty[102:104, 11] > 2 * smooth_flight.uncertainty[102:104, 11])
    assert np.array_equal(found.pose.coordinates[:, :9], smooth_flight.pose.coordinates[:, :9])
    short = smoothed(replace(track, doubts=tuple(doubts)), RATE, longest_gap=5)
    unknown = np.isnan(short.pose.coordinates)
    right = [9, 10, 11, 15, 16, 17]
    assert np.all(unknown[100:106, right])
    assert np.sum(unknown) == 6 * len(right)


def test_too_few_frames_give_nothing(flight):
    track = flight[1]
    found = smoothed(unseen(track, np.r_[7 : len(track)], "lost"), RATE)
    assert np.all(np.isnan(found.pose.coordinates))
    assert not found.set_aside.any()
    assert len(smoothed(track_of(track.pose[:0]), RATE).pose) == 0


def test_why_nothing_is_smoothed_is_said_of_those_tracks_alone_of_which_nothing_is(flight):
    track = flight[1]
    for frames, said in ((0, "are none."), (1, "is 1."), (7, "are 7."), (8, "")):
        short = unseen(track, np.r_[frames : len(track)], "lost")
        assert too_few_to_smooth(short).endswith(said)
        assert bool(too_few_to_smooth(short)) == bool(said)
        assert bool(said) == np.all(np.isnan(smoothed(short, RATE).pose.coordinates))


def test_a_fly_that_does_not_move_has_rates_of_nought(flight):
    found = smoothed(track_of(flight[0][np.zeros(100, dtype=int)]), RATE)
    assert np.max(np.abs(found.rate) / found.rate_uncertainty) < 1e-3
    assert np.max(np.abs(found.angular_velocity_B) / found.angular_velocity_uncertainty) < 1e-3
    assert np.max(np.abs(apart(found.pose, flight[0][np.zeros(100, dtype=int)])) / SPREAD) < 1e-3


def test_a_wing_that_is_wrong_in_a_few_frames_is_set_aside_and_counted(flight, smooth_flight):
    pose, track = flight
    wrong = [30, 95, 160]
    X = track.pose.coordinates.copy()
    X[wrong, 6] += 50 * deg
    found = smoothed(with_coordinates(track, X), RATE)
    assert list(np.flatnonzero(found.set_aside[:, 6])) == wrong
    assert not smooth_flight.set_aside.any()
    away = np.abs(apart(found.pose, pose)[:, 6])
    assert np.all(away[wrong] < 2 * found.uncertainty[wrong, 6])
    assert np.max(np.abs(apart(found.pose, smooth_flight.pose)[:, 6] / found.uncertainty[:, 6])[pose_far(wrong)]) < 0.1


def test_a_body_that_points_backwards_in_one_frame_is_set_aside(flight):
    pose, track = flight
    X = track.pose.coordinates.copy()
    X[100, 3] += np.pi
    found = smoothed(with_coordinates(track, X), RATE)
    assert list(np.flatnonzero(found.set_aside[:, 3])) == [100]
    assert np.max(np.abs(apart(found.pose, pose)[:, 3])) < 1 * deg


def test_white_noise_on_a_sine_is_reduced_and_its_bands_are_calibrated():
    rng = np.random.default_rng(1)
    time = np.arange(400) / RATE
    sine, sigma = np.sin(2 * np.pi * 100 * time), 0.05
    hits, gains = [], []
    for _ in range(5):
        y = sine + sigma * rng.standard_normal(len(time))
        curve = smooth_curve(y, np.full(len(time), sigma), [slice(0, 400)], RATE, lasting=None)
        away = curve.value[:, 0] - sine
        hits.append(np.abs(away) < 1.96 * np.sqrt(curve.covariance[:, 0, 0]))
        gains.append(rms(away) / rms(y - sine))
    assert np.max(gains) < 0.5
    assert 0.88 < np.mean(hits) <= 1.0


def test_a_frame_rate_that_is_none_is_refused(flight):
    with pytest.raises(InvalidParameterError, match="frame rate"):
        smoothed(flight[1], 0.0)
    with pytest.raises(InvalidParameterError, match="longest gap"):
        smoothed(flight[1], RATE, longest_gap=-1)


@pytest.mark.slow
def test_a_tracked_flight_is_no_further_from_the_truth_in_any_coordinate_and_its_bands_hold():
    pose = turning_flight(5)
    track = track_silhouettes(drawn(pose), CAMERAS, Fly(shape=BARE, stroke_plane_angle=STROKE_PLANE))
    found = smoothed(track, RATE)
    gain = rms(apart(found.pose, pose)) / rms(apart(track.pose, pose))
    assert np.all(gain < 1.02), gain
    assert np.all(gain[5:12] < 0.7)  # roll and the wings
    inside = np.abs(apart(found.pose, pose)) < 1.96 * found.uncertainty
    assert np.all(np.mean(inside, axis=0) > 0.85), np.mean(inside, axis=0)

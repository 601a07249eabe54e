from dataclasses import replace

import numpy as np
import pytest
from filmed_flights import BARE, CAMERAS, SCALE, STROKE_PLANE, WITH_LEGS, any_flight, apart, drawn, turning_flight

from flycontrol.errors import InvalidInputError
from flycontrol.model.pose import Pose
from flycontrol.units import deg
from flycontrol.vision.first_pose import first_pose
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.fly_size import sized_fly
from flycontrol.vision.follower import Fly, Follower
from flycontrol.vision.render import render_silhouettes
from flycontrol.vision.search.belief import Judged
from flycontrol.vision.sighting import sighting_of
from flycontrol.vision.silhouette_fit import Agreement, SilhouetteFit
from flycontrol.vision.size_fit import Sizes, fitted_sizes, resized
from flycontrol.vision.soft_silhouette import border_distance
from flycontrol.vision.stance import pose_of, stances_of
from flycontrol.vision.track import track
from flycontrol.vision.tracked_frame import gathered
from flycontrol.vision.views import views_of

FLY = Fly(shape=BARE, stroke_plane_angle=STROKE_PLANE)
AIMS = np.array([1, 1, 3, 2, 2, 5, 2, 2, 5]) * deg  #: yaw, pitch, roll; stroke, deviation, pitch of the wings


def rms(values):
    return np.sqrt(np.mean(np.square(values), axis=0))


NOTHING = Agreement(cost=np.inf, overlap=np.zeros(3), precision=np.zeros(3))


def known(stance):
    return SilhouetteFit(
        stance=stance, covariance=np.zeros((18, 18)), agreement=NOTHING, converged=True, iterations=0
    )  # fmt: skip


def followed(frames, pose, **kwargs):
    follower = Follower(
        cameras=CAMERAS, fly=FLY, start=known(stances_of(pose[0])[0]), **{"refine": True, **kwargs}
    )  # fmt: skip
    return gathered((follower.follow(masks) for masks in frames), STROKE_PLANE, 3)


@pytest.fixture(scope="module")
def short():
    pose = turning_flight(1)[:12]
    return pose, drawn(pose)


def test_a_fly_is_followed_within_the_aims(short):
    pose, frames = short
    found = followed(frames, pose)
    away = apart(found.pose, pose)
    assert found.status == ("tracked",) * len(pose)
    assert np.all(rms(away[:, 3:12]) < AIMS)
    assert np.max(np.abs(away[:, :3])) < 1 / SCALE


def test_an_empty_frame_is_bridged_with_more_uncertainty_and_the_fly_found_again(short):
    pose, frames = short
    broken = list(frames)
    broken[6] = (np.zeros_like(frames[6][0]), *frames[6][1:])
    found = followed(broken, pose)
    assert found.status[6] == "bridged"
    assert "empty" in found.reasons[6]
    assert found.status[7:] == ("tracked",) * 5
    assert np.all(found.uncertainty[6] > found.uncertainty[5])
    assert np.max(np.abs(apart(found.pose, pose)[6, 3:6])) < 3 * deg


def test_a_frame_of_another_animal_is_not_believed(short):
    pose, frames = short
    broken = list(frames)
    broken[6] = tuple(np.roll(mask, 60, axis=1) for mask in frames[6])
    found = followed(broken, pose)
    assert found.status[6] == "bridged"
    assert found.status[-1] == "tracked"


def test_a_wing_that_is_not_there_is_not_claimed_to_be_seen(short):
    pose, frames = short
    broken = list(frames)
    broken[6] = next(iter(render_silhouettes(WITH_LEGS, pose[6], CAMERAS, parts=["body", "left", "legs"])))
    found = followed(broken, pose)
    assert found.status == ("tracked",) * 6 + ("partial",) + ("tracked",) * 5
    assert found.doubts[6][:2] == ("", "")
    assert "right wing" in found.doubts[6][2]
    assert "right wing" in found.reasons[6]
    away = apart(found.pose, pose)[6]
    assert np.all(np.abs(away[3:9]) < 3 * AIMS[:6])
    assert np.all(found.uncertainty[6, 9:12] > 2 * found.uncertainty[5, 9:12])
    assert np.all(np.abs(away[9:12]) < 2.5 * found.uncertainty[6, 9:12])


def test_a_wing_that_is_not_where_it_is_expected_is_looked_for_everywhere(short):
    pose, frames = short
    X = pose.coordinates.copy()
    X[6:, 9:11] += np.array([-60, 35]) * deg
    jumped = Pose(coordinates=X, stroke_plane_angle=STROKE_PLANE)
    found = followed([*frames[:6], *drawn(jumped[6:])], jumped)
    away = apart(found.pose, jumped)
    assert found.status == ("tracked",) * len(pose)
    assert np.max(np.abs(away[:, 9:11])) < 10 * deg  # of a jump of 60


def test_a_fly_that_stays_away_is_lost_and_has_no_coordinates(short):
    pose, frames = short
    empty = tuple(np.zeros_like(mask) for mask in frames[0])
    found = followed([*frames[:3], *[empty] * 45], pose)
    assert found.status[-1] == "lost"
    assert np.all(np.isnan(found.pose.coordinates[-1]))
    assert np.all(np.isnan(found.uncertainty[-1]))


def test_a_fly_cut_by_the_border_is_marked(short):
    pose, frames = short
    cut = [tuple(mask.copy() for mask in masks) for masks in frames[:2]]
    cut[1][0][0, :] = False
    cut[1][0][0, 128] = True
    found = followed(cut, pose)
    assert found.status[1] in ("partial", "bridged")
    assert found.reasons[1]


def test_the_first_pose_is_found_without_a_hint(short):
    pose, frames = short
    start = first_pose(frames[:1], CAMERAS, fit_shape(BARE), STROKE_PLANE)
    away = apart(pose_of([start.fit.stance], STROKE_PLANE), pose[start.frame])
    assert np.all(np.abs(away[0, 3:12]) < 2 * AIMS)


def test_a_first_pose_whose_wings_the_silhouettes_bear_out_goes_before_one_that_covers_more(short, monkeypatch):
    """The first frame's pose covers more, but a wing of it is doubted."""
    pose, frames = short
    stances = stances_of(pose)
    doubted = Judged(
        fit=replace(known(stances[0]), agreement=replace(NOTHING, overlap=np.full(3, 0.8))),
        doubts=("", "off", ""), missed=np.zeros(3),
    )  # fmt: skip
    sound = Judged(
        fit=replace(known(stances[6]), agreement=replace(NOTHING, overlap=np.full(3, 0.7))),
        doubts=("", "", ""), missed=np.zeros(3),
    )  # fmt: skip
    found = iter([doubted, sound])
    monkeypatch.setattr("flycontrol.vision.first_pose.acquire", lambda *args: next(found))
    assert first_pose(frames, CAMERAS, fit_shape(BARE), STROKE_PLANE).frame == 6


def test_a_recording_without_a_fly_is_refused(short):
    empty = tuple(np.zeros_like(mask) for mask in short[1][0])
    with pytest.raises(InvalidInputError, match="No fly was found"):
        track([empty] * 3, CAMERAS, FLY)
    assert len(track([], CAMERAS, FLY)) == 0


def test_sizes_of_a_fly_come_back():
    larger = resized(BARE, Sizes(body_length=1.08, body_radius=0.95, wing_length=0.93, wing_chord=1.06))
    some = turning_flight(1)[::12]
    X = some.coordinates.copy()
    X[:, 12:15], X[:, 15:18] = larger.right_base_B * [1, -1, 1], larger.right_base_B
    some = Pose(coordinates=X, stroke_plane_angle=STROKE_PLANE)
    seen = [
        (border_distance(views_of(masks, CAMERAS), 20), stance)
        for masks, stance in zip(drawn(some, shape=larger), stances_of(some), strict=True)
    ]
    sizes = fitted_sizes(BARE, seen).sizes
    assert sizes.body_length == pytest.approx(1.08, abs=0.02)
    assert sizes.body_radius == pytest.approx(0.95, abs=0.02)
    assert sizes.wing_length == pytest.approx(0.93, abs=0.02)
    assert sizes.wing_chord == pytest.approx(1.06, abs=0.02)


def test_the_hull_alone_is_followed_through_a_wingbeat_within_what_its_method_claims():
    """Under 5 deg, by the publication of Hull Reconstruction Motion Tracking; here in the median.

    Roll hangs on wing bases half a millimetre from the axis, and stroke on roll: 8 deg.
    """
    pose = turning_flight(1)
    found = followed(drawn(pose), pose, refine=False)
    away = np.abs(apart(found.pose, pose))
    assert np.mean(found.believed) > 0.9
    claimed = np.array([5, 5, 8, 8, 5, 5, 8, 5, 5]) * deg
    assert np.all(np.median(away[found.believed, 3:12], axis=0) < claimed)


@pytest.mark.slow
def test_the_hull_alone_holds_ten_wingbeats_of_a_turn_with_legs_without_a_swap():
    pose = turning_flight(10)
    found = track(drawn(pose), CAMERAS, FLY, refine=False)
    away = np.abs(apart(found.pose, pose))
    assert np.mean(found.believed) > 0.95
    assert np.all(np.median(away[:, 3:12], axis=0) < 5 * deg)
    within = away[found.believed, :12] < 2 * found.uncertainty[found.believed, :12]
    assert np.all(np.mean(within, axis=0) > 0.8)
    assert np.max(away[:, 6:8]) < 45 * deg  # the wings swapped would be that far from the truth, and for long


@pytest.mark.slow
def test_ten_wingbeats_of_a_turn_with_legs_are_tracked_without_a_hint_and_without_a_swap():
    pose = turning_flight(10)
    found = track(drawn(pose), CAMERAS, FLY)
    away = apart(found.pose, pose)
    assert found.status == ("tracked",) * len(pose)
    assert np.all(rms(away[:, 3:12]) < AIMS)
    assert np.max(np.abs(away[:, 6:8])) < 15 * deg  # a swap of wings would be some 20 deg and more here
    assert rms(away[:, :3]).max() < 0.5 / SCALE


def test_after_frames_without_sight_through_a_stroke_reversal_the_fly_is_found_as_it_is():
    pose = turning_flight(3)[62:86]
    frames = [
        (np.zeros_like(masks[0]), *masks[1:]) if 8 <= k < 14 else masks for k, masks in enumerate(drawn(pose))
    ]  # fmt: skip
    found = followed(frames, pose)
    assert found.status[14:] == ("tracked",) * 10
    away = apart(found.pose, pose)[14:]
    assert np.all(np.abs(away[:, 3:12]) < 3 * AIMS)


def test_two_views_are_said_to_leave_the_fly_open(short):
    pose, frames = short
    follower = Follower(cameras=CAMERAS[:2], fly=FLY, start=known(stances_of(pose[0])[0]), refine=True)
    found = follower.follow(frames[0][:2])
    assert found.status == "partial"
    assert "two views" in found.reason


@pytest.mark.slow
def test_a_fly_a_third_larger_than_the_one_given_is_found_and_sized():
    larger = resized(WITH_LEGS, Sizes(body_length=1.3, body_radius=1.3, wing_length=1.33, wing_chord=1.3))
    X = turning_flight(1)[::3].coordinates.copy()
    X[:, 12:15], X[:, 15:18] = larger.right_base_B * [1, -1, 1], larger.right_base_B
    pose = Pose(coordinates=X[:10], stroke_plane_angle=STROKE_PLANE)
    found = sized_fly([sighting_of(masks, CAMERAS) for masks in drawn(pose, shape=larger)], CAMERAS, FLY)
    assert found.sizes.body_length == pytest.approx(1.3, rel=0.03)
    assert found.sizes.wing_length == pytest.approx(1.33, rel=0.03)
    assert found.fly.shape.right_base_B == pytest.approx(larger.right_base_B, rel=0.06)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_flights_of_any_attitude_are_followed_and_wings_that_are_believed_are_seldom_wrong(seed):
    """Yaw and pitch never 2 deg off; of the wings that are believed fewer than one in fifty 20 deg off."""
    pose = any_flight(np.random.default_rng(seed), 60)
    found = track(drawn(pose), CAMERAS, FLY)
    away, believed = np.abs(apart(found.pose, pose)), found.believed
    assert np.mean(believed) > 0.8
    assert np.max(away[believed, 3:5]) < 2 * deg
    wings = np.stack([away[:, 6:9], away[:, 9:12]], axis=1)[believed]
    told = np.array([[not doubt for doubt in doubts[1:]] for doubts in found.doubts])[believed]
    assert np.mean(np.max(wings, axis=2)[told] > 20 * deg) < 0.02

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flycontrol.errors import InvalidParameterError
from flycontrol.model.morphology import pitch_rotation
from flycontrol.model.pose import COORDINATES, Pose, attitude_angles, mirrored, pose_of_axes
from flycontrol.model.stroke import wing_axes
from flycontrol.units import deg, mm

STROKE_PLANE = 50 * deg


def drawn_pose(seed, count=5):
    rng = np.random.default_rng(seed)
    X = rng.normal(size=(count, 18)) * mm
    X[:, 3] = rng.uniform(-np.pi, np.pi, count)
    X[:, 4] = rng.uniform(-1.5, 1.5, count)
    X[:, 5] = rng.uniform(-np.pi, np.pi, count)
    X[:, [6, 9]] = rng.uniform(-2, 2, (count, 2))
    X[:, [7, 10]] = rng.uniform(-1.5, 1.5, (count, 2))
    X[:, [8, 11]] = rng.uniform(-np.pi, np.pi, (count, 2))
    return Pose(coordinates=X, stroke_plane_angle=STROKE_PLANE)


seeds = st.integers(0, 2**32 - 1)


def level(**values):
    X = np.zeros((1, 18))
    for name, value in values.items():
        X[0, COORDINATES.index(name)] = value
    return Pose(coordinates=X, stroke_plane_angle=STROKE_PLANE)


def test_a_level_body_heads_along_x_with_its_right_side_at_minus_y_and_its_belly_down():
    np.testing.assert_allclose(level().body_axes_W[0], np.diag([1.0, -1.0, -1.0]), atol=1e-15)


def test_yaw_turns_right_pitch_lifts_the_nose_and_roll_lowers_the_right_side():
    forward = level(yaw=90 * deg).body_axes_W[0][:, 0]
    np.testing.assert_allclose(forward, [0, -1, 0], atol=1e-15)  # seen from above, -y is to the right of x
    assert level(pitch=30 * deg).body_axes_W[0][2, 0] == pytest.approx(0.5)
    assert level(roll=30 * deg).body_axes_W[0][2, 1] == pytest.approx(-0.5)


def test_wings_of_a_pose_are_those_of_the_stroke_turned_by_stroke_plane_and_body():
    pose = drawn_pose(1)
    for side in ("left", "right"):
        axes = wing_axes(pose.wing(side), side)
        turn = pose.body_axes_W @ pitch_rotation(-STROKE_PLANE)
        for column, vector in enumerate((axes.span, axes.chord, axes.normal)):
            np.testing.assert_allclose(
                pose.wing_axes_W(side)[:, :, column], np.einsum("nij,nj->ni", turn, vector), atol=1e-14
            )


def test_a_right_wing_at_midstroke_points_right_and_a_vertical_chord_points_out_of_the_stroke_plane():
    axes = level(right_pitch=90 * deg, left_pitch=90 * deg).wing_axes_W("right")[0]
    np.testing.assert_allclose(axes[:, 0], [0, -1, 0], atol=1e-15)  # world: y to the left
    # the stroke plane's upward normal, -z of S, lies in the body's plane of symmetry, pitched by the angle
    np.testing.assert_allclose(axes[:, 1], [np.sin(STROKE_PLANE), 0, np.cos(STROKE_PLANE)], atol=1e-15)
    left = level(right_pitch=90 * deg, left_pitch=90 * deg).wing_axes_W("left")[0]
    np.testing.assert_allclose(left, np.diag([1.0, -1.0, 1.0]) @ axes, atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert np.linalg.det(left) == pytest.approx(-1.0)


@given(seeds)
def test_coordinates_come_back_from_the_rotations_that_they_make(seed):
    pose = drawn_pose(seed)
    again = pose_of_axes(
        pose.position_W, pose.body_axes_W, (pose.wing_axes_W("left"), pose.wing_axes_W("right")),
        (pose.base_B("left"), pose.base_B("right")), STROKE_PLANE,
    )  # fmt: skip
    turns = np.round((again.coordinates - pose.coordinates) / (2 * np.pi))
    np.testing.assert_allclose(again.coordinates - 2 * np.pi * turns, pose.coordinates, atol=1e-12)


@given(seeds, st.sampled_from([-1.0, 1.0]))
def test_a_vertical_body_keeps_its_rotation_through_angles(seed, sign):
    X = drawn_pose(seed).coordinates.copy()
    X[:, 4] = sign * np.pi / 2
    axes = Pose(coordinates=X, stroke_plane_angle=STROKE_PLANE).body_axes_W
    X[:, 3:6] = attitude_angles(axes)
    np.testing.assert_allclose(Pose(coordinates=X, stroke_plane_angle=STROKE_PLANE).body_axes_W, axes, atol=1e-9)
    np.testing.assert_allclose(X[:, 5], 0, atol=1e-15)


@given(seeds)
def test_a_mirror_image_swaps_left_and_right_and_mirrors_every_axis(seed):
    pose, mirror = drawn_pose(seed), np.diag([1.0, -1.0, 1.0])
    image = mirrored(pose)
    np.testing.assert_allclose(image.position_W, pose.position_W @ mirror)
    np.testing.assert_allclose(image.body_axes_W, mirror @ pose.body_axes_W @ mirror, atol=1e-14)
    for side, other in (("left", "right"), ("right", "left")):
        np.testing.assert_allclose(image.wing_axes_W(side), mirror @ pose.wing_axes_W(other), atol=1e-14)
        np.testing.assert_allclose(image.base_W(side), pose.base_W(other) @ mirror, atol=1e-14)


def test_a_quaternion_turns_body_axes_into_the_world():
    pose = drawn_pose(3)
    w, x, y, z = pose.q_WB.T
    np.testing.assert_allclose(1 - 2 * (y * y + z * z), pose.body_axes_W[:, 0, 0], atol=1e-14)
    np.testing.assert_allclose(2 * (x * y + w * z), pose.body_axes_W[:, 1, 0], atol=1e-14)


def test_one_instant_of_many_is_a_pose_and_cannot_be_changed():
    pose = drawn_pose(4)
    assert len(pose[2]) == 1
    np.testing.assert_array_equal(pose[-1].coordinates, pose.coordinates[-1:])
    with pytest.raises(ValueError, match="read-only"):
        pose.coordinates[0, 0] = 1.0


def test_coordinates_of_another_shape_are_refused():
    with pytest.raises(InvalidParameterError, match=r"\(N, 18\)"):
        Pose(coordinates=np.zeros(18), stroke_plane_angle=STROKE_PLANE)
    with pytest.raises(InvalidParameterError, match="finite"):
        Pose(coordinates=np.zeros((1, 18)), stroke_plane_angle=np.nan)

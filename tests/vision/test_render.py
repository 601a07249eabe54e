import numpy as np
import pytest
from scipy.spatial import cKDTree

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.model.camera_forms import looking_at, orthogonal_cameras, orthographic_camera
from flycontrol.model.flapping_pose import flapping_pose
from flycontrol.model.planform import ChordTable, Planform
from flycontrol.model.pose import COORDINATES, Pose, mirrored
from flycontrol.model.stroke_kinematics import hover_stroke
from flycontrol.units import deg, mm, um
from flycontrol.vision.fly_shape import FlyShape, fly_shape
from flycontrol.vision.hull import Tolerance, visual_hull
from flycontrol.vision.mesh import placed
from flycontrol.vision.render import Imaging, degraded, render_frames, render_silhouettes, with_missing_patches

SCALE, SHAPE = 35 / mm, (220, 240)
PLANFORM = Planform(length=2.4 * mm, mean_chord=0.7 * mm, second_moment_radius=0.58)
FLY = fly_shape(PLANFORM)
WITH_LEGS = fly_shape(PLANFORM, legs=True)
CAMERAS = orthogonal_cameras(scale=SCALE, shape=SHAPE, distance=100 * mm)


def flying(count=4, shape=FLY, **kwargs):
    return flapping_pose(
        hover_stroke(), np.arange(count) / (count * 220), right_base_B=shape.right_base_B,
        stroke_plane_angle=50 * deg, **kwargs,
    )  # fmt: skip


def still(**values):
    X = np.zeros((1, 18))
    X[0, 12:15], X[0, 15:18] = FLY.right_base_B * [1, -1, 1], FLY.right_base_B
    for name, value in values.items():
        X[0, COORDINATES.index(name)] = value
    return Pose(coordinates=X, stroke_plane_angle=0.0)


def first(frames):
    return next(iter(frames))


def test_a_sphere_is_drawn_as_the_ellipse_that_its_tangent_cone_cuts():
    x = -np.cos(np.linspace(0, np.pi, 101)) * mm
    ball = FlyShape(
        profile=np.stack([x, np.sqrt(np.clip(mm**2 - x**2, 0, None))], 1),
        wing=np.array([[0, 0, 0], [1e-6, 0, 0.0]]), right_base_B=np.zeros(3),
    )  # fmt: skip
    camera = looking_at((0, 0, 0), (30 * mm, 10 * mm, 5 * mm), focal=1000, shape=SHAPE)
    pose = still(y=0.5 * mm, z=-0.3 * mm, yaw=0.3, pitch=0.2)
    image = first(render_silhouettes(ball, pose, [camera], parts=["body"]))[0]
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]].reshape(2, -1)
    rays = camera.rays(np.stack([u, v], 1).astype(float))
    along = np.sum((pose.position_W - rays.origin) * rays.direction, axis=1)
    miss = np.linalg.norm(rays.origin + along[:, None] * rays.direction - pose.position_W, axis=1).reshape(SHAPE)
    assert np.all(image[miss < 0.99 * mm])  # a 32-gon in the circle and 100 cones along it reach 0.995 of the radius
    assert not np.any(image[miss > mm])


def test_the_wing_has_the_area_of_its_planform():
    camera = orthographic_camera((0, 0, -1), scale=200 / mm, shape=(900, 900))
    for planform in (
        PLANFORM,
        Planform(
            length=2 * mm, mean_chord=0.6 * mm, second_moment_radius=0.58,
            table=ChordTable(span=(0.0, 0.3, 0.8, 1.0), chord=(0.2, 1.0, 0.9, 0.0)),
        ),
    ):  # fmt: skip
        shape = fly_shape(planform)
        pixels = first(render_silhouettes(shape, still(y=1.5 * mm), [camera], parts=["right"]))[0].sum()
        # 24 straight stations cut 0.3 % off the round outline
        assert pixels / (200 / mm) ** 2 == pytest.approx(planform.moment(1), rel=5e-3)


def test_a_body_lies_about_the_centre_of_its_volume():
    x, r = FLY.profile.T
    fine = np.linspace(x[0], x[-1], 20001)
    area = np.interp(fine, x, r) ** 2
    assert abs(np.sum(area * fine) / np.sum(area)) < 1e-3 * FLY.body_length
    assert FLY.body_length == pytest.approx(PLANFORM.length)
    assert FLY.body_volume == pytest.approx(np.pi * np.sum(area) * (fine[1] - fine[0]), rel=1e-3)


def test_leading_edges_point_along_the_chord_and_tips_along_the_span():
    pose = flying(3, attitude=(0.4, 0.7, -0.3))
    for side in ("left", "right"):
        axes, base = pose.wing_axes_W(side), pose.base_W(side)
        points = np.einsum("nvi,nij->nvj", placed(FLY, pose, side) - base[:, None], axes)
        np.testing.assert_allclose(points[:, :, 0].max(axis=1), PLANFORM.length, rtol=1e-12)
        np.testing.assert_allclose(points[:, :, 1].max(axis=1) * 3, -points[:, :, 1].min(axis=1), rtol=1e-9)
        np.testing.assert_allclose(np.abs(points[:, :, 2]), 15 * um, rtol=1e-9)


def test_a_mirror_image_of_a_pose_is_drawn_as_the_mirror_image():
    """Seen along x with y to the right; a camera with as many columns left as right of its axis."""
    camera = CAMERAS[0]
    for pose in flying(4, attitude=(0.3, 0.5, 0.2), position_W=(0, 0.2 * mm, 0)), flying(2, shape=WITH_LEGS):
        for a, b in zip(
            render_silhouettes(WITH_LEGS, pose, [camera]), render_silhouettes(WITH_LEGS, mirrored(pose), [camera]),
            strict=True,
        ):  # fmt: skip
            assert np.count_nonzero(a[0][:, ::-1] != b[0]) <= 4  # ties at borders of triangles


def test_a_fly_carried_along_with_its_cameras_looks_the_same():
    pose = flying(2)
    R, t = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([5.0, 1, 2]) * mm
    X = pose.coordinates.copy()
    X[:, :3] = X[:, :3] @ R.T + t
    X[:, 3] -= 90 * deg  # counter-clockwise from above is a turn to the left
    moved = Pose(coordinates=X, stroke_plane_angle=pose.stroke_plane_angle)
    for before, after in zip(
        render_silhouettes(FLY, pose, CAMERAS),
        render_silhouettes(FLY, moved, [camera.moved(R, t) for camera in CAMERAS]),
        strict=True,
    ):
        for a, b in zip(before, after, strict=True):
            assert np.count_nonzero(a != b) <= 2


def test_the_hull_of_drawn_silhouettes_contains_the_body_and_covers_them():
    pose = flying(3, attitude=(0.2, 45 * deg, 0.1))
    for k, masks in enumerate(render_silhouettes(FLY, pose, CAMERAS)):
        hull = visual_hull(masks, CAMERAS, 1 / SCALE, tolerance=Tolerance(slack=1.0, views=3))
        assert all(view.coverage > 0.99 for view in hull.views)
        lattice = np.floor(placed(FLY, pose[k], "body")[0] / hull.size).astype(int)
        away = cKDTree(hull.indices).query(lattice)[0]
        assert away.max() <= np.sqrt(3)  # a neighbour, across a corner at the most


def test_legs_add_pixels_and_parts_together_make_the_whole():
    pose = flying(1, shape=WITH_LEGS)
    whole = first(render_silhouettes(WITH_LEGS, pose, CAMERAS))
    parts = [
        first(render_silhouettes(WITH_LEGS, pose, CAMERAS, parts=[part])) for part in ("body", "left", "right", "legs")
    ]
    bare = first(render_silhouettes(FLY, pose, CAMERAS))
    for c in range(3):
        np.testing.assert_array_equal(whole[c], np.any([part[c] for part in parts], axis=0))
        assert whole[c].sum() > bare[c].sum()
        np.testing.assert_array_equal(whole[c] | bare[c], whole[c])


def test_blur_and_noise_leave_the_silhouette_where_it_was_to_a_pixel_or_so():
    pose = flying(2)
    clean = list(render_silhouettes(FLY, pose, CAMERAS, parts=["body"]))
    same = list(degraded(iter(clean), Imaging(), seed=1))
    np.testing.assert_array_equal(clean, same)
    blurred = np.array(list(degraded(iter(clean), Imaging(blur=1.0, noise=0.05), seed=1)))
    assert 0 < np.count_nonzero(blurred != clean) < 0.05 * np.count_nonzero(clean)


def test_missing_patches_take_their_share_and_nothing_outside():
    mask = first(render_silhouettes(FLY, flying(1), CAMERAS))[0]
    left = with_missing_patches(mask, Imaging(missing=0.1, patch=2.0), np.random.default_rng(1))
    assert not np.any(left & ~mask)
    share = 1 - left.sum() / mask.sum()
    assert 0.1 <= share <= 0.1 + 13 / mask.sum()  # the last patch has 13 pixels


def test_every_frame_has_its_own_noise_and_a_seed_repeats_it():
    pose = flying(1)[np.array([0, 0])]
    one, again, other = (
        [frames[0] for frames in render_frames(render_silhouettes(FLY, pose, CAMERAS[:1]), Imaging(noise=0.1), seed)]
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, again)
    assert np.any(one[0] != one[1])
    assert np.any(one[0] != other[0])


def test_what_cannot_be_drawn_is_refused_in_a_sentence():
    with pytest.raises(InvalidInputError, match="not in front of the camera"):
        first(render_silhouettes(FLY, still(x=200 * mm), CAMERAS))
    with pytest.raises(InvalidInputError, match="finite"):
        first(render_silhouettes(FLY, still(yaw=np.nan), CAMERAS))
    with pytest.raises(InvalidParameterError, match=r"missing share in 0\.\.1"):
        Imaging(missing=1.0)
    with pytest.raises(InvalidParameterError, match="rising first column"):
        FlyShape(profile=np.zeros((3, 2)), wing=FLY.wing, right_base_B=np.zeros(3))
    with pytest.raises(InvalidParameterError, match="leading edges"):
        FlyShape(profile=FLY.profile, wing=FLY.wing[:, [0, 2, 1]], right_base_B=np.zeros(3))
    with pytest.raises(InvalidParameterError, match="length > 0"):
        fly_shape(PLANFORM, body_length=-1.0)

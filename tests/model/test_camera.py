from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from flycontrol.errors import InvalidParameterError
from flycontrol.model.camera import Camera
from flycontrol.model.camera_forms import (
    OPENCV_PIXELS,
    Pinhole,
    PixelConvention,
    camera_from_dlt,
    camera_from_matrix,
    camera_from_pinhole,
    dlt_coefficients,
    facing_the_scene,
    looking_at,
    orthogonal_cameras,
    orthographic_camera,
    pinhole_of,
)
from flycontrol.model.distortion import Distortion
from flycontrol.units import mm

SHAPE = (480, 640)


@st.composite
def cameras(draw):
    """Projective cameras 50 to 200 mm away that look near the origin."""
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=3)
    place = direction / np.linalg.norm(direction) * rng.uniform(50, 200) * mm
    return looking_at(rng.normal(size=3) * mm, place, focal=rng.uniform(1000, 6000), shape=SHAPE)


def points_near_the_origin(count=20, seed=1):
    return np.random.default_rng(seed).uniform(-3 * mm, 3 * mm, (count, 3))


def test_a_pinhole_projects_by_similar_triangles():
    camera = looking_at((0, 0, 0), (0.1, 0, 0), focal=3500, shape=SHAPE)
    pixels = camera.project([[0, 0, 0], [0, 1 * mm, 0], [0, 0, 1 * mm], [0.05, 1 * mm, 0]])
    # it looks along -x with z up: world y points to the right; halfway it is twice as large
    expected = [[319.5, 239.5], [319.5 + 35, 239.5], [319.5, 239.5 - 35], [319.5 + 70, 239.5]]
    np.testing.assert_allclose(pixels, expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(camera.depth([[0.02, 5, 5]]), [0.08], rtol=1e-12)


def test_dlt_coefficients_project_as_their_formula_says_one_based_and_in_millimetres():
    L = np.array([32.0, 3.2, -39.7, -3.2, 38.4, 0.003, -1.5, -0.24, 2e-4, -1.2e-3, 1.7e-3])
    x, y, z = 1.3, -0.7, 2.1
    below = L[8] * x + L[9] * y + L[10] * z + 1
    u = (L[0] * x + L[1] * y + L[2] * z + L[3]) / below
    v = (L[4] * x + L[5] * y + L[6] * z + L[7]) / below
    seen = camera_from_dlt(L, SHAPE).project([[x * mm, y * mm, z * mm]])[0]
    np.testing.assert_allclose(seen, [u - 1, v - 1], rtol=0, atol=1e-9)
    from_below = camera_from_dlt(L, SHAPE, pixels=PixelConvention(from_below=True)).project([[x * mm, y * mm, z * mm]])
    np.testing.assert_allclose(from_below[0], [u - 1, 480 - v], rtol=0, atol=1e-9)


@given(cameras(), st.booleans(), st.sampled_from([0.0, 0.5, 1.0]), st.sampled_from([mm, 1.0, 25.4 * mm]))
def test_dlt_coefficients_give_back_the_camera_that_they_came_from(camera, from_below, first, unit):
    pixels = PixelConvention(first=first, from_below=from_below)
    again = camera_from_dlt(dlt_coefficients(camera, unit=unit, pixels=pixels), SHAPE, unit=unit, pixels=pixels)
    points = points_near_the_origin()
    np.testing.assert_allclose(again.project(points), camera.project(points), rtol=0, atol=1e-8)
    np.testing.assert_allclose(again.depth(points), camera.depth(points), rtol=1e-9)


@given(cameras())
def test_a_ray_of_a_pixel_passes_through_every_point_that_projects_there(camera):
    points = points_near_the_origin()
    rays = camera.rays(camera.project(points))
    away = points - rays.origin
    across = away - np.sum(away * rays.direction, axis=1, keepdims=True) * rays.direction
    assert np.max(np.abs(across)) < 1e-12  # [m], of scenes of 1e-2 m
    assert np.all(np.sum(away * rays.direction, axis=1) > 0)
    np.testing.assert_allclose(rays.origin, np.broadcast_to(camera.centre, (20, 3)), atol=1e-12)


@given(cameras())
def test_intrinsics_and_pose_compose_the_camera_that_they_were_taken_from(camera):
    pinhole = pinhole_of(camera)
    assert np.allclose(pinhole.rotation @ pinhole.rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(pinhole.rotation) > 0
    assert pinhole.intrinsic[0, 0] > 0
    assert pinhole.intrinsic[1, 1] > 0
    again = camera_from_pinhole(pinhole, SHAPE)
    np.testing.assert_allclose(again.matrix, camera.matrix, rtol=1e-9, atol=1e-9)


def test_mirrored_images_show_in_the_sign_of_a_focal_length():
    camera = looking_at((0, 0, 0), (0.1, 0.02, 0.03), focal=3500, shape=SHAPE)
    flip = np.diag([1.0, -1.0, 1.0]) + np.array([[0, 0, 0], [0, 0, 479.0], [0, 0, 0]])
    pinhole = pinhole_of(Camera(matrix=flip @ camera.matrix, shape=SHAPE))
    np.testing.assert_allclose(np.diag(pinhole.intrinsic), [3500, -3500, 1], rtol=1e-9)
    assert np.linalg.det(pinhole.rotation) == pytest.approx(1.0)


@given(cameras(), st.integers(0, 2**32 - 1))
def test_a_camera_carried_along_sees_a_moved_world_unchanged(camera, seed):
    rng = np.random.default_rng(seed)
    R, t = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix(), rng.normal(size=3) * mm
    points = points_near_the_origin()
    moved = camera.moved(R, t)
    np.testing.assert_allclose(moved.project(points @ R.T + t), camera.project(points), rtol=0, atol=1e-7)


def test_orthogonal_cameras_see_world_axes_at_their_scale_and_height_upwards():
    x, y, z = orthogonal_cameras(scale=35 / mm, shape=SHAPE)
    point = np.array([[1.0, 2.0, 3.0]]) * mm
    middle = np.array([319.5, 239.5])
    np.testing.assert_allclose(x.project(point)[0] - middle, [70, -105], atol=1e-9)  # y to the right, z up
    np.testing.assert_allclose(y.project(point)[0] - middle, [-35, -105], atol=1e-9)
    assert x.orthographic
    np.testing.assert_allclose(np.abs(z.project(point)[0] - middle), [70, 35], atol=1e-9)
    for camera, axis in zip((x, y, z), np.eye(3), strict=True):
        np.testing.assert_allclose(camera.direction, -axis, atol=1e-12)
        np.testing.assert_allclose(camera.pixels_per_metre(point), [35 / mm], rtol=1e-12)


def test_a_far_camera_approaches_the_orthographic_one():
    near_infinity = orthogonal_cameras(scale=35 / mm, shape=SHAPE, distance=1e4)
    points = points_near_the_origin()
    for far, flat in zip(near_infinity, orthogonal_cameras(scale=35 / mm, shape=SHAPE), strict=True):
        # relative error = depth range over distance = 3e-7 of at most 182 px
        np.testing.assert_allclose(far.project(points), flat.project(points), rtol=0, atol=1e-4)
        np.testing.assert_allclose(far.pixels_per_metre(points), flat.pixels_per_metre(points), rtol=1e-6)


def test_what_lies_behind_a_camera_has_no_pixel():
    camera = looking_at((0, 0, 0), (0.1, 0, 0), focal=3500, shape=SHAPE)
    assert np.all(np.isnan(camera.project([[0.2, 0, 0]])))
    assert camera.depth([[0.2, 0, 0]])[0] == pytest.approx(-0.1)


def test_a_matrix_of_the_wrong_sign_is_turned_to_face_what_all_cameras_look_at():
    views = orthogonal_cameras(scale=35 / mm, shape=SHAPE, distance=0.1, target=(0.3, 0.2, 0.4))
    wrong = [camera_from_matrix(-view.matrix, SHAPE, unit=1.0, pixels=OPENCV_PIXELS) for view in views]
    assert np.all(np.isnan(wrong[0].project([[0.3, 0.2, 0.4]])))
    for right, view in zip(facing_the_scene(wrong), views, strict=True):
        np.testing.assert_allclose(right.matrix, view.matrix, rtol=1e-12)


@given(
    st.tuples(*[st.floats(-0.2, 0.2)] * 3),
    st.tuples(*[st.floats(-0.01, 0.01)] * 2),
    st.integers(0, 2**32 - 1),
)
def test_taking_a_lens_out_inverts_putting_it_in(radial, tangential, seed):
    lens = Distortion(focal=(3500, 3400), centre=(320, 250), radial=radial, tangential=tangential)
    pixels = np.random.default_rng(seed).uniform(-0.5, 700, (50, 2))  # up to 0.2 of the focal length off the axis
    np.testing.assert_allclose(lens.undistorted(lens.distorted(pixels)), pixels, rtol=0, atol=1e-8)


def test_a_lens_moves_pixels_by_its_polynomial():
    lens = Distortion(focal=(1000, 1000), centre=(0, 0), radial=(0.1, 0, 0))
    np.testing.assert_allclose(lens.distorted(np.array([[300.0, 400.0]])), [[307.5, 410.0]])  # r = 0.5: 1 + 0.1 / 4
    bent = Distortion(focal=(1000, 1000), centre=(0, 0), tangential=(0.01, 0.02))
    # 2 p1 x y + p2 (r^2 + 2 x^2) = 0.0024 + 0.0086, 2 p2 x y + p1 (r^2 + 2 y^2) = 0.0048 + 0.0057
    np.testing.assert_allclose(bent.distorted(np.array([[300.0, 400.0]])), [[311.0, 410.5]])


def test_a_lens_that_folds_has_no_inverse_beyond_its_fold():
    lens = Distortion(focal=(1000, 1000), centre=(0, 0), radial=(-0.5, 0, 0))  # x - x^3 / 2 is at most 0.544
    assert np.all(np.isnan(lens.undistorted(np.array([[600.0, 0.0]]))))


def test_a_lens_is_on_the_camera_that_projects_and_sends_rays():
    lens = Distortion(focal=(3500, 3500), centre=(319.5, 239.5), radial=(0.3, 0, 0))
    plain = looking_at((0, 0, 0), (0.1, 0.05, 0), focal=3500, shape=SHAPE)
    camera = Camera(matrix=plain.matrix, shape=SHAPE, distortion=lens)
    points = points_near_the_origin()
    np.testing.assert_allclose(camera.project(points), lens.distorted(plain.project(points)))
    assert np.max(np.abs(camera.project(points) - plain.project(points))) > 0.01
    np.testing.assert_allclose(
        camera.rays(camera.project(points)).direction, plain.rays(plain.project(points)).direction
    )
    np.testing.assert_allclose(camera.ideal.project(points), plain.project(points))


def test_a_camera_cannot_be_changed():
    given_matrix = looking_at((0, 0, 0), (0.1, 0, 0), focal=3500, shape=SHAPE).matrix.copy()
    camera = Camera(matrix=given_matrix, shape=SHAPE)
    given_matrix[:] = 0
    np.testing.assert_allclose(camera.project([[0, 0, 0]]), [[319.5, 239.5]], atol=1e-9)
    with pytest.raises(ValueError, match="read-only"):
        camera.matrix[0, 0] = 1
    with pytest.raises(FrozenInstanceError):
        camera.shape = (1, 1)


@pytest.mark.parametrize(
    ("matrix", "sentence"),
    [
        (np.zeros((3, 4)), "singular"),
        (np.ones((3, 4)), "singular"),
        (np.vstack([np.eye(4)[:2], np.eye(4)[0] + np.eye(4)[3]]), "singular"),
        (np.vstack([np.eye(4)[0], np.eye(4)[0], np.eye(4)[3]]), "singular"),
        (np.vstack([np.eye(4)[:2], np.zeros(4)]), "singular"),
        (np.eye(3), r"must be \(3, 4\)"),
        (np.full((3, 4), np.nan), "finite"),
    ],
)
def test_a_camera_that_sees_no_area_is_refused(matrix, sentence):
    with pytest.raises(InvalidParameterError, match=sentence):
        Camera(matrix=matrix, shape=SHAPE)


def test_wrong_shapes_and_impossible_questions_are_refused_in_a_sentence():
    with pytest.raises(InvalidParameterError, match="11 coefficients"):
        camera_from_dlt(np.ones(12), SHAPE)
    with pytest.raises(InvalidParameterError, match="rows and columns"):
        Camera(matrix=np.eye(3, 4), shape=(0, 5))
    flat = orthographic_camera((0, 0, -1), scale=35 / mm, shape=SHAPE)
    with pytest.raises(InvalidParameterError, match="no centre"):
        _ = flat.centre
    with pytest.raises(InvalidParameterError, match="no focal length"):
        pinhole_of(flat)
    with pytest.raises(InvalidParameterError, match=r"\(N, 3\)"):
        flat.project([0.0, 0.0, 0.0])
    with pytest.raises(InvalidParameterError, match="orthogonal"):
        flat.moved(2 * np.eye(3))
    at_origin = camera_from_pinhole(Pinhole(intrinsic=np.eye(3), rotation=np.eye(3), translation=np.zeros(3)), SHAPE)
    with pytest.raises(InvalidParameterError, match="move the origin"):
        dlt_coefficients(at_origin)

from itertools import pairwise

import numpy as np
import pytest
from hull_scenes import (
    SCALE,
    SHAPE,
    SIZE,
    blobs,
    brute_force,
    cameras_around,
    ellipsoid,
    same,
    silhouette_of_ellipsoid,
    within,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from real_silhouettes import real_views

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.model.camera import Camera
from flycontrol.model.camera_forms import looking_at, orthogonal_cameras, orthographic_camera
from flycontrol.model.distortion import Distortion
from flycontrol.units import mm
from flycontrol.vision.box import Box, box_of_views
from flycontrol.vision.hull import Tolerance, footprint, visual_hull
from flycontrol.vision.views import views_of

seeds = st.integers(0, 2**32 - 1)
WIDE = Box(low=(-31, -25, -27), high=(30, 31, 25))


def tolerances():
    return st.builds(Tolerance, slack=st.sampled_from([0.0, 1.0, 2.5, 6.0]), views=st.integers(0, 3))


@settings(max_examples=6)
@given(seeds, tolerances(), st.integers(2, 4))
def test_carving_coarse_to_fine_equals_looking_at_every_voxel(seed, tolerance, count):
    cameras = cameras_around(seed, count)
    masks = [blobs(seed + k) for k in range(count)]
    hull = visual_hull(masks, cameras, 2.6 * SIZE, tolerance=tolerance, box=WIDE)
    expected = brute_force(masks, cameras, 2.6 * SIZE, WIDE, tolerance.slack, tolerance.views)
    assert len(hull) == len(expected)
    assert same(hull.indices, expected)


@settings(max_examples=4)
@given(seeds, st.sampled_from([Tolerance(), Tolerance(slack=2.0, views=3), Tolerance(slack=2.0, views=1)]))
def test_cameras_along_the_lattice_give_the_same_hull_on_their_fast_way(seed, tolerance):
    rng = np.random.default_rng(seed)
    target = rng.uniform(-0.3, 0.3, 3) * mm
    cameras = orthogonal_cameras(scale=SCALE, shape=SHAPE, target=target)
    masks = [blobs(seed + k) for k in range(3)]
    size = rng.uniform(1.6, 3.0) * SIZE
    hull = visual_hull(masks, cameras, size, tolerance=tolerance, box=WIDE)
    expected = brute_force(masks, cameras, size, WIDE, tolerance.slack, tolerance.views)
    assert len(hull) == len(expected)
    assert same(hull.indices, expected)


@settings(max_examples=5)
@given(seeds, st.integers(2, 4), st.sampled_from([0.0, 3.0]))
def test_the_box_found_from_the_silhouettes_holds_the_whole_hull(seed, count, slack):
    cameras, (A, centre) = cameras_around(seed, count), ellipsoid(seed)
    masks = [silhouette_of_ellipsoid(camera, A, centre) for camera in cameras]
    tolerance = Tolerance(slack=slack, views=count)
    hull = visual_hull(masks, cameras, 2 * SIZE, tolerance=tolerance)
    everywhere = visual_hull(masks, cameras, 2 * SIZE, tolerance=tolerance, box=Box(low=(-60,) * 3, high=(60,) * 3))
    assert same(hull.indices, everywhere.indices)


@settings(max_examples=5)
@given(seeds)
def test_the_hull_contains_the_object_to_within_a_pixel_at_its_outline(seed):
    """A point of the object may project onto the silhouette's rim, the nearest pixel of which is off it: slack 1."""
    cameras, (A, centre) = cameras_around(seed), ellipsoid(seed)
    masks = [silhouette_of_ellipsoid(camera, A, centre) for camera in cameras]
    hull = visual_hull(masks, cameras, 2 * SIZE, tolerance=Tolerance(slack=1.0, views=3))
    grid = np.stack(np.meshgrid(*[np.arange(-30, 30)] * 3, indexing="ij"), -1).reshape(-1, 3)
    away = (grid + 0.5) * 2 * SIZE - centre
    inside = grid[np.einsum("ni,ij,nj->n", away, A, away) <= 1]
    assert within(inside, hull.indices)


@settings(max_examples=6)
@given(seeds, tolerances())
def test_adding_a_camera_never_enlarges_the_hull(seed, tolerance):
    cameras = cameras_around(seed, 4)
    masks = [blobs(seed + k) for k in range(4)]
    strict = Tolerance(slack=tolerance.slack, views=4 if tolerance.views == 3 else 0)
    three = visual_hull(masks[:3], cameras[:3], 3 * SIZE, tolerance=strict, box=WIDE)
    four = visual_hull(masks, cameras, 3 * SIZE, tolerance=strict, box=WIDE)
    assert within(four.indices, three.indices)


def test_a_box_seen_along_its_edges_comes_back_to_within_a_voxel():
    """A brick is its own hull from three orthogonal sides."""
    cameras = orthogonal_cameras(scale=SCALE, shape=SHAPE)
    low, high = np.array([-1.11, -0.73, -0.51]) * mm, np.array([0.92, 1.04, 0.77]) * mm
    masks = []
    for camera in cameras:
        v, u = np.mgrid[: SHAPE[0], : SHAPE[1]]
        points = camera.rays(np.stack([u.ravel(), v.ravel()], 1).astype(float)).origin
        across = np.abs(camera.direction) < 0.5
        masks.append(np.all(((points > low) & (points < high))[:, across], axis=1).reshape(SHAPE))
    hull = visual_hull(masks, cameras, SIZE)
    reach = np.stack([hull.centres.min(axis=0) - SIZE / 2, hull.centres.max(axis=0) + SIZE / 2])
    assert np.max(np.abs(reach - [low, high])) <= SIZE
    assert len(hull) == np.prod(np.ptp(hull.indices, axis=0) + 1)  # and it is solid


@settings(max_examples=2)
@given(seeds)
def test_a_convex_body_seen_by_many_cameras_comes_back_to_within_a_voxel_or_two(seed):
    """Between tangent cones of 40 directions the hull of an ellipsoid stands out by d^2 / 8 r, d about 0.6 rad."""
    cameras, (A, centre) = cameras_around(seed, 40), ellipsoid(seed)
    masks = [silhouette_of_ellipsoid(camera, A, centre) for camera in cameras]
    hull = visual_hull(masks, cameras, SIZE)
    away = hull.centres - centre
    excess = np.sqrt(np.einsum("ni,ij,nj->n", away, A, away))
    radius = np.linalg.norm(away, axis=1)
    assert np.max(radius - radius / excess) < 0.1 * mm  # 0.6^2 / 8 of at most 1.2 mm, and a pixel's diagonal
    assert np.mean((radius - radius / excess) > SIZE) < 0.1
    assert hull.volume == pytest.approx(4 / 3 * np.pi / np.sqrt(np.linalg.det(A)), rel=0.1)


@settings(max_examples=6)
@given(seeds, st.permutations([0, 1, 2]), st.tuples(*[st.sampled_from([-1, 1])] * 3), st.integers(-50, 50))
def test_a_motion_or_mirror_image_of_the_lattice_moves_the_hull_and_changes_nothing_else(seed, order, signs, shift):
    cameras = cameras_around(seed)
    masks = [blobs(seed + k) for k in range(3)]
    R = np.diag(signs).astype(float)[list(order)]
    steps = np.array([shift, 2 * shift, -shift])
    hull = visual_hull(masks, cameras, 2 * SIZE)
    moved = visual_hull(masks, [camera.moved(R, steps * 2 * SIZE) for camera in cameras], 2 * SIZE)
    expected = np.rint((hull.indices + 0.5) @ R.T + steps - 0.5).astype(int)
    assert same(moved.indices, expected)
    assert moved.views == hull.views


def test_a_rigid_motion_keeps_volume_and_carries_the_centroid_along():
    (A, centre), cameras = ellipsoid(5), cameras_around(5)
    masks = [silhouette_of_ellipsoid(camera, A, centre) for camera in cameras]
    hull = visual_hull(masks, cameras, SIZE)
    rng = np.random.default_rng(1)
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    t = np.array([3.0, -7.0, 11.0]) * mm
    moved = visual_hull(masks, [camera.moved(R, t) for camera in cameras], SIZE)
    assert moved.volume == pytest.approx(hull.volume, rel=0.01)  # another lattice counts the surface differently
    np.testing.assert_allclose(moved.centres.mean(axis=0), R @ hull.centres.mean(axis=0) + t, atol=0.1 * SIZE)


def test_a_hole_in_one_view_bores_through_the_hull_unless_the_tolerance_forgives_it():
    (A, centre), cameras = ellipsoid(2), cameras_around(2)
    masks = [silhouette_of_ellipsoid(camera, A, centre) for camera in cameras]
    whole = visual_hull(masks, cameras, SIZE)
    u, v = np.rint(cameras[0].project(centre[None])[0]).astype(int)
    masks[0][v - 2 : v + 3, u - 2 : u + 3] = False
    bored = visual_hull(masks, cameras, SIZE)
    forgiven = visual_hull(masks, cameras, SIZE, tolerance=Tolerance(slack=3.0, views=1))
    assert len(bored) < len(whole)
    assert bored.views[1].uncovered == 0  # a hole of one view hides behind the rest of the body in the others
    assert within(whole.indices, forgiven.indices)
    assert forgiven.views[0].beyond >= 25


def test_silhouettes_of_two_bodies_in_different_places_leave_pixels_uncovered():
    cameras = cameras_around(3)
    A, centre = ellipsoid(3)
    masks = [silhouette_of_ellipsoid(camera, A, centre) for camera in cameras]
    assert all(view.uncovered <= 0.02 * view.covered for view in visual_hull(masks, cameras, SIZE).views)
    masks[2] = np.roll(masks[2], 25, axis=1)
    assert max(view.uncovered / view.covered for view in visual_hull(masks, cameras, SIZE).views) > 0.1


def test_silhouettes_that_never_meet_give_an_empty_hull_that_covers_nothing():
    cameras = orthogonal_cameras(scale=SCALE, shape=SHAPE)
    masks = np.zeros((3, *SHAPE), bool)
    masks[0, 20:30, 100:120] = masks[1, 150:160, 100:120] = masks[2, 90:110, 100:120] = True  # heights do not meet
    hull = visual_hull(masks, cameras, SIZE)
    assert len(hull) == 0
    assert [view.covered for view in hull.views] == [0, 0, 0]


def test_a_lens_is_taken_out_of_the_silhouettes_before_carving():
    (A, centre), plain = ellipsoid(4), cameras_around(4)
    lens = Distortion(focal=(3500, 3500), centre=(119.5, 99.5), radial=(300.0, 0, 0))  # 1.6 px at 40 px
    bent = [Camera(matrix=c.matrix, shape=c.shape, name=c.name, distortion=lens) for c in plain]
    straight = visual_hull([silhouette_of_ellipsoid(c, A, centre) for c in plain], plain, SIZE)
    hull = visual_hull([silhouette_of_ellipsoid(c, A, centre) for c in bent], bent, SIZE)
    assert hull.volume == pytest.approx(straight.volume, rel=0.02)  # two roundings to pixels of a rim
    ignored = visual_hull([silhouette_of_ellipsoid(c, A, centre) for c in bent], plain, SIZE)
    assert ignored.volume > 1.05 * straight.volume


def test_a_footprint_covers_the_pixels_of_a_voxel():
    camera = orthographic_camera((0, 0, -1), scale=10 / mm, shape=(50, 50))
    image = footprint(np.array([[0, 0, 0]], np.int32), 1 * mm, camera)  # 10 pixels wide
    assert image.sum() == 100
    tiny = footprint(np.array([[0, 0, 0]], np.int32), 0.01 * mm, camera)
    assert tiny.sum() == 1


def test_an_animal_at_the_border_of_an_image_is_told():
    cameras = orthogonal_cameras(scale=SCALE, shape=SHAPE)
    masks = np.zeros((3, *SHAPE), bool)
    masks[:, 90:110, 100:120] = True
    masks[1, 90:110, 100:] = True
    assert [view.touches_edge for view in visual_hull(masks, cameras, SIZE).views] == [False, True, False]


def test_images_that_do_not_fit_the_cameras_are_refused_in_a_sentence():
    cameras = cameras_around(1)
    masks = np.ones((3, *SHAPE), bool)
    with pytest.raises(InvalidInputError, match="got 2 images and 3 cameras"):
        visual_hull(masks[:2], cameras, SIZE)
    with pytest.raises(
        InvalidInputError, match="camera 2: a boolean silhouette of 200 x 240 pixels was needed, got bool of 20"
    ):
        visual_hull([masks[0], masks[1, :20], masks[2]], cameras, SIZE)
    with pytest.raises(InvalidInputError, match="got uint8"):
        visual_hull(masks.astype(np.uint8), cameras, SIZE)
    masks[1] = False
    with pytest.raises(InvalidInputError, match="the silhouette of camera 2 is empty"):
        visual_hull(masks, cameras, SIZE)
    masks[2] = False
    with pytest.raises(InvalidInputError, match="the silhouettes of camera 2 and camera 3 are empty"):
        visual_hull(masks, cameras, SIZE)


def test_views_that_do_not_enclose_the_animal_are_refused():
    camera = looking_at((0, 0, 0), (0.1, 0, 0), focal=3500, shape=SHAPE)
    beside = looking_at((0, 0, 0), (0.1, 1e-5, 0), focal=3500, shape=SHAPE)
    mask = np.zeros(SHAPE, bool)
    mask[80:120, 100:140] = True
    for cameras in ([camera], [camera, beside], orthogonal_cameras(scale=SCALE, shape=SHAPE)[:1]):
        with pytest.raises(InvalidInputError, match="do not enclose"):
            box_of_views(views_of([mask] * len(cameras), cameras), SIZE)


def test_sizes_and_tolerances_that_nothing_has_are_refused():
    cameras, masks = cameras_around(1), np.ones((3, *SHAPE), bool)
    for size in (0.0, -1.0, np.nan):
        with pytest.raises(InvalidParameterError, match="size must be finite and > 0"):
            visual_hull(masks, cameras, size)
    with pytest.raises(InvalidParameterError, match="too large"):
        visual_hull(masks, cameras, 1e-8)
    with pytest.raises(InvalidParameterError, match=">= 0"):
        Tolerance(slack=-1.0)


def test_real_silhouettes_are_covered_by_their_hull_but_for_the_rim_that_calibration_leaves_open(real_data):
    """Views 0.7 to 2 px apart across 100 px of outline are 70 to 200 of some 6,000 pixels; what one lost, 3 px heal."""
    frames, cameras = real_views(real_data, 12)
    for masks in frames:
        exact = visual_hull(masks, cameras, SIZE)
        healed = visual_hull(masks, cameras, SIZE, tolerance=Tolerance(slack=3.0, views=1))
        assert all(view.coverage > 0.97 for view in exact.views)
        assert all(view.coverage > 0.99 for view in healed.views)
        assert not any(view.touches_edge for view in exact.views)


def test_more_tolerance_never_shrinks_the_hull_of_real_silhouettes(real_data):
    frames, cameras = real_views(real_data, 24)
    steps = [Tolerance(), *(Tolerance(slack=slack, views=views) for slack, views in ((1, 1), (2, 1), (2, 2), (2, 3)))]
    for masks in frames:
        hulls = [visual_hull(masks, cameras, SIZE, tolerance=tolerance) for tolerance in steps]
        for less, more in pairwise(hulls):
            assert within(less.indices, more.indices)
            assert len(more) > len(less)
            assert all(a.covered <= b.covered for a, b in zip(less.views, more.views, strict=True))

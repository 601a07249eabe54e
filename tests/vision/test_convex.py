import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from flycontrol.vision.kernels.convex import corners

seeds = st.integers(0, 2**32 - 1)


def area(points):
    x, y = points.T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


@settings(max_examples=30)
@given(seeds, st.integers(3, 500))
def test_of_scattered_points_the_corners_are_those_of_qhull(seed, count):
    points = np.random.default_rng(seed).normal(size=(count, 2))
    assert set(corners(points)) == set(ConvexHull(points).vertices)


@settings(max_examples=30)
@given(seeds)
def test_of_a_section_through_a_lattice_many_of_whose_points_lie_on_lines_nothing_is_cut_off(seed):
    """Rounding may leave points on a side among the corners; the polygon is the same."""
    rng = np.random.default_rng(seed)
    lattice = np.stack(np.meshgrid(*[np.arange(8.0)] * 3), axis=-1).reshape(-1, 3)
    points = np.ascontiguousarray((lattice @ np.linalg.qr(rng.normal(size=(3, 3)))[0])[:, :2])
    found = points[corners(points)]
    assert abs(area(found) - ConvexHull(points).volume) < 1e-12 * area(found)
    assert len(found) < 60


def test_points_on_a_line_have_two_corners_and_one_point_has_one():
    assert set(corners(np.outer(np.arange(9.0), [1.0, 2.0]))) == {0, 8}
    assert list(corners(np.zeros((1, 2)))) == [0]

from dataclasses import replace

import numpy as np
import pytest
from filmed_flights import BARE
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from flycontrol.units import mm, um
from flycontrol.vision.dissection import BODY, LEFT, REST, RIGHT, dissect
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.hull import VisualHull
from flycontrol.vision.kernels.section import section
from flycontrol.vision.reading.moments import moments_of_points
from flycontrol.vision.stance import Stance

seeds = st.integers(0, 2**32 - 1)
SIZE, REACH = 43 * um, 0.1 * BARE.wing[-1, 0]


def anywhere(rng):
    """A stance with body and wings turned at random, and voxels about it."""
    R, *wings = Rotation.random(3, rng=rng).as_matrix()
    bases = fit_shape(BARE).bases_B + rng.normal(0, 0.1 * mm, (2, 3))
    wings = np.stack([wings[0] * [1, 1, -1], wings[1]])
    stance = Stance(position_W=rng.normal(0, 3 * mm, 3), body_axes_W=R, wings_B=wings, bases_B=bases)
    indices = stance.position_W / SIZE + rng.normal(0, 25, (4000, 3))
    return stance, VisualHull(indices=np.unique(indices.astype(np.int32), axis=0), size=SIZE, views=())


def plain_distances(points, stance, shape):
    """(3, N) from body, left and right wing, point by point as the words have it."""
    in_B = (points - stance.position_W) @ stance.body_axes_W
    x, r = shape.profile.T
    along = np.clip(in_B[:, 0], x[0], x[-1])
    beside = np.hypot(in_B[:, 1], in_B[:, 2]) - np.interp(along, x, r)
    beyond = np.abs(in_B[:, 0] - along)
    rows = [np.where(beyond > 0, np.hypot(np.maximum(beside, 0), beyond), beside)]
    span, leading, trailing = shape.wing.T
    for base, axes in zip(stance.bases_B, stance.wings_B, strict=True):
        s, c, n = ((in_B - base) @ axes).T
        on = np.clip(s, span[0], span[-1])
        over = np.clip(c, np.interp(on, span, trailing), np.interp(on, span, leading))
        rows.append(np.sqrt((s - on) ** 2 + (c - over) ** 2 + n**2))
    return np.array(rows)


@settings(max_examples=20)
@given(seeds)
def test_a_voxel_belongs_to_the_part_nearest_to_its_centre_and_beyond_its_reach_to_none(seed):
    stance, hull = anywhere(np.random.default_rng(seed))
    away = plain_distances(hull.centres, stance, BARE)
    first, second = np.sort(away, axis=0)[:2]
    expected = np.where(first <= REACH, np.argmin(away, axis=0) + 1, REST)
    clear = (second - first > 1e-12) & (np.abs(first - REACH) > 1e-12)  # [m]; at a tie rounding decides
    found = dissect(hull, stance, BARE).labels
    assert np.mean(clear) > 0.99
    assert np.array_equal(found[clear], expected[clear])
    assert set(expected) == {REST, BODY, LEFT, RIGHT}


@settings(max_examples=5)
@given(seeds, st.sampled_from([0.0, 10.0]))
def test_middle_and_scatter_of_voxels_are_those_of_their_centres_however_far_from_the_origin(seed, offset):
    stance, hull = anywhere(np.random.default_rng(seed))
    far = np.int32(offset / SIZE)
    stance, hull = replace(stance, position_W=stance.position_W + far * SIZE), replace(hull, indices=hull.indices + far)
    parts = dissect(hull, stance, BARE)
    for label in (BODY, LEFT, RIGHT):
        found, centres = parts.moments(label), parts.part(label)
        assert np.array_equal(centres, hull.centres[parts.labels == label])
        plain = moments_of_points(centres)
        np.testing.assert_allclose(found.middle, plain.middle, rtol=0, atol=1e-15 + 1e-13 * offset)
        np.testing.assert_allclose(found.scatter, plain.scatter, rtol=0, atol=1e-9 * np.trace(plain.scatter))


def test_the_long_axis_is_that_of_the_largest_spread():
    rng = np.random.default_rng(3)
    R = Rotation.random(rng=rng).as_matrix()
    points = rng.normal(size=(20000, 3)) * [3.0, 1.0, 1.0] @ R.T
    assert abs(moments_of_points(points).long_axis @ R[:, 0]) == pytest.approx(1, abs=1e-3)


@settings(max_examples=5)
@given(seeds)
def test_the_outer_voxels_of_a_part_are_those_beyond_a_plane_across_its_span(seed):
    stance, hull = anywhere(np.random.default_rng(seed))
    parts = dissect(hull, stance, BARE)
    for side, label in enumerate((LEFT, RIGHT)):
        base, span = stance.base_W(side), stance.wing_axes_W(side)[:, 0].copy()
        away = parts.part(label) - base
        found = parts.beyond(label, base, span, 0.5 * mm)
        np.testing.assert_allclose(found, away[away @ span > 0.5 * mm], rtol=0, atol=1e-15)


def test_a_section_holds_the_points_near_its_plane_as_they_lie_in_it():
    rng = np.random.default_rng(5)
    points, middle = rng.normal(size=(500, 3)), rng.normal(size=3)
    along, first, second = Rotation.random(rng=rng).as_matrix()
    away = points - middle
    plain = away[np.abs(away @ along) < 0.3] @ np.stack([first, second], axis=1)
    np.testing.assert_allclose(section(points, middle, along, 0.3, first, second), plain, rtol=0, atol=1e-14)

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from flycontrol.errors import InvalidInputError
from flycontrol.model.wing_outline import outline_shape

RECTANGLE = np.array([[-0.1, 0.0], [0.2, 0.0], [0.2, 1.0], [-0.1, 1.0]])


def ellipse(count, chord=0.3):
    turn = 2 * np.pi * np.arange(count) / count
    return np.stack([chord / 2 * np.cos(turn), (1 + np.sin(turn)) / 2], axis=1)


def moments(corners):
    """Area, and the integrals of y and y^2 over it, by Green's theorem."""
    (x0, y0), (x1, y1) = corners.T, np.roll(corners, -1, axis=0).T
    cross = x0 * y1 - x1 * y0
    area = np.sum(cross) / 2
    return np.abs([area, np.sum(cross * (y0 + y1)) / 6, np.sum(cross * (y0**2 + y0 * y1 + y1**2)) / 12])


@st.composite
def stars(draw):
    """Corners at rising angles about a point inside: simple, and hardly ever convex."""
    radius = np.array(draw(st.lists(st.floats(0.05, 0.5), min_size=5, max_size=30)))
    turn = 2 * np.pi * np.arange(len(radius)) / len(radius)
    return np.stack([radius * np.cos(turn), 0.5 + radius * np.sin(turn)], axis=1)


@given(stars())
def test_area_and_moments_of_an_outline_are_those_of_green(corners):
    """Strips narrower than 1e-12 are joined, so 1e-10 of the moments."""
    found, (area, first, second) = outline_shape(corners), moments(corners)
    tip = corners[:, 1].max()
    assert found.mean_chord == pytest.approx(area / tip**2, rel=1e-10)
    assert found.first_moment_radius == pytest.approx(first / area / tip, rel=1e-10)
    assert found.second_moment_radius == pytest.approx(np.sqrt(second / area) / tip, rel=1e-10)


@given(stars(), st.integers(0, 29), st.booleans(), st.floats(-1, 1), st.floats(0.1, 10))
def test_it_matters_neither_where_an_outline_starts_nor_which_way_it_goes_nor_in_which_unit(
    corners, start, back, shift, unit
):
    again = np.roll(corners, start % len(corners), axis=0)[:: -1 if back else 1] * unit + [shift, 0.0]
    found, other = outline_shape(corners), outline_shape(np.vstack([again, again[:1]]))
    assert other.mean_chord == pytest.approx(found.mean_chord, rel=1e-10)
    assert other.second_moment_radius == pytest.approx(found.second_moment_radius, rel=1e-10)


def test_a_rectangle_has_one_chord_from_hinge_to_tip():
    found = outline_shape(RECTANGLE)
    assert (found.table.span, found.table.chord) == ((0.0, 1.0), pytest.approx((0.3, 0.3), rel=1e-15))
    assert found.second_moment_radius == pytest.approx(np.sqrt(1 / 3), rel=1e-14)
    assert found.largest_chord == pytest.approx(1.0, rel=1e-14)


def test_a_wing_on_a_stalk_has_no_chord_inboard_of_it():
    found = outline_shape(RECTANGLE * [1.0, 0.75] + [0.0, 0.25])
    assert found.mean_chord == pytest.approx(0.3 * 0.75, rel=1e-11)
    assert np.interp([0.1, 0.24], found.table.span, found.table.chord) == pytest.approx([0.0, 0.0], abs=1e-15)
    assert found.first_moment_radius == pytest.approx(0.625, rel=1e-11)


def test_an_ellipse_is_ellingtons_beta_distribution():
    """p = q = 3/2 at r1 = 1/2, where his regression of r2 on r1 errs by 5e-4, and so p by 1e-2."""
    found = outline_shape(ellipse(720))
    assert found.mean_chord == pytest.approx(np.pi * 0.3 / 4, rel=2e-5)  # an inscribed polygon: (2 pi / N)^2 / 6
    assert found.second_moment_radius == pytest.approx(np.sqrt(5) / 4, rel=2e-5)
    assert found.beta_difference() < 1e-2
    assert outline_shape(RECTANGLE).beta_difference() > 0.05


@given(st.integers(5, 12), st.data())
def test_corners_of_a_convex_outline_in_another_order_are_refused(count, data):
    """Only the cyclic orders of a convex polygon's corners cross nowhere."""
    order = data.draw(st.permutations(range(count)))
    steps = {(b - a) % count for a, b in zip(order, [*order[1:], order[0]], strict=True)}
    assume(steps not in ({1}, {count - 1}))
    corners = ellipse(count)
    with pytest.raises(InvalidInputError, match=r"must not cross itself|must be closed"):
        outline_shape(corners[order])


@pytest.mark.parametrize(
    ("points", "said"),
    [
        (RECTANGLE[[0, 2, 1, 3]], "edges after points 1 and 3 meet"),
        (
            ellipse(100)[25:75],
            "must be closed, and from the last point of this one to its first there is a gap of 0.999",
        ),
        (np.vstack([RECTANGLE, RECTANGLE[1]]), "point 2, 0.2, 0, stands there again"),
        (RECTANGLE[:2], "3 to 4000 different points, got 2"),
        (RECTANGLE - [0.0, 0.1], "at span positions >= 0, and this one reaches from -0.1 to 0.9"),
        (RECTANGLE * [1.0, 0.0], "stands there again"),
        (RECTANGLE * np.nan, "finite numbers"),
        (RECTANGLE[:, :1], "points (N, 2)"),
        (np.array([[0.0, 0.0], [0.1, 1.0], [0.0, 2.0], [0.0, 1.0], [0.1, 0.5]]), "must not cross itself"),
    ],
)
def test_points_that_are_no_outline_are_refused_in_one_sentence(points, said):
    with pytest.raises(InvalidInputError) as error:
        outline_shape(points)
    assert said in str(error.value)


grid = st.tuples(st.integers(0, 4), st.integers(0, 4))


@given(st.lists(grid, min_size=3, max_size=8))
def test_points_of_a_grid_are_an_outline_with_the_area_of_green_or_refused(points):
    """Corners on edges, edges along the chord, spikes: what a coarse drawing has."""
    corners = np.array(points, dtype=float)
    try:
        found = outline_shape(corners)
    except InvalidInputError:
        return
    unique = corners[:-1] if np.array_equal(corners[0], corners[-1]) else corners
    area, first, _ = moments(unique)
    tip = unique[:, 1].max()
    assert found.mean_chord == pytest.approx(area / tip**2, rel=1e-10)
    assert found.first_moment_radius == pytest.approx(first / area / tip, rel=1e-10)

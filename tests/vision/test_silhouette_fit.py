import numpy as np
import pytest
from filmed_flights import BARE, CAMERAS, SCALE, STROKE_PLANE, apart, drawn, turning_flight

from flycontrol.units import deg, um
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.silhouette_fit import agreement, best_wing, fit_silhouettes, normal_equations, silhouette_cost
from flycontrol.vision.soft_silhouette import border_distance, signed_distance
from flycontrol.vision.stance import WING_TURN, coordinate_covariance, pose_of, stances_of, stepped
from flycontrol.vision.views import views_of

SHAPE = fit_shape(BARE)
POSE = turning_flight(1)[::9]
STANCES = stances_of(POSE)
SCALES = np.concatenate([np.full(3, SHAPE.wing_length), np.ones(9), np.full(6, SHAPE.wing_length)])


def borders(**kwargs):
    return [border_distance(views_of(masks, CAMERAS), 20) for masks in drawn(POSE, **kwargs)]


def test_distance_to_a_half_plane_is_the_distance_from_its_edge_between_pixels():
    mask = np.zeros((9, 20), dtype=bool)
    mask[:, 7:] = True
    np.testing.assert_allclose(signed_distance(mask), np.tile(6.5 - np.arange(20), (9, 1)))


def test_the_fly_that_was_drawn_covers_its_silhouettes():
    for border, stance in zip(borders(shape=BARE), STANCES, strict=True):
        seen = agreement(border, SHAPE, stance)
        assert np.min(seen.overlap) > 0.97  # borders of some 800 pixels about 3,000, at half a pixel's rounding


def test_the_gradient_is_that_of_the_cost():
    border, rng = borders()[1], np.random.default_rng(3)
    stance = stepped(STANCES[1], 0.02 * rng.normal(size=18) * SCALES)
    _, g = normal_equations(border, SHAPE, stance, 1.9)
    h = 1e-4
    for k, row in enumerate(np.eye(18)[:12]):  # the bases are also held, which the cost of the silhouettes leaves out
        ahead, behind = (silhouette_cost(border, SHAPE, stepped(stance, s * h * row * SCALES), 1.9) for s in (1, -1))
        # the slab's thickness is taken as constant, and pixels change their nearest part
        assert g[k] == pytest.approx((ahead - behind) / (4 * h), rel=0.1, abs=0.05 * np.max(np.abs(g)))


@pytest.mark.parametrize("softness", [1.0, 2.0, 3.5])
def test_of_stances_that_differ_in_a_wing_the_best_by_all_pixels_is_the_best_by_those_about_the_wing(softness):
    rng = np.random.default_rng(4)
    for border, stance in zip(borders(), STANCES, strict=True):
        for side in (0, 1):
            steps = np.zeros((9, 18))
            steps[1:, WING_TURN[side]] = rng.normal(0, 10 * deg, (8, 3))
            others = [stepped(stance, step) for step in steps]
            costs = [silhouette_cost(border, SHAPE, other, softness) for other in others]
            assert best_wing(border, SHAPE, others, side, softness=softness) == np.argmin(costs)


def test_a_stance_is_found_again_from_a_few_degrees_away_legs_or_not():
    rng, legged = np.random.default_rng(1), borders()
    spread = np.concatenate([np.full(3, 30 * um), np.full(3, 2 * deg), np.full(6, 6 * deg), np.zeros(6)])
    for border, truth, stance in zip(legged, POSE.coordinates, STANCES, strict=True):
        fit = fit_silhouettes(border, SHAPE, stepped(stance, rng.normal(size=18) * spread))
        away = apart(pose_of([fit.stance], STROKE_PLANE), pose_of([stance], STROKE_PLANE))[0]
        assert fit.converged
        assert np.max(np.abs(away[:3])) < 1 / SCALE * 1.2, truth  # a pixel: legs pull at the belly
        assert np.max(np.abs(away[3:6])) < 3 * deg
        assert np.max(np.abs(away[6:12])) < 6 * deg


def test_without_legs_the_errors_are_those_that_the_covariance_says():
    away, spread = [], []
    for border, stance in zip(borders(shape=BARE), STANCES, strict=True):
        fit = fit_silhouettes(border, SHAPE, stance)
        away.append(apart(pose_of([fit.stance], STROKE_PLANE), pose_of([stance], STROKE_PLANE))[0, :12])
        spread.append(np.sqrt(np.diag(coordinate_covariance(fit.stance, fit.covariance, STROKE_PLANE)))[:12])
    # silhouettes without noise err by their pixels alone, and the truth has the bases where they are held
    ratio = np.sqrt(np.mean(np.square(away), axis=0)) / np.sqrt(np.mean(np.square(spread), axis=0))
    assert np.max(ratio) < 2.0

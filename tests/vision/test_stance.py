import numpy as np
from filmed_flights import STROKE_PLANE, turning_flight

from flycontrol.units import mm, um
from flycontrol.vision.stance import coordinate_covariance, pose_of, stances_of, step_between, stepped

POSE = turning_flight(1)
STEP = np.concatenate([[0.1 * mm, -0.2 * mm, 0.05 * mm], np.linspace(-0.3, 0.4, 9), np.linspace(-50, 70, 6) * um])


def test_a_pose_survives_being_taken_apart():
    np.testing.assert_allclose(pose_of(stances_of(POSE), STROKE_PLANE).coordinates, POSE.coordinates, atol=1e-12)


def test_the_step_between_a_stance_and_where_a_step_leads_is_that_step():
    for stance in stances_of(POSE)[::9]:
        np.testing.assert_allclose(step_between(stance, stepped(stance, STEP)), STEP, rtol=1e-9, atol=1e-15)


def test_wings_keep_their_handedness_on_the_way():
    after = stepped(stances_of(POSE)[3], STEP)
    np.testing.assert_allclose(np.linalg.det(after.wings_B), [-1, 1], rtol=1e-12)
    np.testing.assert_allclose(after.body_axes_W @ after.body_axes_W.T, np.eye(3), atol=1e-12)


def test_a_base_moves_its_coordinates_alone_and_a_level_fly_turns_by_its_yaw():
    stance = stances_of(POSE)[0]
    base = np.zeros((18, 18))
    base[12, 12] = (1 * um) ** 2
    spread = np.sqrt(np.diag(coordinate_covariance(stance, base, STROKE_PLANE)))
    np.testing.assert_allclose(spread, np.eye(18)[12] * um, atol=1e-9 * um)


def test_spread_of_the_coordinates_is_that_of_many_stances():
    stance = stances_of(POSE)[5]
    sizes = np.concatenate([np.full(3, 5 * um), np.full(9, 2e-3), np.full(6, 5 * um)])
    rng = np.random.default_rng(1)
    many = pose_of([stepped(stance, step) for step in rng.normal(size=(2000, 18)) * sizes], STROKE_PLANE)
    expected = np.sqrt(np.diag(coordinate_covariance(stance, np.diag(sizes**2), STROKE_PLANE)))
    # a standard deviation of 2000 numbers has a standard error of 1.6 %
    np.testing.assert_allclose(many.coordinates.std(axis=0), expected, rtol=0.07)

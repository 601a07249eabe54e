from dataclasses import replace

import numpy as np
import pytest
from filmed_flights import BARE, CAMERAS, STROKE_PLANE, drawn, turning_flight
from scipy.spatial.transform import Rotation

from flycontrol.units import deg
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.search import rival
from flycontrol.vision.search.second_look import SecondLook, with_wing
from flycontrol.vision.soft_silhouette import border_distance
from flycontrol.vision.stance import TURN, WING_TURN, stances_of
from flycontrol.vision.views import views_of

SHAPE = fit_shape(BARE)
POSE = turning_flight(1)[4:30:12]
STANCES = stances_of(POSE)


@pytest.fixture(scope="module")
def looks():
    return [
        SecondLook(
            border=border_distance(views_of(masks, CAMERAS), 20),
            shape=SHAPE,
            stroke_plane_angle=STROKE_PLANE,
            expected=stance,
        )
        for masks, stance in zip(drawn(POSE), STANCES, strict=True)
    ]


def test_a_right_fit_without_a_rival_keeps_its_stance_and_its_covariance(looks):
    for look, stance in zip(looks, STANCES, strict=True):
        fit = look.near(stance)
        found = rival.with_rivals(fit, look)
        assert found.stance is fit.stance
        np.testing.assert_array_equal(found.covariance, fit.covariance)


def test_a_rival_that_costs_less_takes_the_place_of_the_fit(looks, monkeypatch):
    look, stance = looks[1], STANCES[1]
    fit = look.near(stance)
    turn = Rotation.from_rotvec(60 * deg * fit.stance.wings_B[1][:, 0]).as_matrix()
    dearer = replace(fit.agreement, cost=1.3 * fit.agreement.cost)
    wrong = replace(fit, stance=with_wing(fit.stance, 1, turn @ fit.stance.wings_B[1]), agreement=dearer)
    monkeypatch.setattr(rival, "_rival", lambda _, look, side, worth: (None, fit)[side])
    found = rival.with_rivals(wrong, look)
    assert found.stance is fit.stance
    assert np.all(np.linalg.eigvalsh(found.covariance - fit.covariance) > -1e-15)


def test_two_fits_of_equal_cost_leave_a_wing_as_uncertain_as_the_turn_between_them(looks, monkeypatch):
    """p = 1/2: the spread is that of a coin tossed between the two, about one of them, d / sqrt(2)."""
    look, stance = looks[1], STANCES[1]
    fit = look.near(stance)
    turn = Rotation.from_rotvec(60 * deg * fit.stance.wings_B[0][:, 0]).as_matrix()
    other = with_wing(fit.stance, 0, turn @ fit.stance.wings_B[0])
    twin = replace(fit, stance=other)
    monkeypatch.setattr(rival, "_rival", lambda fit, look, side, worth: twin if side == 0 else None)
    found = rival.with_rivals(fit, look, expecting=False)
    grown = found.covariance - fit.covariance
    span = fit.stance.wings_B[0][:, 0]
    np.testing.assert_allclose(span @ grown[WING_TURN[0], WING_TURN[0]] @ span, (60 * deg) ** 2 / 2, rtol=1e-9)
    assert np.all(grown[TURN, TURN] == 0)
    assert np.all(grown[WING_TURN[1], WING_TURN[1]] == 0)


def test_of_two_fits_of_equal_cost_the_one_nearer_to_where_the_wing_is_expected_is_taken(looks, monkeypatch):
    look, stance = looks[1], STANCES[1]
    fit = look.near(stance)
    turn = Rotation.from_rotvec(90 * deg * fit.stance.wings_B[0][:, 0]).as_matrix()
    other = replace(fit, stance=with_wing(fit.stance, 0, turn @ fit.stance.wings_B[0]))
    monkeypatch.setattr(rival, "_rival", lambda shown, look, side, worth: None if side else other)
    assert rival.with_rivals(fit, look).stance is fit.stance
    monkeypatch.setattr(rival, "_rival", lambda shown, look, side, worth: None if side else fit)
    assert rival.with_rivals(other, look).stance is fit.stance

import re
from dataclasses import replace

import numpy as np
import pytest
from filmed_flights import BARE, CAMERAS, WITH_LEGS, drawn, turning_flight
from scipy.spatial.transform import Rotation

from flycontrol.units import deg
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.render import render_silhouettes
from flycontrol.vision.search.belief import NO_DOUBTS, SLACK, doubts
from flycontrol.vision.search.part_claims import part_claims
from flycontrol.vision.search.second_look import with_wing
from flycontrol.vision.soft_silhouette import border_distance
from flycontrol.vision.stance import stances_of
from flycontrol.vision.views import views_of

SHAPE = fit_shape(BARE)
POSE = turning_flight(1)[2::6]
STANCES = stances_of(POSE)


@pytest.fixture(scope="module")
def borders():
    return [border_distance(views_of(masks, CAMERAS), 20) for masks in drawn(POSE)]


def doubted(border, stance, before=None):
    return doubts(part_claims(border, SHAPE, stance, SLACK), border, SHAPE, stance, before)


def turned(stance, side, axis, angle):
    turn = Rotation.from_rotvec(angle * np.asarray(axis)).as_matrix()
    return with_wing(stance, side, turn @ stance.wings_B[side])


def test_nothing_is_doubted_of_a_fly_that_is_where_its_silhouettes_are(borders):
    for border, stance in zip(borders, STANCES, strict=True):
        assert doubted(border, stance) == NO_DOUBTS


def test_a_part_claims_the_pixels_that_it_is_drawn_on_and_those_alone_that_no_other_is(borders):
    border, stance = borders[1], STANCES[1]
    found = part_claims(border, SHAPE, stance, SLACK)
    one = {
        part: next(iter(render_silhouettes(BARE, POSE[1], CAMERAS, parts=[part]))) for part in ("body", "left", "right")
    }
    for view in range(3):
        for k, part in enumerate(one):
            others = np.any([one[other][view] for other in one if other != part], axis=0)
            rim = 4 * np.sqrt(np.count_nonzero(one[part][view])) + 20  # half a pixel along the border
            assert abs(found.whole[view, k] - np.count_nonzero(one[part][view])) < rim
            assert abs(found.alone[view, k] - np.count_nonzero(one[part][view] & ~others)) < 2 * rim
    assert np.all(found.denied == 0)
    legs = [
        np.count_nonzero(mask) for mask in next(iter(render_silhouettes(WITH_LEGS, POSE[1], CAMERAS, parts=["legs"])))
    ]
    assert np.all(found.missed <= legs)


def test_a_wing_where_there_is_none_is_doubted_and_the_other_is_not(borders):
    for border, stance in zip(borders, STANCES, strict=True):
        found = doubted(border, turned(stance, 1, [1.0, 0.0, 0.0], 60 * deg))
        assert "right wing" in found[2]
        assert re.search(r"\d+%", found[2])
        assert found[:2] == ("", "")


def test_a_wing_beyond_the_margin_around_the_silhouettes_is_doubted_too(borders):
    narrow = [
        border_distance(views_of(masks, CAMERAS), 3)
        for masks in render_silhouettes(BARE, POSE, CAMERAS, parts=["body"])
    ]
    assert all(all(doubted(border, stance)[1:]) for border, stance in zip(narrow, STANCES, strict=True))
    assert len(narrow) == len(borders)


def test_a_wing_end_to_end_is_doubted(borders):
    """Its silhouette is nearly the same: only the base tells."""
    stance = STANCES[2]
    bases = stance.bases_B.copy()
    bases[1] += SHAPE.wing_length * stance.wings_B[1][:, 0]
    found = doubted(borders[2], replace(turned(stance, 1, stance.wings_B[1][:, 1], np.pi), bases_B=bases))
    assert "base" in found[2]


def test_a_wing_hidden_in_the_body_while_its_silhouette_is_left_over_is_doubted(borders):
    border, stance = borders[1], STANCES[1]
    usual = part_claims(border, SHAPE, stance, SLACK).missed
    along = stance.wings_B.copy()
    along[1] = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]).T  # back along the body, on edge
    hidden = replace(stance, wings_B=along)
    hidden = replace(hidden, bases_B=stance.bases_B * [[1, 1, 1], [1, 0.2, 0.2]])
    found = doubted(border, hidden, usual)
    assert found[1] == ""
    assert found[2]


def test_what_is_left_over_is_put_down_to_a_wing_and_names_the_camera_in_quotes(borders):
    usual = np.array([np.inf, -np.inf, np.inf])  # only the second view holds more than it used to
    (said,) = [why for why in doubted(borders[0], STANCES[0], usual) if why]
    assert re.findall("'([^']*)'", said) == [CAMERAS[1].name]
    assert said.startswith(("the left wing may be", "the right wing may be"))

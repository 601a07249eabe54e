from dataclasses import replace

import numpy as np
import pytest
from filmed_flights import BARE, CAMERAS, STROKE_PLANE, drawn, turning_flight

from flycontrol.model.pose import Pose
from flycontrol.vision.checks.attitude_check import upside_down
from flycontrol.vision.follower import Fly
from flycontrol.vision.track import track

FLY = Fly(shape=BARE, stroke_plane_angle=STROKE_PLANE)


@pytest.fixture(scope="module")
def found():
    pose = turning_flight(1)
    return track(drawn(Pose(coordinates=pose.coordinates[:3], stroke_plane_angle=STROKE_PLANE)), CAMERAS, FLY)


def rolled(found, turns):
    X = found.pose.coordinates.copy()
    X[:, 5] += np.pi * np.array(turns)
    return replace(found, pose=Pose(coordinates=X, stroke_plane_angle=STROKE_PLANE))


def test_a_fly_the_right_way_up_is_nothing_to_speak_of(found):
    assert not upside_down(found)


def test_a_fly_that_rolls_over_for_less_than_half_of_a_film_may(found):
    assert not upside_down(rolled(found, (0, 1, 0)))


def test_a_fly_on_its_back_for_most_of_a_film_is_told_with_what_to_try(found):
    said = upside_down(rolled(found, (1, 1, 0)))
    assert said.startswith("the fly is seen on its back in 2 of 3 frames")
    assert "--up=-z" in said

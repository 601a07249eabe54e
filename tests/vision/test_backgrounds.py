import numpy as np
import pytest
from filmed_flights import BARE, CAMERAS, turning_flight

from flycontrol.errors import InvalidInputError
from flycontrol.model.pose import Pose
from flycontrol.units import mm
from flycontrol.vision.backgrounds import film_background
from flycontrol.vision.drawn_film import DrawnFilm
from flycontrol.vision.render import BRIGHT, Imaging

IMAGING = Imaging(blur=0.8, noise=0.02)


def film_of_a_fly(moved):
    """A wingbeat of a fly that moves on by so much meanwhile [m]."""
    pose = turning_flight(1)
    X = pose.coordinates.copy()
    X[:, :3] += np.linspace(-moved / 2, moved / 2, len(X))[:, None]
    there = Pose(coordinates=X, stroke_plane_angle=pose.stroke_plane_angle)
    return DrawnFilm(shape_of_fly=BARE, pose=there, camera=CAMERAS[0], imaging=IMAGING)


def test_the_median_of_a_film_that_a_fly_crosses_is_the_empty_scene():
    assert np.max(np.abs(film_background(film_of_a_fly(5 * mm)) - BRIGHT)) < 15  # noise of 3.2 grey levels


def test_a_fly_that_stays_is_not_taken_for_its_own_background():
    with pytest.raises(InvalidInputError, match="stays in one place"):
        film_background(film_of_a_fly(0.3 * mm))

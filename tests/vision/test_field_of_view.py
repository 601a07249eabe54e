from dataclasses import replace

import numpy as np
import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera_forms import looking_at, orthogonal_cameras
from flycontrol.units import mm
from flycontrol.vision.checks.field_of_view import field_of_view, require_field_of_a_fly

WING = 2.4 * mm
CAMERAS = tuple(
    looking_at((0, 0, 0), np.array(place) * mm, focal=3000, shape=(300, 400))
    for place in ((100, 0, 0), (0, 100, 0), (0, 0, 100))
)


def in_units(cameras, factor):
    """The cameras of a calibration whose lengths were taken for so many times longer ones."""
    return tuple(replace(camera, matrix=camera.matrix * [1 / factor, 1 / factor, 1 / factor, 1]) for camera in cameras)


def test_the_field_is_the_images_diagonal_where_the_cameras_look():
    assert field_of_view(CAMERAS) == pytest.approx(500 / 3000 * 100 * mm, rel=1e-3)  # by half a pixel off the axis
    assert field_of_view(orthogonal_cameras(scale=30 / mm, shape=(300, 400))) == pytest.approx(500 / 30 * mm)
    assert field_of_view(CAMERAS[:1] * 2) is None


def test_lengths_in_another_unit_are_refused_before_an_image_is_looked_at():
    for factor in (1.0, 1 / 3, 25.4):  # whatever could be a fly's
        require_field_of_a_fly(in_units(CAMERAS, factor), WING)
    with pytest.raises(InvalidInputError, match=r"a field that is 16\.7 m across"):
        require_field_of_a_fly(in_units(CAMERAS, 1000), WING)
    with pytest.raises(InvalidInputError, match=r"a field that is 0\.0167 mm across"):
        require_field_of_a_fly(in_units(CAMERAS, 1e-3), WING)

import numpy as np
import pytest

from flycontrol.model.world_axes import AXES, upright, upright_words


@pytest.mark.parametrize("axis", AXES)
def test_the_axis_that_points_up_becomes_z_by_a_turn(axis):
    pointing = np.eye(3)["xyz".index(axis[-1])] * (-1 if axis[0] == "-" else 1)
    assert np.array_equal(upright(axis) @ pointing, [0, 0, 1])
    assert np.linalg.det(upright(axis)) == pytest.approx(1)


def test_the_turned_world_is_described():
    assert upright_words("-z") == "z up; its x, y, z are x, -y, -z of the calibration, whose -z points up"

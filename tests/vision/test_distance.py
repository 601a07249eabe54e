import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt

from flycontrol.vision.kernels.distance import distance_to

seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=30)
@given(seeds, st.integers(1, 40), st.integers(1, 40), st.sampled_from([0.003, 0.05, 0.5, 0.97]))
def test_distances_are_those_of_scipy_to_the_last_bit(seed, rows, columns, share):
    mask = np.random.default_rng(seed).uniform(size=(rows, columns)) < share
    mask[0, 0], mask[-1, -1] = True, rows * columns == 1
    assert np.array_equal(distance_to(mask, True), distance_transform_edt(~mask))
    if not mask.all():
        assert np.array_equal(distance_to(mask, False), distance_transform_edt(mask))


@pytest.mark.parametrize("wanted", [True, False])
def test_where_no_pixel_is_as_wanted_every_pixel_is_infinitely_far(wanted):
    assert np.all(distance_to(np.full((3, 5), not wanted), wanted) == np.inf)

import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from flycontrol.errors import InvalidParameterError
from flycontrol.jobs.packed import Packing, unpacked

plain = st.none() | st.booleans() | st.integers() | st.floats() | st.text()
kinds = hnp.boolean_dtypes() | hnp.integer_dtypes() | hnp.floating_dtypes() | hnp.complex_number_dtypes()
arrays = hnp.arrays(
    kinds | hnp.unicode_string_dtypes(), hnp.array_shapes(min_dims=0, min_side=0, max_dims=3, max_side=4)
)
leaves = plain | arrays | arrays.filter(lambda a: a.size).map(lambda a: a.flat[0])
results = st.recursive(
    leaves, lambda parts: st.lists(parts, max_size=3) | st.dictionaries(st.text(), parts, max_size=3), max_leaves=4
)


def packed(*several):
    packing = Packing()
    for i, result in enumerate(several):
        packing.add(result, f"result {i}")
    return packing.to_bytes()


def bits(value):
    """Type, shape and bytes of everything inside: NaN equals NaN, and -0.0 is not 0.0."""
    if isinstance(value, np.ndarray):
        return ("array", value.dtype.str, value.shape, value.tobytes())
    if isinstance(value, list):
        return [bits(part) for part in value]
    if isinstance(value, dict):
        return {key: bits(part) for key, part in value.items()}
    if isinstance(value, np.generic):
        return ("scalar", value.dtype.str, value.tobytes())
    return (type(value), value.hex() if isinstance(value, float) else value)


@settings(max_examples=60)
@given(st.lists(results, max_size=4))
def test_results_come_back_bit_for_bit(several):
    assert bits(unpacked(packed(*several))) == bits(several)


@settings(max_examples=60)
@given(results)
def test_equal_results_are_equal_bytes(result):
    again = unpacked(packed(result))[0]
    assert packed(again) == packed(result)


def test_an_array_that_the_task_fills_again_keeps_its_first_content():
    packing, same = Packing(), np.zeros(2)
    packing.add(same, "result 0")
    same[:] = 1
    packing.add(same, "result 1")
    assert [list(result) for result in unpacked(packing.to_bytes())] == [[0, 0], [1, 1]]


def test_arrays_that_come_back_are_not_views_of_each_other():
    first, second = unpacked(packed(np.zeros(2), np.zeros(2)))
    assert not np.shares_memory(first, second)
    assert first.base is None


def test_the_file_is_read_without_pickle():
    with np.load(io.BytesIO(packed({"x": np.arange(3)})), allow_pickle=False) as file:
        assert [file[name].dtype.hasobject for name in file.files] == [False, False]


@pytest.mark.parametrize(
    "value", [(1, 2), {1: 2}, {1, 2}, object(), np.array([None]), np.ma.array([1.0]), np.zeros(1, [("a", float)]), b"x"]
)
def test_what_would_not_come_back_as_it_was_is_refused_by_its_place(value):
    with pytest.raises(InvalidParameterError, match=r"result 0\['fit'\]\[1\] must be made of arrays, .* got"):
        packed({"fit": [0, value]})

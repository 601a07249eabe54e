import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from seeded_tasks import draw

from flycontrol.errors import InvalidParameterError
from flycontrol.jobs.work import Work, generator


@given(st.integers(0, 2**130), st.integers(1, 40))
def test_the_generator_of_item_i_is_the_child_i_of_the_seed(seed, n):
    children = np.random.SeedSequence(seed).spawn(n)
    expected = np.random.Generator(np.random.PCG64(children[-1])).integers(2**63)
    assert generator(seed, n - 1).integers(2**63) == expected


@given(st.integers(0, 2000), st.integers(0, 300))
def test_the_chunks_are_the_items_in_order_each_once(n, chunk):
    work = Work(task=draw, items=range(n), seed=1, chunk=chunk)
    chunks = [work.items_of(k) for k in range(work.chunks)]
    assert [item for items in chunks for item in items] == list(range(n))
    assert [work.start_of(k) for k in range(work.chunks)] == [items[0] for items in chunks]


@pytest.mark.parametrize("wrong", [{"seed": -1}, {"seed": 1.0}, {"seed": None}, {"seed": True}, {"chunk": -1}])
def test_a_seed_or_chunk_that_is_no_count_is_refused(wrong):
    with pytest.raises(InvalidParameterError, match="must be an integer >= 0, got"):
        Work(**{"task": draw, "items": range(3), "seed": 1, **wrong})

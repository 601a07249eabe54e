from functools import partial
from itertools import pairwise

import pytest
from seeded_tasks import draw, logged, nested, process, refusing, slow_start, talkative, threads
from test_packed import bits

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.jobs.processes import ProcessPool
from flycontrol.jobs.seeded_map import iter_chunks, seeded_map
from flycontrol.jobs.work import Work, generator

ITEMS = range(41)
DRAWS = Work(task=draw, items=ITEMS, seed=7)


@pytest.fixture(scope="module")
def pool():
    with ProcessPool(2) as two:
        yield two


@pytest.fixture(scope="module")
def expected():
    return bits([draw(item, generator(7, item)) for item in ITEMS])


@pytest.mark.parametrize("chunk", [0, 1, 7, 1000])
def test_one_worker_gives_what_a_loop_gives_whatever_the_chunks(expected, chunk):
    assert bits(seeded_map(Work(task=draw, items=ITEMS, seed=7, chunk=chunk), workers=1)) == expected


@pytest.mark.parametrize("chunk", [0, 7, 1000])
def test_two_workers_give_the_bytes_of_one_whatever_the_chunks(expected, pool, chunk):
    assert bits(seeded_map(Work(task=draw, items=ITEMS, seed=7, chunk=chunk), pool)) == expected


def test_another_seed_gives_other_results(expected):
    assert bits(seeded_map(Work(task=draw, items=ITEMS, seed=8), workers=1)) != expected


@pytest.mark.parametrize("workers", [1, 2, None])
def test_no_items_give_no_results(workers):
    assert seeded_map(Work(task=draw, items=[], seed=1), workers) == []


def test_a_pool_does_several_maps_with_the_same_processes(pool):
    first, second = (set(seeded_map(Work(task=process, items=ITEMS, seed=1), pool)) for _ in range(2))
    assert len(first | second) <= 2


def test_a_map_within_a_worker_stays_within_it(pool):
    within = seeded_map(Work(task=nested, items=[3], seed=1), pool)
    assert bits(within[0]) == bits(seeded_map(Work(task=draw, items=range(2), seed=3), workers=1))


def test_linear_algebra_runs_on_one_thread_here_and_in_workers(pool):
    work = Work(task=threads, items=range(2), seed=1)
    found = [*seeded_map(work, pool), *seeded_map(work, workers=1)]
    assert {count for counts in found for count in counts} == {1}


@pytest.mark.parametrize("workers", [1, 2])
def test_progress_rises_from_nothing_to_all_items(pool, workers):
    told = []
    work = Work(task=draw, items=ITEMS, seed=7, chunk=10, name="draws")
    seeded_map(work, pool if workers == 2 else 1, progress=lambda *now: told.append(now))
    assert [done for done, _, _ in told][:: len(told) - 1] == [0, 41]
    assert all(before < after for (before, *_), (after, *_) in pairwise(told))
    assert {rest for _, *rest in told for rest in [tuple(rest)]} == {(41, "draws")}


def test_an_error_of_ours_in_a_worker_is_raised_as_it_is(pool, tmp_path):
    work = Work(task=partial(refusing, tmp_path), items=range(200), seed=1, chunk=10)
    with pytest.raises(InvalidInputError, match=r"^fly 30 has no yaw; leave it out\.") as refusal:
        seeded_map(work, pool)
    assert "in refusing" in refusal.value.__notes__[0]  # where it happened


def test_an_exception_that_does_not_survive_the_way_is_told_by_its_name(pool):
    with pytest.raises(RuntimeError, match="TalkativeError: one and two"):
        seeded_map(Work(task=talkative, items=[0], seed=1), pool)


def test_a_pool_works_on_after_an_error(pool, expected):
    with pytest.raises(RuntimeError):
        seeded_map(Work(task=talkative, items=[0], seed=1), pool)
    assert bits(seeded_map(DRAWS, pool)) == expected


def test_a_task_that_cannot_be_sent_is_refused(pool):
    with pytest.raises(InvalidParameterError, match="must be a function at the top level of a module"):
        seeded_map(Work(task=lambda item, _: item, items=ITEMS, seed=1), pool)


def test_a_task_that_a_worker_cannot_find_is_refused(pool, monkeypatch):
    def hidden(_item, _generator): ...

    hidden.__qualname__ = "hidden"
    monkeypatch.setattr("seeded_tasks.hidden", hidden, raising=False)
    hidden.__module__ = "seeded_tasks"
    with pytest.raises(InvalidParameterError, match="does not find the task"):
        seeded_map(Work(task=hidden, items=ITEMS, seed=1), pool)


@pytest.mark.parametrize("workers", [0, -1, 1.5, True, "2"])
def test_a_number_of_workers_that_is_none_is_refused(workers):
    with pytest.raises(InvalidParameterError, match="workers must be an integer >= 1"):
        seeded_map(DRAWS, workers)


def test_two_maps_at_once_on_one_pool_are_refused(pool):
    first = iter_chunks(Work(task=draw, items=ITEMS, seed=1, chunk=1), pool)
    next(first)
    with pytest.raises(InvalidParameterError, match="at work on another map"):
        seeded_map(DRAWS, pool)
    first.close()


def test_chunks_come_in_the_order_of_the_items(pool, tmp_path):
    work = Work(task=partial(slow_start, tmp_path), items=range(60), seed=1, chunk=2)
    chunks = list(iter_chunks(work, pool))
    assert [len(results) for results in chunks] == [2] * 30
    assert bits([row for rows in chunks for row in rows]) == bits(
        [generator(1, item).standard_normal(3) for item in range(60)]
    )


def test_a_slow_chunk_holds_the_others_up_before_they_fill_the_memory(pool, tmp_path):
    chunks = iter_chunks(Work(task=partial(slow_start, tmp_path), items=range(400), seed=1, chunk=1), pool)
    next(chunks)
    done = len(list(tmp_path.iterdir()))
    chunks.close()
    assert done <= pool.ahead + 2


def test_results_that_nobody_asks_for_any_more_are_not_computed(pool, tmp_path):
    chunks = iter_chunks(Work(task=partial(logged, tmp_path, 0.01), items=range(400), seed=1, chunk=1), pool)
    next(chunks)
    chunks.close()
    done = len(list(tmp_path.iterdir()))
    assert done < 20
    assert seeded_map(Work(task=process, items=[0], seed=1), pool)
    assert len(list(tmp_path.iterdir())) == done

import sys
from functools import partial

import pytest
from seeded_tasks import draw, refusing
from test_packed import bits

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.jobs.dask_workers import DaskWorkers
from flycontrol.jobs.seeded_map import iter_chunks, seeded_map
from flycontrol.jobs.work import Work


@pytest.fixture(scope="module")
def cluster():
    distributed = pytest.importorskip("distributed", reason="Dask is an optional extra.")
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None) as local,
        distributed.Client(local) as client,
    ):
        yield DaskWorkers(client)


def test_a_dask_cluster_gives_the_bytes_of_one_process(cluster):
    work = Work(task=draw, items=range(41), seed=7, chunk=3)
    assert bits(seeded_map(work, cluster)) == bits(seeded_map(work, workers=1))


def test_chunks_of_a_cluster_are_kept_here_and_come_in_order(cluster, tmp_path):
    work = Work(task=draw, items=range(10), seed=7, chunk=3)
    chunks = list(iter_chunks(work, cluster, Checkpoint(tmp_path, "x")))
    assert [len(results) for results in chunks] == [3, 3, 3, 1]
    assert len(list(tmp_path.glob("chunk-*.npz"))) == 4


def test_an_error_of_ours_on_a_cluster_is_raised_as_it_is(cluster, tmp_path):
    work = Work(task=partial(refusing, tmp_path), items=range(40), seed=1, chunk=10)
    with pytest.raises(InvalidInputError, match="fly 30 has no yaw"):
        seeded_map(work, cluster)


def test_without_dask_the_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InvalidParameterError, match=r"install `flycontrol\[dask\]`"):
        DaskWorkers("tcp://localhost:1")


def test_a_scheduler_that_does_not_answer_is_one_sentence(cluster):
    dask = pytest.importorskip("dask")
    with (
        dask.config.set({"distributed.comm.timeouts.connect": "200ms"}),
        pytest.raises(InvalidParameterError, match=r"no Dask scheduler answers at 'tcp://127\.0\.0\.1:9'"),
    ):
        DaskWorkers("tcp://127.0.0.1:9")

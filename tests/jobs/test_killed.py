import contextlib
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from seeded_tasks import dying, logged
from test_packed import bits

from flycontrol.errors import WorkerLostError
from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.jobs.processes import ProcessPool
from flycontrol.jobs.seeded_map import iter_chunks, seeded_map
from flycontrol.jobs.work import Work, generator

HERE = Path(__file__).parent
ROWS = [generator(1, i).standard_normal(3) for i in range(60)]


@pytest.fixture
def log(tmp_path):
    (tmp_path / "log").mkdir()
    return tmp_path / "log"


def executions(log: Path) -> list[int]:
    return sorted(int(path.name[:4]) for path in log.iterdir())


def start(tmp_path, workers, pause):
    """Start the job in its own process group, as a terminal does."""
    command = [sys.executable, HERE / "job_to_kill.py", tmp_path / "chunks", tmp_path / "log", workers, pause]
    paths = os.pathsep.join([str(HERE.parents[1]), os.environ.get("PYTHONPATH", "")])
    return subprocess.Popen(
        list(map(str, command)),
        env={**os.environ, "PYTHONPATH": paths},
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def wait_until(true, seconds=30):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.002)


def kept_items(tmp_path) -> set[int]:
    chunks = [int(path.stem.split("-")[1]) for path in (tmp_path / "chunks").glob("chunk-*.npz")]
    return {item for chunk in chunks for item in range(3 * chunk, 3 * chunk + 3)}


def is_alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def group_is_alive(pid: int) -> bool:
    try:
        os.killpg(pid, 0)
    except ProcessLookupError:
        return False
    return True


def end_at_some_chunks(tmp_path, workers, chunks, end):
    """Let the job finish some chunks and end it; return its exit status and what it said, its workers being gone."""
    job = start(tmp_path, workers, 0.01)
    wait_until(lambda: len(kept_items(tmp_path)) >= 3 * chunks)
    end(job)
    _, said = job.communicate(timeout=30)
    pids = {int(path.name.split("-")[1]) for path in (tmp_path / "log").iterdir()}
    assert len(pids) <= max(workers, 1)
    wait_until(lambda: not any(map(is_alive, pids)), 5)
    return job.returncode, said


def resume_and_check(tmp_path, log, workers):
    """Resume: every chunk that was kept is not done again, every other item exactly once, and the rows are the same."""
    kept = kept_items(tmp_path)
    assert 0 < len(kept) < 60
    for path in log.iterdir():
        path.unlink()
    job = start(tmp_path, workers, 0)
    _, said = job.communicate(timeout=60)
    assert (job.returncode, said) == (0, "")
    assert executions(log) == sorted(set(range(60)) - kept)
    assert np.load(tmp_path / "chunks.npy").tobytes() == np.array(ROWS).tobytes()
    assert not list((tmp_path / "chunks").glob("*.part"))


@pytest.mark.parametrize(("workers", "then"), [(2, 1), pytest.param(1, 2, marks=pytest.mark.slow)])
def test_a_killed_main_process_leaves_no_worker_and_resumes_where_it_was(tmp_path, log, workers, then):
    status, _ = end_at_some_chunks(tmp_path, workers, 3, lambda job: job.kill())
    assert status == -signal.SIGKILL
    resume_and_check(tmp_path, log, then)


@pytest.mark.slow
@pytest.mark.parametrize("chunks", [0, 1, 6, 11, 16, 19])
def test_a_main_process_killed_at_any_point_resumes_where_it_was(tmp_path, log, chunks):
    end_at_some_chunks(tmp_path, 2, max(chunks, 1), lambda job: job.kill())
    resume_and_check(tmp_path, log, 2)


def test_ctrl_c_ends_all_processes_keeps_what_is_finished_and_the_workers_say_nothing(tmp_path, log):
    status, said = end_at_some_chunks(tmp_path, 2, 3, lambda job: os.killpg(job.pid, signal.SIGINT))
    assert status == -signal.SIGINT
    assert said.count("Traceback") == 1
    assert said.rstrip().endswith("KeyboardInterrupt")
    resume_and_check(tmp_path, log, 2)


@pytest.mark.slow
def test_ctrl_c_while_the_workers_start_ends_them_too(tmp_path, log):
    job = start(tmp_path, 2, 0.01)
    wait_until((tmp_path / "chunks" / "job.json").exists)
    time.sleep(0.05)
    os.killpg(job.pid, signal.SIGINT)
    _, said = job.communicate(timeout=30)
    assert job.returncode == -signal.SIGINT
    assert said.count("Traceback") == 1
    wait_until(lambda: not group_is_alive(job.pid), 5)


@contextlib.contextmanager
def interrupted_when(true):
    """Raise KeyboardInterrupt wherever this process is when it becomes true."""

    def look(*_):
        if true():
            raise KeyboardInterrupt
        signal.setitimer(signal.ITIMER_REAL, 0.01)

    before = signal.signal(signal.SIGALRM, look)
    signal.setitimer(signal.ITIMER_REAL, 0.01)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_a_worker_killed_while_it_works_costs_its_own_chunk_only(log):
    work = Work(task=partial(dying, log, 1), items=range(60), seed=1, chunk=3)
    with ProcessPool(2) as pool:
        assert bits(seeded_map(work, pool)) == bits(ROWS)
    done = executions(log)
    assert done == sorted([*range(60), 3, 4, 5])


def test_a_chunk_that_kills_two_workers_is_named_and_the_rest_is_kept(log, tmp_path):
    work = Work(task=partial(dying, log, 2), items=range(60), seed=1, chunk=3, name="fits")
    checkpoint = Checkpoint(tmp_path / "chunks", "x")
    with ProcessPool(2) as pool:
        with pytest.raises(WorkerLostError, match=r"fits 3 to 5: the worker process was killed twice"):
            seeded_map(work, pool, checkpoint)
        first = executions(log)
        assert bits(seeded_map(work, pool, checkpoint)) == bits(ROWS)
    assert first.count(5) == 2
    assert executions(log).count(0) == 1  # chunk 0 was kept


def test_a_worker_killed_between_two_maps_is_replaced(log):
    work = Work(task=partial(logged, log, 0), items=range(60), seed=1, chunk=3)
    with ProcessPool(1) as pool:
        seeded_map(work, pool)
        (pid,) = {int(path.name.split("-")[1]) for path in log.iterdir()}
        os.kill(pid, signal.SIGKILL)
        wait_until(lambda: not is_alive(pid))
        assert bits(seeded_map(work, pool)) == bits(ROWS)


def test_nothing_is_left_of_a_pool_that_is_closed_in_the_middle(log):
    work = Work(task=partial(logged, log, 5), items=range(60), seed=1, chunk=1)
    with (
        pytest.raises(KeyboardInterrupt),
        interrupted_when(lambda: len(list(log.iterdir())) == 2),
        ProcessPool(2) as pool,
    ):
        next(iter_chunks(work, pool))
    pids = {int(path.name.split("-")[1]) for path in log.iterdir()}
    assert not any(map(is_alive, pids))


@pytest.mark.slow
def test_a_script_that_workers_cannot_import_is_told_what_it_lacks():
    paths = os.pathsep.join([str(HERE.parents[1]), os.environ.get("PYTHONPATH", "")])
    said = subprocess.run(
        [sys.executable, HERE / "script_without_guard.py"],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    ).stderr
    assert "must call from below `if __name__ == '__main__':`" in said

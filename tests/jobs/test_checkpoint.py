import errno
import fcntl
import os
import shutil
import stat
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from seeded_tasks import logged, refusing
from test_packed import bits

from flycontrol.errors import InvalidInputError, InvalidParameterError, OutputError
from flycontrol.jobs import files
from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.jobs.seeded_map import iter_chunks, seeded_map
from flycontrol.jobs.work import Work, generator

EXPECTED = bits([generator(1, i).standard_normal(3) for i in range(35)])


@pytest.fixture
def log(tmp_path):
    (tmp_path / "log").mkdir()
    return tmp_path / "log"


@pytest.fixture
def work(log):
    return Work(task=partial(logged, log, 0), items=range(35), seed=1, chunk=10)


@pytest.fixture
def checkpoint(tmp_path):
    return Checkpoint(tmp_path / "out" / "chunks", "five flies")


def done(log: Path) -> list[int]:
    """Return the items executed since last asked, in order, repeated as often as executed."""
    found = sorted(int(path.name[:4]) for path in log.iterdir())
    for path in log.iterdir():
        path.unlink()
    return found


def test_finished_chunks_are_files_without_pickle_and_nothing_else_remains(work, checkpoint):
    assert bits(seeded_map(work, 1, checkpoint)) == EXPECTED
    names = ["chunk-000000.npz", "chunk-000001.npz", "chunk-000002.npz", "chunk-000003.npz", "job.json"]
    assert sorted(path.name for path in checkpoint.folder.iterdir()) == names
    with np.load(checkpoint.folder / names[0], allow_pickle=False) as file:
        assert file["<f8"].size == 30


def test_what_is_finished_is_read_and_not_computed_again(work, checkpoint, log):
    told = []
    seeded_map(work, 1, checkpoint)
    assert done(log) == list(range(35))
    assert bits(seeded_map(work, 1, checkpoint, lambda *now: told.append(now))) == EXPECTED
    assert done(log) == []
    assert told == [(35, 35, "items")]


def test_chunks_kept_in_files_come_in_order_as_they_are_done(work, checkpoint, log):
    chunks = iter_chunks(work, 1, checkpoint)
    next(chunks)
    assert done(log) == list(range(10))
    chunks.close()
    assert bits(seeded_map(work, 1, checkpoint)) == EXPECTED
    assert done(log) == list(range(10, 35))


def test_a_file_cut_or_changed_anywhere_is_computed_again(work, checkpoint, log):
    seeded_map(work, 1, checkpoint)
    path = checkpoint.folder / "chunk-000001.npz"
    whole = path.read_bytes()
    changed = [whole[:k] + bytes([whole[k] ^ 1]) + whole[k + 1 :] for k in range(0, len(whole), len(whole) // 13)]
    cut = [whole[:k] for k in range(0, len(whole), len(whole) // 13)]
    for damaged in [*changed, *cut, whole + b"\0"]:
        path.write_bytes(damaged)
        done(log)
        assert bits(seeded_map(work, 1, checkpoint)) == EXPECTED
        assert done(log) == list(range(10, 20))
        assert path.read_bytes() == whole


def test_a_chunk_of_another_place_or_job_is_computed_again(work, checkpoint, log, tmp_path):
    seeded_map(work, 1, checkpoint)
    other = Checkpoint(tmp_path / "other", "six flies")
    seeded_map(work, 1, other)
    shutil.copy(other.folder / "chunk-000001.npz", checkpoint.folder)
    shutil.copy(checkpoint.folder / "chunk-000003.npz", checkpoint.folder / "chunk-000002.npz")
    done(log)
    assert bits(seeded_map(work, 1, checkpoint)) == EXPECTED
    assert done(log) == list(range(10, 30))


@pytest.mark.parametrize(
    ("change", "identity", "difference"),
    [
        ({"seed": 2}, "five flies", "seed 1 instead of 2"),
        ({"chunk": 5}, "five flies", "chunk 10 instead of 5"),
        ({"items": range(34)}, "five flies", "items 35 instead of 34"),
        ({}, "six flies", "identity 'five flies' instead of 'six flies'"),
        ({}, 64 * "b", "other identity: input or options differ"),
    ],
)
def test_a_folder_of_another_job_is_refused_with_the_difference(work, checkpoint, log, change, identity, difference):
    seeded_map(work, 1, checkpoint)
    done(log)
    another = Work(**{"task": work.task, "items": work.items, "seed": 1, "chunk": 10, **change})
    with pytest.raises(OutputError, match=rf"another job \({difference}\); choose another folder, or remove"):
        seeded_map(another, 1, Checkpoint(checkpoint.folder, identity))
    assert done(log) == []


@pytest.mark.parametrize("content", [b"", b"[]", b"\xff", None])
def test_a_folder_whose_job_cannot_be_known_is_refused(work, checkpoint, content):
    seeded_map(work, 1, checkpoint)
    job = checkpoint.folder / "job.json"
    job.unlink() if content is None else job.write_bytes(content)
    with pytest.raises(OutputError, match="choose another folder, or remove"):
        seeded_map(work, 1, checkpoint)


def test_a_folder_that_another_process_works_in_is_refused(work, checkpoint, log):
    seeded_map(work, 1, checkpoint)
    done(log)
    descriptor = os.open(checkpoint.folder, os.O_RDONLY)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    try:
        with pytest.raises(OutputError, match="is in use by another process"):
            seeded_map(work, 1, checkpoint)
    finally:
        os.close(descriptor)
    assert bits(seeded_map(work, 1, checkpoint)) == EXPECTED


def test_a_full_disk_is_one_sentence_and_what_was_finished_stays(work, checkpoint, log, monkeypatch):
    remaining = iter([None, None])  # job.json and chunk 0, each with its content flushed; then the disk is full
    flush = os.fsync

    def fsync(descriptor):
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            return
        if next(remaining, 0) == 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        flush(descriptor)

    monkeypatch.setattr(files.os, "fsync", fsync)
    with pytest.raises(OutputError, match=r"chunk-000001\.npz could not be written: No space left on device"):
        seeded_map(work, 1, checkpoint)
    monkeypatch.undo()
    assert sorted(path.name for path in checkpoint.folder.iterdir()) == ["chunk-000000.npz", "job.json"]
    done(log)
    assert bits(seeded_map(work, 1, checkpoint)) == EXPECTED
    assert done(log) == list(range(10, 35))


def test_an_error_of_the_task_keeps_what_was_finished(checkpoint, log):
    work = Work(task=partial(refusing, log), items=range(35), seed=1, chunk=10)
    with pytest.raises(InvalidInputError, match="fly 30"):
        seeded_map(work, 1, checkpoint)
    assert sorted(path.name for path in checkpoint.folder.glob("chunk-*")) == [f"chunk-00000{k}.npz" for k in range(3)]


def test_what_a_killed_process_was_writing_is_removed(work, checkpoint):
    seeded_map(work, 1, checkpoint)
    torn = [checkpoint.folder / f".{name}.0123abcd.part" for name in ("chunk-000002.npz", "job.json")]
    for path in torn:
        path.write_bytes(b"half")
    seeded_map(work, 1, checkpoint)
    assert not any(path.exists() for path in torn)


def test_a_folder_that_cannot_be_made_is_one_sentence(work, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be created for unfinished work"):
        seeded_map(work, 1, Checkpoint(tmp_path / "file" / "chunks", "x"))


def test_an_identity_that_says_nothing_is_refused(tmp_path):
    with pytest.raises(InvalidParameterError, match="must say what the results depend on"):
        Checkpoint(tmp_path, "")


def test_removing_the_chunks_leaves_other_files_alone(work, checkpoint):
    seeded_map(work, 1, checkpoint)
    (checkpoint.folder / "notes.txt").touch()
    checkpoint.remove()
    assert [path.name for path in checkpoint.folder.iterdir()] == ["notes.txt"]
    (checkpoint.folder / "notes.txt").unlink()
    checkpoint.remove()
    assert not checkpoint.folder.exists()

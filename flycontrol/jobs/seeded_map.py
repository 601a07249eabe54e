"""results[i] = task(items[i], generator_i), over processes, with progress, checkpoint and resume."""

from __future__ import annotations

import contextlib
import multiprocessing
from collections.abc import Generator
from typing import Protocol, cast

from flycontrol.jobs.checkpoint import Checkpoint, opened
from flycontrol.jobs.packed import Result, unpacked
from flycontrol.jobs.processes import ProcessPool, ThisProcess, Workers
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.jobs.work import Work


def seeded_map(
    work: Work,
    workers: int | Workers | None = None,
    checkpoint: Checkpoint | None = None,
    progress: Progress = no_progress,
) -> list[Result]:
    """Return the result of every item, the same bytes whatever the workers, the chunks and the interruptions.

    Parameters
    ----------
    work
        Task, items, seed and size of the chunks.
    workers
        1 for this process, a larger number for as many new ones, an open `ProcessPool` or `DaskWorkers`; None for a
        process on every core.
    checkpoint
        Folder for finished chunks; those found there are not computed again. They stay there until
        `Checkpoint.remove`, so that an interruption before the results are safe loses nothing.
    progress
        Told the items done after every finished chunk.

    Returns
    -------
    list
        As long as the items.

    Raises
    ------
    OutputError
        If a chunk cannot be written, or the folder holds another job or is in use.
    WorkerLostError
        If the same chunk has lost a worker twice.
    InvalidParameterError
        If the task cannot be sent or its results cannot be kept. What the task raises is raised as it is; finished
        chunks are kept then too, and after Ctrl-C.
    """
    return [result for results in iter_chunks(work, workers, checkpoint, progress) for result in results]


def iter_chunks(
    work: Work,
    workers: int | Workers | None = None,
    checkpoint: Checkpoint | None = None,
    progress: Progress = no_progress,
) -> Generator[list[Result]]:
    """Yield the results chunk by chunk, in the order of the items, as soon as each chunk and those before it are done.

    Memory holds a few chunks for each worker, however long the work is. Parameters and exceptions as of `seeded_map`.

    Yields
    ------
    list
        The results of one chunk, `work.chunk_size` of them and fewer in the last.
    """
    with contextlib.ExitStack() as stack:
        shelf: _Shelf = stack.enter_context(opened(checkpoint, work)) if checkpoint else _Memory()
        kept = shelf.finished(work.chunks)
        wanted = [chunk for chunk in range(work.chunks) if chunk not in kept]
        crew = _crew(workers, len(wanted), stack)
        following = 0
        _tell(progress, work, kept)
        done = crew.finished(work, wanted, work.chunks if checkpoint else crew.ahead)
        for chunk, data in stack.enter_context(contextlib.closing(done)):
            shelf.keep(chunk, data)
            kept.add(chunk)
            _tell(progress, work, kept)
            while following in kept:
                yield unpacked(shelf.take(following))
                following += 1
        for chunk in range(following, work.chunks):  # all found in the folder
            yield unpacked(shelf.take(chunk))


class _Shelf(Protocol):
    """Where finished chunks wait for those before them."""

    def keep(self, chunk: int, data: bytes) -> None: ...

    def take(self, chunk: int) -> bytes: ...

    def finished(self, chunks: int) -> set[int]: ...


class _Memory:
    def __init__(self) -> None:
        self._waiting: dict[int, bytes] = {}

    def keep(self, chunk: int, data: bytes) -> None:
        self._waiting[chunk] = data

    def take(self, chunk: int) -> bytes:
        return self._waiting.pop(chunk)

    def finished(self, chunks: int) -> set[int]:
        del chunks
        return set()


def _crew(workers: int | Workers | None, chunks: int, stack: contextlib.ExitStack) -> Workers:
    if hasattr(workers, "finished"):
        return cast(Workers, workers)
    pool = ProcessPool(cast("int | None", workers))
    inside_a_worker = multiprocessing.current_process().daemon  # of a map over recordings, say: the cores are taken
    if pool.count == 1 or chunks == 0 or inside_a_worker:
        return ThisProcess()
    return stack.enter_context(pool)


def _tell(progress: Progress, work: Work, kept: set[int]) -> None:
    total, size = len(work.items), work.chunk_size
    missing_of_the_last = work.chunks * size - total if work.chunks - 1 in kept else 0
    progress(len(kept) * size - missing_of_the_last, total, work.name)

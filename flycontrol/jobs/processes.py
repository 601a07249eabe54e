"""Chunks done by processes of this machine, each on one thread and with its own pipe.

`concurrent.futures` ends all its workers when one is killed, does not say whose chunk it was, and can wait for ever for
the rest of a message; here a lost worker costs its own chunk, once.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import signal
from collections import Counter, deque
from collections.abc import Generator, Iterable
from importlib import import_module
from multiprocessing import connection, resource_tracker
from multiprocessing.process import BaseProcess
from typing import Protocol, cast

from flycontrol.errors import InvalidParameterError, WorkerLostError
from flycontrol.jobs import worker
from flycontrol.jobs.work import Task, Work, packed_results

_THREAD_COUNTS = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMBA_NUM_THREADS",
)  # fmt: skip


class Workers(Protocol):
    """Whoever does chunks: this process, a pool of processes, a Dask cluster."""

    @property
    def ahead(self) -> int:
        """How far chunks may run ahead of the oldest unfinished one where memory must be bounded."""
        ...

    def finished(self, work: Work, wanted: Iterable[int], ahead: int) -> Generator[tuple[int, bytes]]:
        """Yield number and packed results of the wanted chunks as they are finished, in any order."""
        ...


class ThisProcess:
    """The work is done here, chunk by chunk, on one thread as in a worker.

    A linear-algebra library on two threads adds in another order than on one, and the last bits would tell how many
    workers there were.
    """

    ahead = 1

    def finished(self, work: Work, wanted: Iterable[int], ahead: int) -> Generator[tuple[int, bytes]]:
        """Yield number and packed results of the wanted chunks, in their order."""
        from threadpoolctl import threadpool_limits

        import_module("scipy.linalg")  # brings a second BLAS, which can only be limited once it is there

        del ahead
        for chunk in wanted:
            with threadpool_limits(1):
                data = packed_results(work.task, work.items_of(chunk), work.start_of(chunk), work.seed)
            yield chunk, data


class ProcessPool:
    """Processes that stay for several maps, since each needs a second to start; they start when first needed.

    Parameters
    ----------
    count
        Number of processes; None for one on every core that this process may use.
    """

    def __init__(self, count: int | None = None) -> None:
        self._lanes = [_Lane() for _ in range(_process_count(count))]
        self._at_work = False

    @property
    def count(self) -> int:
        """Number of processes."""
        return len(self._lanes)

    @property
    def ahead(self) -> int:
        """Chunks that may run ahead of the oldest unfinished one: eight for each process."""
        return 8 * len(self._lanes)

    def __enter__(self) -> ProcessPool:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def close(self) -> None:
        """End all processes."""
        for lane in self._lanes:
            lane.stop()

    def finished(self, work: Work, wanted: Iterable[int], ahead: int) -> Generator[tuple[int, bytes]]:
        """Yield number and packed results of the wanted chunks as they are finished.

        A lost worker is replaced and its chunk done again; when this ends early, by an exception or because nobody
        asks for more, the processes still at work are ended.

        Raises
        ------
        WorkerLostError
            If the same chunk has lost a worker twice.
        InvalidParameterError
            If the task cannot be sent to another process. What the task raises is raised here.
        """
        task = _pickled(work.task)
        if self._at_work:
            raise InvalidParameterError("this pool is at work on another map; finish that first or open a second pool.")
        self._at_work = True
        queue, deaths = deque(sorted(wanted)), Counter[int]()
        try:
            while queue or self._busy():
                self._hand_out(work, task, queue, ahead)
                answers = self._answers(work, queue, deaths)
                self._hand_out(work, task, queue, ahead)  # before the caller writes what is finished
                yield from _results_then_exceptions(answers)
        finally:
            self._at_work = False
            for lane in self._busy():
                lane.stop()
            for lane in self._lanes:
                lane.told = False

    def _busy(self) -> list[_Lane]:
        return [lane for lane in self._lanes if lane.chunk is not None]

    def _hand_out(self, work: Work, task: bytes, queue: deque[int], ahead: int) -> None:
        for lane in self._lanes:
            running = [busy.chunk for busy in self._lanes if busy.chunk is not None]
            if queue and lane.chunk is None and queue[0] - min(running, default=queue[0]) < ahead:
                lane.ask(work, task, queue.popleft())

    def _answers(self, work: Work, queue: deque[int], deaths: Counter[int]) -> dict[int, bytes | Exception]:
        """Wait for some workers; return what they answer by chunk, and queue the chunks of those that died again."""
        lane_of = {lane.link: lane for lane in self._busy()}
        answers: dict[int, bytes | Exception] = {}
        for link in connection.wait([link for link in lane_of if link is not None]):
            lane = lane_of[cast(connection.Connection, link)]
            chunk, ready = cast(int, lane.chunk), lane.ready
            try:
                answer = lane.answer()
            except (EOFError, OSError):
                lane.stop()
                deaths[chunk] += 1
                if deaths[chunk] == 2:
                    answers[chunk] = WorkerLostError(_obituary(work, chunk) if ready else _NO_START)
                else:
                    queue.appendleft(chunk)
            else:
                if answer is not None:
                    answers[chunk] = answer
        return answers


def _results_then_exceptions(answers: dict[int, bytes | Exception]) -> Generator[tuple[int, bytes]]:
    """Yield what is finished before raising what went wrong, so that it can be kept."""
    for chunk, answer in answers.items():
        if isinstance(answer, bytes):
            yield chunk, answer
    for answer in answers.values():
        if isinstance(answer, Exception):
            raise answer


class _Lane:
    """One process and the pipe to it.

    Only a process that waits for a chunk is written to: a large one would block this side until it is read, and while
    the first process starts the others could not.
    """

    def __init__(self) -> None:
        self.chunk: int | None = None  #: at work on it
        self.ready = False
        self.told = False  #: the process knows the task of this map
        self.link: connection.Connection | None = None
        self._process: BaseProcess | None = None
        self._waiting = b""  #: what it is asked once it has started

    def ask(self, work: Work, task: bytes, chunk: int) -> None:
        """Start the process if there is none, and give it a chunk."""
        told = None if self.told else task
        self._waiting = pickle.dumps((told, work.items_of(chunk), work.start_of(chunk), work.seed))
        self.chunk, self.told = chunk, True
        if self.link is None:
            self._process, self.link = _start()
        elif self.ready:
            self._send()

    def answer(self) -> bytes | Exception | None:
        """Return the packed results or what the task raised, None if the process only says that it has started."""
        assert self.link is not None
        message = self.link.recv_bytes()
        if message == worker.READY:
            self.ready = True
            self._send()
            return None
        self.chunk = None
        data, error = pickle.loads(message)
        return data if error is None else error

    def _send(self) -> None:
        assert self.link is not None
        with contextlib.suppress(OSError):  # it has died: the end of its pipe will say so
            self.link.send_bytes(self._waiting)
        self._waiting = b""

    def stop(self) -> None:
        """End the process at once, in whatever it does."""
        process, link = self._process, self.link
        self.chunk, self.link, self._process = None, None, None
        self.ready = self.told = False
        if process is not None and link is not None:
            process.kill()
            process.join()
            process.close()
            link.close()


def _start() -> tuple[BaseProcess, connection.Connection]:
    context = multiprocessing.get_context("spawn")  # a fork would copy the locks of BLAS's and Numba's threads
    here, there = context.Pipe()
    process = context.Process(target=worker.serve, args=(there,), daemon=True)
    with _single_threaded_environment(), _interrupts_held_back():
        process.start()
    there.close()  # so that the pipe ends with the process
    return process, cast(connection.Connection, here)


@contextlib.contextmanager
def _single_threaded_environment() -> Generator[None]:
    """Libraries read these when they are loaded, which for the worker is before its first line."""
    before = {name: os.environ.get(name) for name in _THREAD_COUNTS}
    os.environ.update(dict.fromkeys(_THREAD_COUNTS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextlib.contextmanager
def _interrupts_held_back() -> Generator[None]:
    """Ctrl-C must not meet a worker that does not ignore it yet; it arrives here a moment later."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # started by the first process otherwise, and it lets interrupts through
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _pickled(task: Task) -> bytes:
    try:
        return pickle.dumps(task)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise InvalidParameterError(
            f"the task must be a function at the top level of a module, or a partial of one, to be sent to a worker, "
            f"got {task!r} ({error}); move it there, or use one worker."
        ) from error


def _process_count(count: int | None) -> int:
    if count is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise InvalidParameterError(f"workers must be an integer >= 1, got {count!r}.")
    return count


_NO_START = (
    "the worker processes end before they begin; a script must call from below `if __name__ == '__main__':`, "
    "and what is typed at a prompt needs one worker."
)


def _obituary(work: Work, chunk: int) -> str:
    first = work.start_of(chunk)
    last = first + len(work.items_of(chunk)) - 1
    return (
        f"{work.name} {first} to {last}: the worker process was killed twice while it did them, most likely because "
        "the memory was full; use fewer workers or smaller chunks. Finished chunks are kept if the job has a folder."
    )

"""The worker's side of a process pool: chunks in, packed results out, until the other side is gone."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import signal
import threading
import traceback
from multiprocessing import connection

from flycontrol.errors import InvalidParameterError
from flycontrol.jobs.work import Task, packed_results

READY = b""


def serve(link: connection.Connection) -> None:
    """Do chunks until the link closes.

    In: pickled (task or None for the same as before, items, start, seed), the task pickled by itself. Out: `READY`
    once, then for every chunk pickled (packed results, None) or (None, exception).
    """
    _leave_interrupts_to_the_main_process()
    threading.Thread(target=_end_with_the_main_process, daemon=True).start()
    task: Task | None = None
    with contextlib.suppress(EOFError, ConnectionError):
        link.send_bytes(READY)
        while True:
            message = link.recv_bytes()
            try:
                told, items, start, seed = pickle.loads(message)
                task = _unpickled(told) if told is not None else task
                assert task is not None
                answer = pickle.dumps((packed_results(task, items, start, seed), None))
            except Exception as error:  # whatever the task raises is raised in the main process
                answer = _packed_exception(error)
            link.send_bytes(answer)


def _unpickled(task: bytes) -> Task:
    try:
        return pickle.loads(task)
    except AttributeError as error:
        raise InvalidParameterError(
            f"a worker process does not find the task ({error}); move it to a module, or use one worker."
        ) from error


def _packed_exception(error: Exception) -> bytes:
    """Pickle an exception with its traceback as a note; one that does not survive pickling becomes a RuntimeError."""
    error.add_note(f"in a worker process:\n{''.join(traceback.format_exception(error))}")
    try:
        answer = pickle.dumps((None, error))
        pickle.loads(answer)
    except Exception:  # any constructor may refuse
        sentence = f"{type(error).__name__}: {error}"
        return pickle.dumps((None, RuntimeError(sentence)))
    return answer


def _leave_interrupts_to_the_main_process() -> None:
    """Ctrl-C reaches every process of a terminal; the main process ends the workers, without a traceback from each."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # it was blocked while this process started


def _end_with_the_main_process() -> None:
    """A worker whose main process was killed would go on with its chunk for nobody."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    connection.wait([parent.sentinel])
    os._exit(1)

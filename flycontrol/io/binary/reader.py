"""Binary files read in a process of their own, so that a damaged one ends in a sentence and not in a crash."""

from __future__ import annotations

import atexit
import os
import subprocess
import sys
import threading
from functools import cache
from types import TracebackType
from typing import BinaryIO, Self, cast

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.request import Reply, Request, read_reply, write_request

SECONDS = 120.0  #: in which any file is read
MEMORY = 16 * 2**30  #: of addresses, for the reading process [bytes]


class BinaryReader:
    """Opens files one after the other in one process, and starts another process when a file ended it.

    Its process ends with it, and with this process in any case, since its input ends.
    """

    def __init__(self, *, seconds: float = SECONDS, memory: int = MEMORY) -> None:
        self._limits = (seconds, memory)
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def read(self, request: Request) -> Reply:
        """Read what is asked for.

        Raises
        ------
        InvalidInputError
            If the file is damaged, if it lacks what is asked for, or if reading it needs too much time or memory.
        """
        with self._lock:
            reply = self._reply(request)
        if reply.refusal:
            raise InvalidInputError(reply.refusal)
        return reply

    def close(self) -> None:
        """End the process."""
        self._end()

    def _reply(self, request: Request) -> Reply:
        process = self._running()
        try:
            write_request(request, cast(BinaryIO, process.stdin))
            return read_reply(cast(BinaryIO, process.stdout))
        except (EOFError, BrokenPipeError) as error:
            raise InvalidInputError(self._last_words(request, process)) from error
        except BaseException:  # interrupted between question and answer: the next answer would be the wrong one
            self._end()
            raise

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            seconds, memory = self._limits
            command = [sys.executable, "-P", "-m", "flycontrol.io.binary.child", str(seconds), str(memory)]
            environment = os.environ | {
                "PYTHONPATH": os.pathsep.join(path or os.curdir for path in sys.path),
                "HDF5_USE_FILE_LOCKING": "FALSE",  # which fails on many read-only and network file systems
                "OPENBLAS_NUM_THREADS": "1",  # its threads would take the memory that is limited
            }
            self._process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
            )
        return self._process

    def _last_words(self, request: Request, process: subprocess.Popen[bytes]) -> str:
        status = process.wait()
        self._end()
        if status == 1:  # by the watch
            what = f"took longer than {self._limits[0]:g} s to read; it is damaged or too large"
        else:
            what = f"made the library that reads {request.form} files crash; it is damaged"
        return f"{request.name} {what}: export it again."

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        process.kill()
        process.communicate()


def shared_reader() -> BinaryReader:
    """Return the reader of this process: its own process starts with the first file and serves all that follow."""
    return _reader_of(os.getpid())  # a fork must not share the pipes


@cache
def _reader_of(process: int) -> BinaryReader:
    del process
    reader = BinaryReader()
    atexit.register(reader.close)
    return reader

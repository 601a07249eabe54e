"""The end of what a process says: kept while it runs, so that a hanging one is heard and a flood fills no disk."""

from __future__ import annotations

import os
import subprocess
import threading
from typing import IO

END = 64 * 1024  #: bytes of the end that are kept
_PATIENCE = 1.0  # for the last words of a process that has ended but left another one holding the pipe [s]


class Said:
    """What a process writes to its standard output and standard error, in the order in which it arrives."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        assert process.stdout is not None
        assert process.stderr is not None
        self._lock = threading.Lock()
        self._everything, self._errors = _Tail(), _Tail()
        self._readers = [
            threading.Thread(target=self._read, args=(process.stdout, [self._everything]), daemon=True),
            threading.Thread(target=self._read, args=(process.stderr, [self._everything, self._errors]), daemon=True),
        ]
        for reader in self._readers:
            reader.start()

    def finish(self) -> None:
        """Hear out a process that has ended."""
        for reader in self._readers:
            reader.join(_PATIENCE)

    def everything(self) -> bytes:
        """The end of all that it has said so far."""
        with self._lock:
            return self._everything.end()

    def errors(self) -> str:
        """The end of its standard error."""
        with self._lock:
            return self._errors.end().decode("utf-8", errors="replace")

    def _read(self, stream: IO[bytes], tails: list[_Tail]) -> None:
        with stream:
            while said := os.read(stream.fileno(), END):
                with self._lock:
                    for tail in tails:
                        tail.add(said)


class _Tail:
    """The last bytes of many."""

    def __init__(self) -> None:
        self._kept, self._left_out = bytearray(), 0

    def add(self, said: bytes) -> None:
        self._kept += said
        if len(self._kept) > 2 * END:
            self._cut()

    def end(self) -> bytes:
        if len(self._kept) > END:
            self._cut()
        head = b"[%d bytes before these are left out]\n" % self._left_out if self._left_out else b""
        return head + bytes(self._kept)

    def _cut(self) -> None:
        over = len(self._kept) - END
        self._left_out += over
        del self._kept[:over]

"""A file for HDF5 to write in that keeps failures of the disk to itself until it is asked."""

from __future__ import annotations

import os
from io import RawIOBase
from pathlib import Path
from typing import Any

from flycontrol.errors import OutputError


class HeldFile(RawIOBase):
    """A file for reading and writing that keeps the first failure instead of raising it.

    HDF5 cannot recover from a write that fails in the midst of its own bookkeeping: its later attempts to close the
    file crash the process. It is told that all is well, and whoever writes asks `require_room` after every piece.

    Parameters
    ----------
    path
        The file, which must not exist yet.
    name
        What a refusal calls it.
    """

    def __init__(self, path: Path, name: str) -> None:
        super().__init__()
        self._name = name
        self._raw = path.open("xb+", buffering=0)
        self._failure: BaseException | None = None

    def require_room(self) -> None:
        """Raise OutputError if anything could not be written so far."""
        if isinstance(self._failure, OSError):
            reason = self._failure.strerror or str(self._failure)
            raise OutputError(f"{self._name} could not be written: {reason}.") from self._failure
        if self._failure is not None:  # Ctrl-C, which must not reach HDF5 either
            raise self._failure

    def finish(self) -> None:
        """Bring all of it to the disk; OutputError if it does not fit."""
        self.require_room()
        try:
            os.fsync(self._raw.fileno())
        except OSError as failure:
            self._failure = failure
        self.require_room()

    def readable(self) -> bool:
        """Yes."""
        return True

    def writable(self) -> bool:
        """Yes."""
        return True

    def seekable(self) -> bool:
        """Yes."""
        return True

    def seek(self, offset: int, whence: int = 0, /) -> int:
        """Go to a place."""
        return self._raw.seek(offset, whence)

    def tell(self) -> int:
        """Where it is."""
        return self._raw.tell()

    def readinto(self, buffer: Any, /) -> int | None:
        """Read as much as is there."""
        return self._raw.readinto(buffer)

    def write(self, data: Any, /) -> int:
        """Write all of it, or note why not."""
        left = memoryview(data).cast("B")
        size = len(left)
        try:
            while left and self._failure is None:
                left = left[self._raw.write(left) :]
        except BaseException as failure:
            self._failure = failure
        return size

    def truncate(self, size: int | None = None, /) -> int:
        """Cut or lengthen, or note why not."""
        try:
            if self._failure is None:
                self._raw.truncate(size)
        except BaseException as failure:
            self._failure = failure
        return self._raw.tell() if size is None else size

    def close(self) -> None:
        """Let go of the file."""
        self._raw.close()
        super().close()

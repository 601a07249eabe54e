"""A folder for one job at a time."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Generator
from pathlib import Path

from flycontrol.errors import OutputError


@contextlib.contextmanager
def locked_folder(folder: Path) -> Generator[None]:
    """Make the folder and keep other processes out; the lock opens when this process ends, however it ends.

    Raises
    ------
    OutputError
        If the folder cannot be created, or is in use by another process.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder} cannot be created for unfinished work ({error.strerror or error}).") from error
    if sys.platform == "win32":  # has no locks on folders
        yield
        return
    import fcntl

    descriptor = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            sentence = f"{folder} is in use by another process; wait for it or choose another folder."
            raise OutputError(sentence) from None
        except OSError:  # a file system without locks: two jobs at once would write the same bytes twice
            pass
        yield
    finally:
        os.close(descriptor)

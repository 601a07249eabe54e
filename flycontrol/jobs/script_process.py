"""The process of a script: python -m flycontrol.jobs.script_process SCRIPT FOLDER, ended when its standard input is.

The script itself finds an empty standard input: one that reads goes on at once.
"""

from __future__ import annotations

import os
import runpy
import signal
import sys
import threading
from pathlib import Path


def main() -> None:
    """Run the script as Python would; everything ends at once when the asking process is gone."""
    script, folder = sys.argv[1:]
    threading.Thread(target=_end_with_the_asking_process, args=(_asking_process(),), daemon=True).start()
    sys.argv = [script, folder]
    sys.path[0] = str(Path(script).resolve().parent)
    runpy.run_path(script, run_name="__main__")


def _asking_process() -> int:
    """The pipe from it, out of the script's reach: an empty input takes its place."""
    pipe, empty = os.dup(0), os.open(os.devnull, os.O_RDONLY)
    os.dup2(empty, 0)
    os.close(empty)
    return pipe


def _end_with_the_asking_process(pipe: int) -> None:
    """A killed process can pass nothing on, but its end of the pipe closes."""
    while os.read(pipe, 1):
        pass
    if hasattr(os, "killpg") and os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


if __name__ == "__main__":
    main()

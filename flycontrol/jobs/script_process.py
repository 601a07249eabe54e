"""The process of a script: python -m flycontrol.jobs.script_process SCRIPT FOLDER, ended when its standard input is."""

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
    threading.Thread(target=_end_with_the_asking_process, daemon=True).start()
    sys.argv = [script, folder]
    sys.path[0] = str(Path(script).resolve().parent)
    runpy.run_path(script, run_name="__main__")


def _end_with_the_asking_process() -> None:
    """A killed process can pass nothing on, but its end of the pipe closes."""
    while os.read(sys.stdin.fileno(), 1):
        pass
    if hasattr(os, "killpg") and os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


if __name__ == "__main__":
    main()

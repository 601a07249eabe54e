"""One run of a script: its process, how it ended, and what it said last."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from flycontrol.jobs.said import Said

_ONE_THREAD = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMBA_NUM_THREADS",
)  # fmt: skip


@dataclass(slots=True)
class ScriptRun:
    """A script at work."""

    process: subprocess.Popen[bytes]
    own: Path  #: folder of this run alone
    said: Said  #: on standard output and standard error
    started: float  #: by the clock of `time.perf_counter` [s]
    seconds: float = 0.0  #: wall time, once it is over [s]
    overdue: str = ""  #: that it was ended for taking too long

    @property
    def results(self) -> Path:
        """Folder that it writes to."""
        return self.own / "results"

    def has_ended(self) -> bool:
        """Look; the first time that it has, its wall time is taken."""
        if self.process.poll() is None:
            return False
        self.seconds = self.seconds or time.perf_counter() - self.started
        return True

    def end_if_longer_than(self, limit: float) -> None:
        """End it if it has taken longer [s]."""
        if not self.has_ended() and time.perf_counter() - self.started > limit:
            self.overdue = f"it was ended after {limit:g} s"
            self.end()

    def end(self) -> None:
        """End it at once if it is at work, in whatever it does, its own processes too."""
        if not self.has_ended():
            with contextlib.suppress(OSError):
                if hasattr(os, "killpg"):
                    os.killpg(self.process.pid, signal.SIGKILL)
                else:
                    self.process.kill()
            self.process.wait()
        if self.process.stdin is not None:
            self.process.stdin.close()
        self.said.finish()

    def failure(self) -> str:
        """What it said last on standard error, or how else it ended; empty if it finished with results."""
        status = self.process.returncode
        if self.overdue:
            return self.overdue
        if status == 0:
            return "" if any(path.is_file() for path in self.results.rglob("*")) else "it wrote no results"
        if status < 0:
            return f"it was killed by signal {-status}"
        self.said.finish()
        return last_words(self.said.errors()) or f"it ended with status {status}"


def started(script: Path, own: Path, environment: Mapping[str, str]) -> ScriptRun:
    """Start a script in a session of its own, for Ctrl-C is ours to pass on; its results go to `own`/results."""
    run_folder = own / "results"
    run_folder.mkdir()
    process = subprocess.Popen(
        [sys.executable, "-m", "flycontrol.jobs.script_process", str(script), str(run_folder)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**_surroundings(), **environment}, start_new_session=True,
    )  # fmt: skip
    return ScriptRun(process=process, own=own, said=Said(process), started=time.perf_counter())


def last_words(said: str) -> str:
    """The message of the exception that ended a script, all its lines in one, or else the last line."""
    lines = [line.rstrip() for line in said.splitlines() if line.strip()]
    inside = [k for k, line in enumerate(lines) if re.match(r"  File \".*\", line \d+", line)]
    message = lines[inside[-1] + 1 :] if inside else lines[-1:]
    while inside and len(message) > 1 and message[0].startswith("    "):  # the line of code and the mark below it
        message = message[1:]
    return " ".join(line.strip() for line in message)


def _surroundings() -> dict[str, str]:
    """Variables of this process, one thread a script, no screen, this very package first on the path.

    What a script prints is passed on at once: one that hangs and is ended would take it along.
    """
    here = str(Path(__file__).resolve().parents[2])
    paths = os.pathsep.join([here, *filter(None, [os.environ.get("PYTHONPATH")])])
    plain = {"MPLBACKEND": "Agg", "PYTHONPATH": paths, "PYTHONUNBUFFERED": "1"}
    return {**os.environ, **dict.fromkeys(_ONE_THREAD, "1"), **plain}

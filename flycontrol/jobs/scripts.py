"""Python scripts, each a process of its own, a few at a time; what finished ones wrote is kept and not made again."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from flycontrol.errors import InvalidParameterError
from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.folder_lock import locked_folder
from flycontrol.jobs.progress import Progress, no_progress

_PAUSE = 0.05  #: between two looks at the running ones [s]
_ONE_THREAD = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMBA_NUM_THREADS",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Script:
    """A Python file that writes all its results into the folder named by its only argument."""

    path: Path
    folder: Path  #: where its results shall lie in the end
    identity: str  #: all that the results depend on: hashes of the file, of what it imports, of its data

    @property
    def name(self) -> str:
        """Of the file, without its ending."""
        return self.path.stem


@dataclass(frozen=True, slots=True)
class ScriptEnd:
    """How a script ended."""

    name: str
    failure: str  #: last line that it wrote on standard error; empty if it finished
    seconds: float  #: wall time of the run that made the results [s]
    kept: bool = False  #: an earlier run had finished it


@dataclass(frozen=True, slots=True)
class Kept:
    """A folder that remembers which scripts have finished, and by the bytes of their results that they still stand."""

    folder: Path

    def find(self, script: Script) -> ScriptEnd | None:
        """Return how the script ended before, if it is the same script and its results are still there."""
        try:
            note = json.loads(self._note(script).read_bytes())
            same = note["identity"] == script.identity and note["results"]
            if same and all(_sha256(script.folder / name) == found for name, found in note["results"].items()):
                return ScriptEnd(script.name, "", float(note["seconds"]), kept=True)
        except (OSError, ValueError, KeyError, TypeError, AttributeError):  # none, torn, or not ours: run it again
            return None
        return None

    def keep(self, script: Script, results: Mapping[str, bytes], seconds: float) -> None:
        """Remember that a script has finished, once its results lie in their folder."""
        note = {
            "identity": script.identity,
            "seconds": round(seconds, 3),
            "results": {name: hashlib.sha256(data).hexdigest() for name, data in results.items()},
        }
        write_files_atomically(self.folder, {self._note(script).name: json.dumps(note, indent=1) + "\n"})

    def _note(self, script: Script) -> Path:
        return self.folder / f"{script.name}.json"


def run_scripts(
    scripts: Sequence[Script],
    kept: Path,
    *,
    at_once: int = 1,
    environment: Mapping[str, str] | None = None,
    progress: Progress = no_progress,
) -> list[ScriptEnd]:
    """Run scripts, `at_once` processes at a time, in their order; each on one thread.

    A script writes into a folder that is thrown away if it fails or is interrupted; what a finished one wrote appears
    in its own folder at once. A script that fails hinders no other. After an interruption the finished ones are kept;
    where this process is killed, the scripts end with it.

    Parameters
    ----------
    scripts
        Of different names.
    kept
        Folder that remembers finished ones; used by one run at a time.
    at_once
        Processes.
    environment
        Variables that the scripts see beside those of this process.
    progress
        Told the scripts done after every one.

    Returns
    -------
    list of ScriptEnd
        In the order of the scripts.

    Raises
    ------
    OutputError
        If results cannot be written, or the folder of what is kept is in use.
    InvalidParameterError
        If two scripts have the same name, or fewer than one process is asked for.
    """
    if at_once < 1 or len({script.name for script in scripts}) < len(scripts):
        raise InvalidParameterError(f"run_scripts needs at_once >= 1 and different names, got {at_once} and {scripts}.")
    with locked_folder(kept):
        for torn in kept.glob(".*.part"):  # of a run that was killed
            shutil.rmtree(torn, ignore_errors=True)
        shelf = Kept(kept)
        ends = {script.name: end for script in scripts if (end := shelf.find(script)) is not None}
        waiting = deque(script for script in scripts if script.name not in ends)
        progress(len(ends), len(scripts), _at_work(list(waiting)[:at_once]))
        with _crew(shelf, environment or {}) as crew:
            while waiting or crew.running:
                while waiting and len(crew.running) < at_once:
                    crew.start(waiting.popleft())
                for end in crew.ended():
                    ends[end.name] = end
                    coming = [*(run.script for run in crew.running), *waiting]
                    progress(len(ends), len(scripts), _at_work(coming[:at_once]))
                time.sleep(_PAUSE)
    return [ends[script.name] for script in scripts]


def _at_work(scripts: Iterable[Script]) -> str:
    return ", ".join(script.name for script in scripts) or "finished"


@dataclass(slots=True)
class _Run:
    """A script at work."""

    script: Script
    process: subprocess.Popen[bytes]
    folder: Path  #: that it writes to
    said: Path  #: its standard error
    started: float = field(default_factory=time.perf_counter)

    def hang_up(self) -> None:
        """Close the pipe by which the script would see this process end."""
        if self.process.stdin is not None:
            self.process.stdin.close()

    def failure(self) -> str:
        """Last line of its standard error, or how else it ended; empty if it finished with results."""
        status = self.process.returncode
        if status == 0:
            return "" if any(path.is_file() for path in self.folder.rglob("*")) else "it wrote no results"
        if status < 0:
            return f"it was killed by signal {-status}"
        lines = [line.strip() for line in self.said.read_text(encoding="utf-8", errors="replace").splitlines()]
        return next((line for line in reversed(lines) if line), f"it ended with status {status}")


@dataclass(slots=True)
class _Crew:
    """The scripts at work."""

    shelf: Kept
    environment: Mapping[str, str]
    running: list[_Run] = field(default_factory=list[_Run])

    def start(self, script: Script) -> None:
        """Start one, in a session of its own: Ctrl-C is ours to pass on."""
        own = Path(tempfile.mkdtemp(prefix=f".{script.name}.", suffix=".part", dir=self.shelf.folder))
        folder, said = own / "results", own / "stderr"
        folder.mkdir()
        with said.open("wb") as errors:
            process = subprocess.Popen(
                [sys.executable, "-m", "flycontrol.jobs.script_process", str(script.path), str(folder)],
                stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=errors,
                env={**_surroundings(), **self.environment}, start_new_session=True,
            )  # fmt: skip
        self.running.append(_Run(script, process, folder, said))

    def ended(self) -> list[ScriptEnd]:
        """Take those that have ended; the results of finished ones go to their folders."""
        done = [run for run in self.running if run.process.poll() is not None]
        return [self._take(run) for run in done]

    def _take(self, run: _Run) -> ScriptEnd:
        seconds, failure = time.perf_counter() - run.started, run.failure()
        if not failure:
            results = {
                path.relative_to(run.folder).as_posix(): path.read_bytes()
                for path in sorted(run.folder.rglob("*"))
                if path.is_file()
            }
            write_files_atomically(run.script.folder, results)
            self.shelf.keep(run.script, results, seconds)
        self.running.remove(run)
        run.hang_up()
        shutil.rmtree(run.folder.parent, ignore_errors=True)
        return ScriptEnd(run.script.name, failure, seconds)

    def stop(self) -> None:
        """End all at once, in whatever they do, their own processes too."""
        for run in self.running:
            with contextlib.suppress(OSError):
                if hasattr(os, "killpg"):
                    os.killpg(run.process.pid, signal.SIGKILL)
                else:
                    run.process.kill()
            run.process.wait()
            run.hang_up()
            shutil.rmtree(run.folder.parent, ignore_errors=True)


@contextlib.contextmanager
def _crew(shelf: Kept, environment: Mapping[str, str]) -> Generator[_Crew]:
    crew = _Crew(shelf, environment)
    try:
        yield crew
    finally:
        crew.stop()


def _surroundings() -> dict[str, str]:
    """Variables of this process, one thread a script, no screen, and this very package first on the path."""
    here = str(Path(__file__).resolve().parents[2])
    paths = os.pathsep.join([here, *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, **dict.fromkeys(_ONE_THREAD, "1"), "MPLBACKEND": "Agg", "PYTHONPATH": paths}


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()

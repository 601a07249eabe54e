"""Python scripts, each a process of its own, a few at a time; what finished ones wrote is kept and not made again."""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import shutil
import tempfile
import time
from collections import deque
from collections.abc import Collection, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from flycontrol.errors import InvalidParameterError
from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.folder_lock import locked_folder
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.jobs.script_run import ScriptRun, started

_PAUSE = 0.05  #: between two looks at the running ones [s]


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
    failure: str  #: what it said last on standard error, or how else it ended; empty if it finished
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

    def stale(self, name: str, folder: Path, results: Collection[str] = ()) -> list[Path]:
        """Files in a script's folder that its last finished run left as they are, without those written again."""
        try:
            before = json.loads((self.folder / f"{name}.json").read_bytes())["results"]
            old = {folder / file: found for file, found in before.items() if file not in results and _inside(file)}
            return [path for path, found in old.items() if path.is_file() and _sha256(path) == found]
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return []

    def forget(self, name: str, folder: Path) -> None:
        """Remove what a script's last finished run left in its folder, unless somebody changed it, and its note."""
        for path in self.stale(name, folder):
            _remove(path, folder)
        with contextlib.suppress(OSError):
            (self.folder / f"{name}.json").unlink(missing_ok=True)

    def keep(self, script: Script, results: Mapping[str, bytes], seconds: float) -> None:
        """Remember that a script has finished, once its results lie in their folder."""
        note = {
            "identity": script.identity,
            "seconds": round(seconds, 3),
            "results": {name: hashlib.sha256(data).hexdigest() for name, data in results.items()},
        }
        write_files_atomically(self.folder, {self._note(script).name: json.dumps(note, indent=1) + "\n"})

    def log(self, name: str) -> Path:
        """Where the end of what a failed script said is kept."""
        return self.folder / f"{name}.log"

    def _note(self, script: Script) -> Path:
        return self.folder / f"{script.name}.json"


def run_scripts(
    scripts: Sequence[Script],
    kept: Path,
    *,
    at_once: int = 1,
    environment: Mapping[str, str] | None = None,
    limit: float = math.inf,
    progress: Progress = no_progress,
) -> list[ScriptEnd]:
    """Run scripts, `at_once` processes at a time, in their order; each on one thread.

    A script writes into a folder that is thrown away if it fails or is interrupted; what a finished one wrote appears
    in its own folder at once, and what it left there is removed, if nobody changed it, when it fails later: old results
    must not pass for new ones. A script that fails hinders no other. After an interruption the finished ones are kept;
    where this process is killed, the scripts end with it. Scripts find an empty standard input.

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
    limit
        Wall time after which a script is ended and has failed [s].
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
        with _crew(_Crew(shelf, environment or {}, limit)) as crew:
            while waiting or crew.running:
                while waiting and len(crew.running) < at_once:
                    crew.start(waiting.popleft())
                for end in crew.ended():
                    ends[end.name] = end
                    coming = [*(script for script, _ in crew.running), *waiting]
                    progress(len(ends), len(scripts), _at_work(coming[:at_once]))
                time.sleep(_PAUSE)
    return [ends[script.name] for script in scripts]


def forget_other_scripts(kept: Path, known: Collection[str], reports: Path) -> None:
    """Remove what scripts that there are no more left in their folders, each of its name within `reports`.

    Only files that the folder of what is kept has a note of, and as they were written.

    Raises
    ------
    OutputError
        If the folder of what is kept is in use.
    """
    with locked_folder(kept):
        shelf = Kept(kept)
        for note in sorted(kept.glob("*.json")):
            if note.stem not in known and shelf.stale(note.stem, reports / note.stem):
                shelf.forget(note.stem, reports / note.stem)


def _at_work(scripts: Iterable[Script]) -> str:
    return ", ".join(script.name for script in scripts) or "finished"


@dataclass(slots=True)
class _Crew:
    """The scripts at work."""

    shelf: Kept
    environment: Mapping[str, str]
    limit: float  #: for each [s]
    running: list[tuple[Script, ScriptRun]] = field(default_factory=list[tuple[Script, ScriptRun]])

    def start(self, script: Script) -> None:
        """Start one; it writes into a folder that is thrown away in the end."""
        own = Path(tempfile.mkdtemp(prefix=f".{script.name}.", suffix=".part", dir=self.shelf.folder))
        self.running.append((script, started(script.path, own, self.environment)))

    def ended(self) -> list[ScriptEnd]:
        """Take those that have ended; the results of finished ones go to their folders."""
        for _, run in self.running:
            run.end_if_longer_than(self.limit)
        done = [(script, run) for script, run in self.running if run.has_ended()]
        return [self._take(script, run) for script, run in done]

    def _take(self, script: Script, run: ScriptRun) -> ScriptEnd:
        failure = run.failure()
        log = self.shelf.log(script.name)
        if failure:
            log.write_bytes(run.said.everything() or f"It said nothing: {failure}.\n".encode())
            self.shelf.forget(script.name, script.folder)
        else:
            self._hand_over(script, run)
            log.unlink(missing_ok=True)
        self.running.remove((script, run))
        run.end()
        shutil.rmtree(run.own, ignore_errors=True)
        return ScriptEnd(script.name, failure, run.seconds)

    def _hand_over(self, script: Script, run: ScriptRun) -> None:
        results = {
            path.relative_to(run.results).as_posix(): path.read_bytes()
            for path in sorted(run.results.rglob("*"))
            if path.is_file()
        }
        stale = self.shelf.stale(script.name, script.folder, results)
        write_files_atomically(script.folder, results)
        for path in stale:
            _remove(path, script.folder)
        self.shelf.keep(script, results, run.seconds)

    def stop(self) -> None:
        """End all at once."""
        for _, run in self.running:
            run.end()
            shutil.rmtree(run.own, ignore_errors=True)


@contextlib.contextmanager
def _crew(crew: _Crew) -> Generator[_Crew]:
    try:
        yield crew
    finally:
        crew.stop()


def _inside(name: str) -> bool:
    """Whether a noted file lies within its folder."""
    return not Path(name).is_absolute() and ".." not in Path(name).parts


def _remove(path: Path, folder: Path) -> None:
    """A file, and folders down to `folder` that are empty then."""
    with contextlib.suppress(OSError):
        path.unlink(missing_ok=True)
        for parent in path.parents:
            parent.rmdir()
            if parent == folder:
                break


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()

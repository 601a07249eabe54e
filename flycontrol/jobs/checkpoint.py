"""A folder of finished chunks: each its own file, there whole or not at all, and known to belong to this job."""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Generator, Sized
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Protocol

from flycontrol.errors import InvalidParameterError, OutputError
from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.folder_lock import locked_folder

_JOB = "job.json"
_READABLE = 40  #: characters
_DIGEST = hashlib.sha256().digest_size


class Divided(Protocol):
    """Work in chunks: a `Work`, or one whose chunks follow from one another."""

    @property
    def seed(self) -> int:
        """Of all that is drawn at random."""
        ...

    @property
    def items(self) -> Sized:
        """What is to be done."""
        ...

    @property
    def chunk_size(self) -> int:
        """Items in every chunk but the last."""
        ...


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """Where a job keeps its finished chunks, and what makes it this job and no other.

    Raises
    ------
    InvalidParameterError
        If the identity is empty: chunks of another input could then be taken for this one's.
    """

    folder: Path  #: used by this job alone; created with its parents
    identity: str  #: all that the results depend on besides the seed: hashes of the inputs, options

    def __post_init__(self) -> None:
        if not self.identity:
            raise InvalidParameterError(
                "Checkpoint.identity must say what the results depend on (hashes of the inputs, options), got ''."
            )

    def remove(self) -> None:
        """Remove the chunks once their results are safe elsewhere; the folder too if nothing else is in it."""
        for path in (*self.folder.glob("chunk-*.npz"), self.folder / _JOB):
            path.unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            self.folder.rmdir()


@dataclass(frozen=True, slots=True)
class ChunkFiles:
    """Packed chunks by number, as files that carry a digest of job, number and content."""

    folder: Path
    job: bytes  #: digest of all that makes the job this job

    def keep(self, chunk: int, data: bytes) -> None:
        """Write one finished chunk under a temporary name and rename it; raise OutputError if it cannot be written."""
        write_files_atomically(self.folder, {self._name(chunk): data + self._digest(chunk, data)})

    def take(self, chunk: int) -> bytes:
        """Return a finished chunk; raise OutputError if its file is missing or damaged."""
        path = self.folder / self._name(chunk)
        try:
            content = path.read_bytes()
        except OSError as error:
            raise OutputError(f"{path} cannot be read ({error.strerror or error}); run the same job again.") from error
        data = content[:-_DIGEST]
        if content[-_DIGEST:] != self._digest(chunk, data):
            raise OutputError(f"{path} is damaged; run the same job again, it recomputes this chunk.")
        return data

    def finished(self, chunks: int) -> set[int]:
        """Return the numbers of the chunks that stand complete and undamaged; the rest is to be computed."""
        found: set[int] = set()
        for chunk in range(chunks):
            with contextlib.suppress(OutputError):
                self.take(chunk)
                found.add(chunk)
        return found

    def _digest(self, chunk: int, data: bytes) -> bytes:
        digest = hashlib.sha256(self.job + chunk.to_bytes(8, "big"))
        digest.update(data)
        return digest.digest()

    @staticmethod
    def _name(chunk: int) -> str:
        return f"chunk-{chunk:06d}.npz"


@contextlib.contextmanager
def opened(checkpoint: Checkpoint, work: Divided) -> Generator[ChunkFiles]:
    """Hold the folder for this job alone.

    Raises
    ------
    OutputError
        If the folder cannot be written, holds another job's chunks, or is in use by another process.
    """
    job = _description(checkpoint, work)
    folder = checkpoint.folder
    with locked_folder(folder):
        _require_same_job(folder, job)
        for torn in (*folder.glob(".chunk-*.part"), *folder.glob(f".{_JOB}.*.part")):  # of a process killed in a write
            torn.unlink(missing_ok=True)
        if not (folder / _JOB).exists():
            write_files_atomically(folder, {_JOB: json.dumps(job, indent=2) + "\n"})
        yield ChunkFiles(folder, hashlib.sha256(json.dumps(job).encode()).digest())


def _description(checkpoint: Checkpoint, work: Divided) -> dict[str, object]:
    return {
        "identity": checkpoint.identity,
        "seed": int(work.seed),
        "items": len(work.items),
        "chunk": work.chunk_size,
        "flycontrol": version("flycontrol"),
        "numpy": version("numpy"),
    }


def _require_same_job(folder: Path, job: dict[str, object]) -> None:
    try:
        found = json.loads((folder / _JOB).read_bytes())
    except FileNotFoundError:
        if any(folder.glob("chunk-*.npz")):
            raise OutputError(f"{folder} holds chunks but no {_JOB}; {_way_out(folder)}") from None
        return
    except (OSError, ValueError) as error:
        raise OutputError(f"{folder / _JOB} cannot be read ({error}); {_way_out(folder)}") from error
    if found == job:
        return
    found = found if isinstance(found, dict) else {}
    differing = [_difference(key, found.get(key), value) for key, value in job.items() if found.get(key) != value]
    raise OutputError(f"{folder} holds the chunks of another job ({', '.join(differing)}); {_way_out(folder)}")


def _difference(key: str, found: object, value: object) -> str:
    if len(str(value)) > _READABLE:  # a digest tells a reader nothing
        return f"other {key}: input or options differ"
    return f"{key} {found!r} instead of {value!r}"


def _way_out(folder: Path) -> str:
    return f"choose another folder, or remove {folder} to start afresh."

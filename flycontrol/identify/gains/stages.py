"""The parts of a long study: one crew of workers, and for each part a folder of its own for finished chunks."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from flycontrol.identify.gains.labour import Labour
from flycontrol.identify.gains.model import GainModel
from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.jobs.processes import Workers
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.model.trial import TorqueTrace, Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class Stages:
    """Who does the parts of a study, where what is finished is kept, and who is told; none of it changes a result."""

    workers: int | Workers | None = 1  #: processes, an open pool or Dask workers; None: a process on every core
    folder: Path | None = None  #: for finished chunks, in a subfolder for each part; None keeps nothing
    progress: Progress = no_progress

    def labour(self, stage: str, identity: str) -> Labour:
        """Labour for one part; what it is made from must be in the identity."""
        kept = None if self.folder is None else Checkpoint(self.folder / stage, identity)
        return Labour(workers=self.workers, checkpoint=kept, progress=self.progress)

    def unkept(self) -> Labour:
        """Labour for parts that are quick to do again."""
        return Labour(workers=self.workers, progress=self.progress)

    def within(self, part: str) -> Stages:
        """The same for one of several studies, its parts in a folder of their own."""
        return self if self.folder is None else replace(self, folder=self.folder / part)

    def clear(self) -> None:
        """Remove all that was kept, once the results are safe."""
        if self.folder is None or not self.folder.is_dir():
            return
        for part in sorted(self.folder.rglob("*"), reverse=True):  # the innermost first
            if part.is_dir():
                Checkpoint(part, "any").remove()
        with contextlib.suppress(OSError):
            self.folder.rmdir()


def identity_of(trials: Sequence[Trial], model: GainModel, *options: object) -> str:
    """A digest of everything that a study's results depend on."""
    digest = hashlib.sha256(repr((model, options)).encode())
    for trial in trials:
        pulse = trial.perturbation
        digest.update(repr((trial.name, trial.fly, trial.rate)).encode())
        for channel in (trial.time, trial.yaw, trial.paddling):
            digest.update(b"" if channel is None else channel.tobytes())
        if isinstance(pulse, TorqueTrace):
            digest.update(pulse.time.tobytes() + pulse.drive.tobytes())
            digest.update(repr(pulse.angular_acceleration_per_unit).encode())
        else:
            digest.update(repr(pulse).encode())
    return digest.hexdigest()

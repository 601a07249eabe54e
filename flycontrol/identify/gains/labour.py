"""Who does long work, where finished parts are kept, and who is told."""

from __future__ import annotations

from dataclasses import dataclass, replace

from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.jobs.packed import Result
from flycontrol.jobs.processes import Workers
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.jobs.seeded_map import seeded_map
from flycontrol.jobs.work import Work


@dataclass(frozen=True, slots=True, kw_only=True)
class Labour:
    """Arguments of `jobs.seeded_map` that do not change the result."""

    workers: int | Workers | None = 1  #: processes, an open pool or Dask workers; None: a process on every core
    checkpoint: Checkpoint | None = None  #: an interrupted run goes on where it was
    progress: Progress = no_progress

    def done(self, work: Work) -> list[Result]:
        """The results of all items."""
        return seeded_map(work, self.workers, self.checkpoint, self.progress)

    def on(self, part: str) -> Labour:
        """The same for one of several jobs, its finished parts kept in a folder of their own."""
        kept = self.checkpoint
        if kept is None:
            return self
        return replace(self, checkpoint=Checkpoint(kept.folder / part, f"{kept.identity} {part}"))


HERE = Labour()  #: in this process, nothing kept

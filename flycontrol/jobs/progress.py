"""How long work tells how far it is, without knowing who listens."""

from __future__ import annotations

from typing import Protocol


class Progress(Protocol):
    """Called after every finished part of a long job."""

    def __call__(self, done: int, total: int, what: str) -> None:
        """Report that `done` of `total` parts of the work named `what` are finished."""
        ...


def no_progress(done: int, total: int, what: str) -> None:
    """Listen to nothing: the default where nobody waits."""
    del done, total, what

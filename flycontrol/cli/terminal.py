"""What every command says on the terminal: sentences, progress bars, a mapping to edit."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from flycontrol.errors import InvalidInputError

if TYPE_CHECKING:
    from flycontrol.jobs.progress import Progress


class WorkInterruptedError(Exception):
    """Ctrl-C during a job that keeps what is finished; the message says what is kept and how to go on."""


def say(sentence: str) -> None:
    """Write one line on stderr."""
    typer.echo(f"flycontrol: {' '.join(sentence.split())}", err=True)


def refusal_with_a_mapping_to_edit(path: Path) -> InvalidInputError:
    """Print what the file holds as a mapping to edit, on stdout; what the numbers mean is never guessed."""
    from flycontrol.io.description import fitting_mappings, suggest_mapping

    typer.echo(suggest_mapping(path))
    fits = " or ".join(f"--mapping {name}" for name in fitting_mappings(path))
    ready = f"a shipped mapping fits: if it is such a recording, add {fits}; otherwise " if fits else ""
    return InvalidInputError(
        f"{path}: no --mapping says what its numbers mean; {ready}edit the mapping printed above and give it "
        "by --mapping."
    )


@contextmanager
def progress_bar() -> Generator[Progress]:
    """Show how far the work is, on stderr, where somebody watches a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bars

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    console = Console(stderr=True)
    with Bars(*columns, console=console, transient=True, disable=not console.is_terminal) as bars:
        task = bars.add_task("", total=None)

        def progress(done: int, total: int, what: str) -> None:
            bars.update(task, completed=done, total=total, description=what)

        yield progress


@contextmanager
def kept_when_interrupted(folder: Path | None) -> Generator[None]:
    """Say what an interruption leaves."""
    try:
        yield
    except KeyboardInterrupt:
        if folder is None or not folder.exists():
            raise
        raise WorkInterruptedError(
            f"finished parts are kept in {folder}; the same command goes on from there."
        ) from None

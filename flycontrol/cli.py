"""The command line: options, reading, refusing. Everything heavy is imported by the command that needs it."""

from __future__ import annotations

import sys
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flycontrol.errors import FlycontrolError, InvalidInputError

if TYPE_CHECKING:
    from flycontrol.identify.flight import FlightAnalysis
    from flycontrol.jobs.progress import Progress
    from flycontrol.model.parameters import Parameters
    from flycontrol.model.recording import Recording

REFUSED = 2
INTERRUPTED = 130

app = typer.Typer(
    name="flycontrol",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def main() -> None:
    """Run the command line: status 0 when done, 2 with one sentence for what the user can mend, 130 for Ctrl-C."""
    try:
        app()
    except SystemExit as ended:  # Typer turns Ctrl-C into this status before main could see it
        if ended.code == INTERRUPTED:
            _say("interrupted; nothing was written.")
        raise
    except KeyboardInterrupt:
        _say("interrupted; nothing was written.")
        sys.exit(INTERRUPTED)
    except FlycontrolError as error:
        _say(str(error))
        sys.exit(REFUSED)
    except OSError as error:
        _say(f"{error.filename or 'output'}: {error.strerror or error}.")
        sys.exit(REFUSED)
    except MemoryError:
        _say("the memory is full; use a shorter recording or close other programs.")
        sys.exit(REFUSED)


def _say(sentence: str) -> None:
    typer.echo(f"flycontrol: {' '.join(sentence.split())}", err=True)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"flycontrol {version('flycontrol')}")
        raise typer.Exit


@app.callback()
def flycontrol(
    _version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Control engineering for insect flight, and exact control theory for loops with a reaction delay."""


@app.command()
def parameters(
    species: Annotated[
        str, typer.Option(metavar="NAME", help="Which shipped fly: fly (Drosophila melanogaster) or drosophila_hydei.")
    ] = "fly",
) -> None:
    """Print a parameter file with the source and certainty of every number, to edit and give to --parameters.

    Example: flycontrol parameters > my_fly.toml
    """
    from flycontrol.io.fly_files import parameter_text

    typer.echo(parameter_text(species), nl=False)


@app.command()
def report(
    parameters: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Fly parameters in TOML, or a shipped name; left out: the published fly."),
    ] = None,
    recording: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A real flight to compare with, as a text table.")
    ] = None,
    mapping: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="What the rows or columns of the recording mean, in TOML, or a shipped name such as "
            "muijres_freeflight; left out: what the file holds is printed, with a mapping to edit.",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for index.html and result.json.")] = Path(
        "reports/yaw"
    ),
) -> None:
    """Report on the stability of the yaw loop: margins, modes, recovery, and what a real flight says of the model.

    Example: flycontrol report --recording flight.txt --mapping map.toml --out reports/flight
    """
    from flycontrol.io.parameters import read_parameters
    from flycontrol.jobs.files import require_writable_folder

    started = time.perf_counter()
    require_writable_folder(out)
    fly = read_parameters(parameters)
    flight = _recording(recording, mapping)
    from flycontrol.report.page import write_report

    with _progress_bar() as progress:
        analysis = None if flight is None else _analysis(flight, fly, parameters)
        write_report(fly, analysis, out, command=_command(parameters, recording, mapping), progress=progress)
    _say(f"wrote {out / 'index.html'} and result.json in {time.perf_counter() - started:.1f} s")


def _recording(path: Path | None, mapping: str | None) -> Recording | None:
    if path is None and mapping is not None:
        raise InvalidInputError("--mapping says how to read a recording; name the recording too, by --recording.")
    if path is None:
        return None
    if mapping is None:
        raise _refusal_with_a_mapping_to_edit(path)
    from flycontrol.io.recordings import read_recording

    return read_recording(path, mapping)


def _analysis(flight: Recording, fly: Parameters, parameters: str | None) -> FlightAnalysis:
    from flycontrol.identify.flight import analyse_flight
    from flycontrol.io.morphology import read_morphology_table
    from flycontrol.model.morphology import morphology_from_table

    table = read_morphology_table(parameters)
    frequency = fly.wingbeat_frequency.value
    return analyse_flight(flight, morphology_from_table(table, species=fly.name, wingbeat_frequency=frequency))


def _command(parameters: str | None, recording: Path | None, mapping: str | None) -> str:
    """Say what was asked for, files by name alone: where they lie and where the report goes does not change it."""
    given = {"--parameters": parameters, "--recording": recording, "--mapping": mapping}
    options = [f"{option} {Path(value).name}" for option, value in given.items() if value is not None]
    return " ".join(["flycontrol report", *options])


def _refusal_with_a_mapping_to_edit(path: Path) -> InvalidInputError:
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
def _progress_bar() -> Generator[Progress]:
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

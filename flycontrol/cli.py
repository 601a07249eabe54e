"""The command line: options, reading, refusing. Everything heavy is imported by the command that needs it."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from flycontrol.errors import FlycontrolError

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
    except KeyboardInterrupt:
        _say("interrupted")
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
    """Print a parameter file with the source and certainty of every number, to edit

    Example: flycontrol parameters > my_fly.toml
    """
    from flycontrol.io.fly_files import parameter_text

    typer.echo(parameter_text(species), nl=False)

"""The command line: options, reading, refusing. Everything heavy is imported by the command that needs it."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from flycontrol.cli.example import example
from flycontrol.cli.fit import fit
from flycontrol.cli.report import parameters, report
from flycontrol.cli.simulate import experiment, simulate
from flycontrol.cli.terminal import WorkInterruptedError, say
from flycontrol.cli.track import track
from flycontrol.cli.validate import validate
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
    except SystemExit as ended:  # Typer turns Ctrl-C into this status before main could see it
        if ended.code == INTERRUPTED:
            say("interrupted; nothing was written.")
        raise
    except KeyboardInterrupt:
        say("interrupted; nothing was written.")
        sys.exit(INTERRUPTED)
    except WorkInterruptedError as kept:
        say(f"interrupted; {kept}")
        sys.exit(INTERRUPTED)
    except FlycontrolError as error:
        say(str(error))
        sys.exit(REFUSED)
    except OSError as error:
        say(f"{error.filename or 'output'}: {error.strerror or error}.")
        sys.exit(REFUSED)
    except MemoryError:
        say("the memory is full; use a shorter recording or close other programs.")
        sys.exit(REFUSED)


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


app.command()(parameters)
app.command()(report)
app.command()(example)
app.command()(fit)
app.command()(experiment)
app.command()(simulate)
app.command()(track)
app.command()(validate)

"""`flycontrol report` and `flycontrol parameters`: the stability report, and the file that it reads a fly from."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flycontrol.cli.terminal import progress_bar, refusal_with_a_mapping_to_edit, say
from flycontrol.errors import InvalidInputError

if TYPE_CHECKING:
    from flycontrol.identify.flight import FlightAnalysis
    from flycontrol.model.parameters import Parameters
    from flycontrol.model.recording import Recording


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


def report(
    parameters: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Fly parameters in TOML, or a shipped name; left out: the published fly."),
    ] = None,
    recording: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="A real flight: a text table, or a MATLAB, HDF5, netCDF or Parquet file."),
    ] = None,
    mapping: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="What the rows or columns of the recording mean, in TOML, or a shipped name such as "
            "muijres_freeflight; left out: what the file holds is printed, with a mapping to edit.",
        ),
    ] = None,
    out: Annotated[str, typer.Option(metavar="DIR", help="Folder for index.html and result.json.")] = "reports/yaw",
) -> None:
    """Report on the stability of the yaw loop: margins, modes, recovery, and what a real flight says of the model.

    Example: flycontrol report --recording flight.txt --mapping map.toml --out reports/flight
    """
    from flycontrol.io.parameters import read_parameters
    from flycontrol.jobs.files import require_writable_folder

    started = time.perf_counter()
    folder = _folder(out)
    require_writable_folder(folder)
    fly = read_parameters(parameters)
    flight = _recording(recording, mapping)
    from flycontrol.report.page import write_report

    with progress_bar() as progress:
        analysis = None if flight is None else _analysis(flight, fly, parameters)
        write_report(fly, analysis, folder, command=_command(parameters, recording, mapping), progress=progress)
    say(f"wrote {folder / 'index.html'} and result.json in {time.perf_counter() - started:.1f} s")


def _folder(name: str) -> Path:
    if not name.strip():
        raise InvalidInputError("--out is empty; name a folder for index.html and result.json, such as reports/yaw.")
    return Path(name)


def _recording(path: Path | None, mapping: str | None) -> Recording | None:
    if path is None and mapping is not None:
        raise InvalidInputError("--mapping says how to read a recording; name the recording too, by --recording.")
    if path is None:
        return None
    if mapping is None:
        raise refusal_with_a_mapping_to_edit(path)
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

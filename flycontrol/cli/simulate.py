"""`flycontrol simulate` and `flycontrol experiment`: a simulated flight, and the file that says which."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flycontrol.cli.terminal import progress_bar, say
from flycontrol.errors import InvalidInputError

if TYPE_CHECKING:
    from flycontrol.flight.experiments import PlannedFlight
    from flycontrol.flight.flight_record import FlightRecord
    from flycontrol.io.trajectory_files import TrajectoryFormat
    from flycontrol.jobs.progress import Progress

DIVERGED = 3


def experiment() -> None:
    """Print an experiment file, to edit and give to flycontrol simulate.

    Example: flycontrol experiment > my_flight.toml
    """
    from flycontrol.io.flight_experiments import experiment_text

    typer.echo(experiment_text(), nl=False)


def simulate(
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="[EXPERIMENT.toml]",
            help="What is flown, as flycontrol experiment prints it; left out: the published fly in trimmed hover, "
            "hit by a yaw torque of one wingbeat.",
        ),
    ] = None,
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for index.html, result.json, the trajectory and the animation.")
    ] = Path("reports/flight"),
    form: Annotated[str, typer.Option("--format", metavar="netcdf|hdf5|csv", help="Of the trajectory.")] = "netcdf",
) -> None:
    """Fly a fly at the level of its wings: trajectory, page of figures, summary and animation.

    Exit status 0: flown to the end; 3: the flight diverged, and what was flown until then is written; 2: refused.

    Example: flycontrol simulate my_flight.toml --out reports/my_flight
    """
    from flycontrol.io.flight_experiments import read_flight_experiment
    from flycontrol.jobs.files import require_writable_folder

    started = time.perf_counter()
    if not str(out).strip() or str(out) == ".":
        raise InvalidInputError("--out is empty; name a folder such as reports/flight.")
    require_writable_folder(out)
    form_of_file = _format(form)
    asked = read_flight_experiment(file)
    from flycontrol.flight.experiments import planned_flight

    with progress_bar() as progress:
        progress(0, asked.wingbeats, "trim" if asked.trim else "wingbeats")
        record = _flown(planned_flight(asked), out, form_of_file, _command(file, form), progress)
    ending = "" if record.complete else f"the flight {record.status} "
    say(f"{ending}wrote {out / 'index.html'}, {_names(form_of_file)} in {time.perf_counter() - started:.1f} s")
    if not record.complete:
        raise typer.Exit(DIVERGED)


def _flown(
    planned: PlannedFlight, folder: Path, form: TrajectoryFormat, command: str, progress: Progress
) -> FlightRecord:
    """Fly, write the trajectory piece by piece, then everything else, and give all files their names together."""
    from flycontrol.flight.flight_record import FlightRecorder
    from flycontrol.io.trajectory_files import FILE_NAMES, trajectory_writer
    from flycontrol.io.trajectory_mapping import trajectory_mapping
    from flycontrol.jobs.files import temporary_file
    from flycontrol.report.simulation_page import write_flight_report

    name = FILE_NAMES[form]
    asked = planned.experiment
    about = {"title": asked.name, "species": asked.morphology.species, "wingbeat_frequency": planned.frequency}
    with temporary_file(folder, name) as path:
        recorder = FlightRecorder(planned)
        angle = asked.morphology.stroke_plane_angle
        with trajectory_writer(path, form, stroke_plane_angle=angle, about=about, name=str(folder / name)) as writer:
            for piece in planned.chunks():
                writer.add(piece)
                recorder.add(piece)
                progress(piece.wingbeats, asked.wingbeats, "wingbeats")
        record = recorder.finish()
        mapping = trajectory_mapping(asked, planned.frequency, form)
        write_flight_report(record, folder, {name: path, "mapping.toml": mapping}, command=command, progress=progress)
    return record


def _format(name: str) -> TrajectoryFormat:
    from flycontrol.io.trajectory_files import FORMATS

    for known in FORMATS:
        if name == known:
            return known
    raise InvalidInputError(f"--format must be one of {', '.join(FORMATS)}, got '{name}'.")


def _names(form: TrajectoryFormat) -> str:
    from flycontrol.io.trajectory_files import FILE_NAMES

    return f"{FILE_NAMES[form]}, mapping.toml, result.json and flight.gif"


def _command(file: Path | None, form: str) -> str:
    """Say what was asked for; where files lie and where the report goes does not change it."""
    return " ".join(["flycontrol simulate", *([] if file is None else [file.name]), f"--format {form}"])

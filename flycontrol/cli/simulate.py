"""`flycontrol simulate` and `flycontrol experiment`: a simulated flight, and the file that says which."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flycontrol.cli.terminal import kept_when_interrupted, progress_bar, say
from flycontrol.errors import InvalidInputError

if TYPE_CHECKING:
    from flycontrol.flight.experiment_ensemble import FlownEnsemble
    from flycontrol.flight.experiments import PlannedFlight
    from flycontrol.flight.flight_record import FlightRecord
    from flycontrol.io.trajectory_files import TrajectoryFormat
    from flycontrol.jobs.checkpoint import Checkpoint
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
        str, typer.Option(metavar="DIR", help="Folder for index.html, result.json, the trajectory and the animation.")
    ] = "reports/flight",
    form: Annotated[str, typer.Option("--format", metavar="netcdf|hdf5|csv", help="Of the trajectory.")] = "netcdf",
    mp4: Annotated[bool, typer.Option("--mp4", help="Write the animation as MP4 too, where ffmpeg is found.")] = False,
    workers: Annotated[
        int | None,
        typer.Option(min=1, metavar="NUMBER", help="Processes for an ensemble; left out: one on every core."),
    ] = None,
) -> None:
    """Fly a fly at the level of its wings: trajectory, page of figures, summary and animation.

    Exit status 0: flown to the end; 2: refused, nothing written; 3: the flight diverged, what was flown is written.

    Example: flycontrol simulate my_flight.toml --out reports/my_flight
    """
    from flycontrol.io.flight_experiments import read_flight_experiment
    from flycontrol.jobs.files import require_writable_folder

    started = time.perf_counter()
    if not out.strip():
        raise InvalidInputError("--out is empty; name a folder for the flight's files, such as reports/flight.")
    folder = Path(out)
    require_writable_folder(folder)
    form_of_file = _format(form)
    asked = read_flight_experiment(file)
    from flycontrol.flight.experiments import planned_flight

    with progress_bar() as progress:
        progress(0, asked.wingbeats, "trim" if asked.trim else "wingbeats")
        planned = planned_flight(asked)
        kept = _checkpoint(planned, folder)
        with kept_when_interrupted(kept.folder):
            ensemble = _ensemble(planned, kept, workers, progress)
            record = _flown(planned, folder, form_of_file, ensemble, _command(file, form), progress, mp4=mp4)
        kept.remove()
    ending = "" if record.complete else f"the flight {record.status} "
    say(f"{ending}wrote {folder / 'index.html'} and what lies beside it in {time.perf_counter() - started:.1f} s")
    if not record.complete:
        raise typer.Exit(DIVERGED)


def _flown(
    planned: PlannedFlight,
    folder: Path,
    form: TrajectoryFormat,
    ensemble: FlownEnsemble | None,
    command: str,
    progress: Progress,
    *,
    mp4: bool,
) -> FlightRecord:
    """Fly, write the trajectory piece by piece, then everything else, and give all files their names together."""
    from flycontrol.flight.flight_record import FlightRecorder
    from flycontrol.io.trajectory_files import FILE_NAMES, trajectory_writer
    from flycontrol.io.trajectory_mapping import trajectory_mapping
    from flycontrol.jobs.files import temporary_file

    name, asked = FILE_NAMES[form], planned.experiment
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
        from flycontrol.report.simulation.page import write_flight_report

        beside: dict[str, str | bytes | Path] = {
            name: path,
            "mapping.toml": trajectory_mapping(asked, planned.frequency, form),
        }
        beside |= _movie(record) if mp4 else {}
        write_flight_report(record, folder, beside, command=command, ensemble=ensemble, progress=progress)
    return record


def _ensemble(
    planned: PlannedFlight, kept: Checkpoint, workers: int | None, progress: Progress
) -> FlownEnsemble | None:
    """Fly the ensemble, if the experiment has one; finished groups of flights are kept and not flown again."""
    from flycontrol.flight.experiment_ensemble import experiment_ensemble, flown_ensemble
    from flycontrol.jobs.seeded_map import seeded_map

    if planned.experiment.ensemble is None:
        return None
    work = experiment_ensemble(planned, planned.experiment.ensemble)
    return flown_ensemble(planned, seeded_map(work, workers, checkpoint=kept, progress=progress))


def _checkpoint(planned: PlannedFlight, folder: Path) -> Checkpoint:
    """Where finished groups wait; known by all that their results depend on."""
    import hashlib

    from flycontrol.jobs.checkpoint import Checkpoint

    plan = repr((planned.experiment, planned.plan.stroke, planned.plan.start))
    return Checkpoint(folder / "unfinished", hashlib.sha256(plan.encode()).hexdigest())


def _movie(record: FlightRecord) -> dict[str, str | bytes | Path]:
    from flycontrol.report.movie import ffmpeg, mp4

    program = ffmpeg()
    if program is None:
        say("no ffmpeg is on the PATH, so no flight.mp4 is made; flight.gif shows the same.")
        return {}
    return {"flight.mp4": mp4(record, program)} if len(record.film.time) > 1 else {}


def _format(name: str) -> TrajectoryFormat:
    from flycontrol.io.trajectory_files import FORMATS

    for known in FORMATS:
        if name == known:
            return known
    raise InvalidInputError(f"--format must be one of {', '.join(FORMATS)}, got '{name}'.")


def _command(file: Path | None, form: str) -> str:
    """Say what was asked for; where files lie and where the report goes does not change it."""
    return " ".join(["flycontrol simulate", *([] if file is None else [file.name]), f"--format {form}"])

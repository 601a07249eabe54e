"""The report of a simulated flight: its page, result.json, and beside them trajectory and animation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from flycontrol.flight.experiment_ensemble import FlownEnsemble
from flycontrol.flight.flight_record import FlightRecord
from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.report.animation import FRAME_TIME, gif
from flycontrol.report.numbers import sentence
from flycontrol.report.page import template_environment, the_css
from flycontrol.report.simulation import words
from flycontrol.report.simulation.figures import FIGURES, simulation_figures
from flycontrol.report.simulation.result import (
    FlightProvenance,
    ensemble_csv,
    flight_provenance,
    simulation_result_json,
)

_WORDS = {
    "trajectory.nc": "is the whole flight (netCDF-4)",
    "trajectory.h5": "is the whole flight (HDF5)",
    "trajectory.csv": "is the whole flight",
    "mapping.toml": "reads it back as a recording",
    "result.json": "holds the numbers unrounded, with the meaning and unit of each field",
    "flight.gif": "is the animation",
    "flight.mp4": "is the animation too",
    "ensemble.csv": "holds the end of each flight of the ensemble",
}


def write_flight_report(
    record: FlightRecord,
    folder: Path,
    beside: Mapping[str, str | bytes | Path],
    *,
    command: str,
    ensemble: FlownEnsemble | None = None,
    progress: Progress = no_progress,
) -> tuple[Path, ...]:
    """Write index.html and result.json, and with them the files beside them, all or none.

    Parameters
    ----------
    record
        The flight.
    folder
        Where the files go.
    beside
        Trajectory, mapping, and an MP4 if there is one: texts, or paths of finished files in the folder.
    command
        That made this report, as it shall stand in its provenance.
    ensemble
        What an ensemble about this flight did.

    Raises
    ------
    OutputError
        If the files cannot be written; earlier ones stay as they were.
    """
    origin = flight_provenance(record.planned.experiment, command)
    films: dict[str, str | bytes] = {"flight.gif": gif(record)} if len(record.film.time) > 1 else {}
    if ensemble is not None:
        films["ensemble.csv"] = ensemble_csv(ensemble)
    files = {name: _WORDS[name] for name in (*beside, *films, "result.json")}
    made = {
        "result.json": simulation_result_json(record, origin, files, ensemble),
        "index.html": simulation_page(record, origin, files, ensemble),
    }
    progress(record.wingbeats, record.wingbeats, "writing")
    return write_files_atomically(folder, {**beside, **films, **made})


def simulation_page(
    record: FlightRecord, origin: FlightProvenance, files: Mapping[str, str], ensemble: FlownEnsemble | None = None
) -> str:
    """Render the page; all but the animation is in it."""
    environment = template_environment()
    figures = simulation_figures(record, ensemble)
    trim = record.planned.trim
    return environment.get_template("simulation.html").render(
        css=the_css(environment),
        experiment=record.planned.experiment,
        origin=origin,
        complete=record.complete,
        lead=words.lead(record),
        figures=figures,
        numbers={name: k for k, name in enumerate([f for f in FIGURES if f in figures], start=1)},
        film="flight.gif" if "flight.gif" in files else "",
        film_caption=_film_caption(record),
        mean_rows=words.mean_rows(record),
        error_rows=words.error_rows(record),
        fly_rows=words.fly_rows(record),
        trim_status="" if trim is None else sentence(trim.status),
        trim_rows=words.trim_rows(record),
        experiment_rows=words.experiment_rows(record),
        files=files,
    )


def _film_caption(record: FlightRecord) -> str:
    film = record.film
    if len(film.time) < 2:
        return ""
    slower = FRAME_TIME / float(film.time[1] - film.time[0])
    return (
        f"Body and wings from above, from the fly’s right and from behind, wingbeats {film.phase[0]:.0f} to "
        f"{film.phase[-1]:.0f}, {slower:.0f} times slower than it flew. The pictures follow the body; the grid stands "
        "still in the world, and the blue line is the way it came. The body is the even ellipsoid that has its "
        "mass and inertia; thick edges lead."
    )

"""The page of a tracked flight, and the animation beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.report.numbers import ABSENT, fixed
from flycontrol.report.page import template_environment, the_css
from flycontrol.report.track import words
from flycontrol.report.track.animation import FRAME_TIME, gif
from flycontrol.report.track.beats import stroke_reversals
from flycontrol.report.track.figures import track_figures
from flycontrol.report.track.provenance import TrackProvenance, track_provenance
from flycontrol.report.track.result import TrackOrigin
from flycontrol.report.track.second_look import SecondLook, second_look
from flycontrol.report.track.truth import coordinate_errors
from flycontrol.report.track.words import Row
from flycontrol.vision.footage import Footage
from flycontrol.vision.tracked_flight import TrackedFlight

ANIMATION = "overlay.gif"
WORDS = {
    "recording.h5": "is the recording: the 18 coordinates, their uncertainties and derivatives (HDF5)",
    "recording.nc": "is the recording: the 18 coordinates, their uncertainties and derivatives (netCDF-4)",
    "recording.csv": "is the recording: the 18 coordinates, their uncertainties and derivatives",
    "mapping.toml": "reads the recording, for flycontrol report and flycontrol fit",
    "cameras.toml": "are the cameras as anipose keeps them, in this world, rows and columns at right angles, mm",
    "result.json": "holds the numbers unrounded, with the meaning and unit of each field",
    "index.html": "is the page",
    ANIMATION: "is the animation",
}


def write_track_report(
    flight: TrackedFlight,
    footage: Footage,
    folder: Path,
    beside: Mapping[str, str | bytes | Path],
    *,
    origin: TrackOrigin,
    progress: Progress = no_progress,
) -> tuple[Path, ...]:
    """Write index.html and the animation, and with them the files beside them, all or none.

    Parameters
    ----------
    flight
        What was found; at least one frame.
    footage
        What it was found in; a few of its frames are read again.
    folder
        Where the files go.
    beside
        Recording, mapping, result and what else there is: texts, or paths of finished files in the folder.
    origin
        The command, and where the films come from, with their hashes.
    progress
        Told after every frame that was looked at again.

    Raises
    ------
    OutputError
        If the files cannot be written; earlier ones stay as they were.
    """
    reversals = stroke_reversals(flight)
    seen = second_look(flight, footage, reversals, progress)
    films: dict[str, str | bytes] = {ANIMATION: gif(seen.pictures)} if len(seen.pictures) > 1 else {}
    files = {name: WORDS.get(name, "lies beside this page") for name in (*beside, *films)}
    made = {"index.html": track_page(flight, footage, seen, files, track_provenance(origin))}
    return write_files_atomically(folder, {**beside, **films, **made})


def track_page(
    flight: TrackedFlight,
    footage: Footage,
    seen: SecondLook,
    files: Mapping[str, str],
    origin: TrackProvenance,
) -> str:
    """Render the page; all but the animation is in it."""
    reversals = stroke_reversals(flight)
    environment = template_environment()
    figures = track_figures(flight, reversals, seen.survey, seen.overlays, seen.hulls)
    believed = int(np.count_nonzero(flight.track.believed))
    return environment.get_template("track.html").render(
        css=the_css(environment),
        flight=flight,
        believed=believed,
        mostly=2 * believed >= len(flight.track),
        lead=words.lead(flight, reversals),
        figures=figures,
        numbers={name: k for k, name in enumerate(figures, start=1)},
        of_frames=[name for name in figures if name.startswith("frame-")],
        of_hulls=[name for name in figures if name.startswith("hull-")],
        binary=all(film.binary for film in footage.films),
        frame_rate=fixed(footage.frame_rate, 0),
        film=ANIMATION if ANIMATION in files else "",
        film_caption=_film_caption(flight, seen),
        status_rows=words.status_rows(flight),
        span_rows=words.span_rows(flight),
        camera_rows=words.camera_rows(flight),
        pair_rows=words.pair_rows(flight),
        size_rows=words.size_rows(flight),
        error_rows=_error_rows(flight),
        files=files,
        origin=origin,
    )


def _film_caption(flight: TrackedFlight, seen: SecondLook) -> str:
    if len(seen.pictures) < 2:
        return ""
    step = float(flight.time[seen.survey.frames[1]] - flight.time[seen.survey.frames[0]])
    return (
        f"{len(seen.pictures)} of {len(flight.track)} frames, about {FRAME_TIME / step:.0f} times slower than it flew. "
        "What was filmed, pixel by pixel, and the contours of the fitted fly: body black, left wing blue, right wing "
        "orange. The windows follow the fly."
    )


def _error_rows(flight: TrackedFlight) -> list[Row]:
    if flight.truth is None or not np.any(flight.track.believed):
        return []
    rows: list[Row] = []
    for error in coordinate_errors(flight, flight.truth):
        digits = 2 if error.unit == "deg" else 4
        raw, smoothed = (fixed(value, digits) for value in (error.raw, error.smoothed))
        aim = ABSENT if error.aim is None else fixed(error.aim, 0)
        rows.append(Row(error.name, (error.unit, raw, smoothed, aim, fixed(100 * error.in_band, 0, "%"))))
    return rows

"""The page of a tracked flight, and the animation beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.report import track_words as words
from flycontrol.report.numbers import ABSENT, fixed
from flycontrol.report.page import template_environment, the_css
from flycontrol.report.track_animation import FRAME_TIME, gif
from flycontrol.report.track_beats import StrokeReversals, stroke_reversals
from flycontrol.report.track_figures import track_figures
from flycontrol.report.track_provenance import track_provenance
from flycontrol.report.track_second_look import SecondLook, second_look
from flycontrol.report.track_truth import coordinate_errors
from flycontrol.report.track_words import Row
from flycontrol.vision.footage import Footage
from flycontrol.vision.tracked_flight import TrackedFlight

ANIMATION = "overlay.gif"
_WORDS = {
    "recording.h5": "holds the 18 coordinates with their uncertainties and derivatives (HDF5)",
    "recording.nc": "holds the 18 coordinates with their uncertainties and derivatives (netCDF-4)",
    "recording.csv": "holds the 18 coordinates with their uncertainties and derivatives",
    "mapping.toml": "reads it back as a recording",
    "result.json": "holds the numbers unrounded, with the meaning and unit of each field",
    "cameras.toml": "holds the cameras as anipose reads them",
    ANIMATION: "is the animation",
}


def write_track_report(
    flight: TrackedFlight,
    footage: Footage,
    folder: Path,
    beside: Mapping[str, str | bytes | Path],
    *,
    command: str,
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
    command
        That made this report, as it shall stand in its provenance.
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
    files = {name: _WORDS.get(name, "lies beside this page") for name in (*beside, *films)}
    made = {"index.html": track_page(flight, footage, reversals, seen, files, command)}
    return write_files_atomically(folder, {**beside, **films, **made})


def track_page(
    flight: TrackedFlight,
    footage: Footage,
    reversals: StrokeReversals,
    seen: SecondLook,
    files: Mapping[str, str],
    command: str,
) -> str:
    """Render the page; all but the animation is in it."""
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
        origin=track_provenance(command),
    )


def _film_caption(flight: TrackedFlight, seen: SecondLook) -> str:
    if len(seen.pictures) < 2:
        return ""
    step = float(flight.time[seen.survey.frames[1]] - flight.time[seen.survey.frames[0]])
    return (
        f"{len(seen.pictures)} of {len(flight.track)} frames, about {FRAME_TIME / step:.0f} times slower than it flew. "
        "What was filmed, pixel by pixel, and the contours of the fitted fly: body dark, left wing blue, right wing "
        "light. The windows follow the fly."
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

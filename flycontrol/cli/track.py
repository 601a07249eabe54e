"""`flycontrol track`: films of a fly in, its motion out."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flycontrol.cli.terminal import kept_when_interrupted, progress_bar, say
from flycontrol.cli.track_command import typed_track_command
from flycontrol.cli.track_inputs import DUST, WINGBEATS, FilmOptions, FlyOptions, TrackInputs, identity_of, track_inputs
from flycontrol.errors import InvalidInputError

if TYPE_CHECKING:
    from flycontrol.io.trajectory_files import TrajectoryFormat
    from flycontrol.jobs.checkpoint import Checkpoint
    from flycontrol.jobs.progress import Progress
    from flycontrol.vision.tracked_flight import TrackedFlight

NOTHING_TRACKED, PARTLY_LOST = 1, 3
_FLY = "drosophila_melanogaster"


def track(
    inputs: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[INPUT...]",
            help="Films of all cameras, in the cameras' order: folders or patterns of PNG or TIFF, .npz, .npy, .mat, "
            "video; left out: a simulated fly before three cameras, with its truth beside the result.",
        ),
    ] = None,
    cameras: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Calibration: DLT coefficients, matrices, easyWandData.mat, anipose's TOML."),
    ] = None,
    out: Annotated[
        str, typer.Option(metavar="DIR", help="Folder for index.html, result.json, the recording and the cameras.")
    ] = "reports/track",
    frame_rate: Annotated[
        float | None, typer.Option(metavar="NUMBER", help="Frames a second, where the films do not say it.")
    ] = None,
    frames: Annotated[
        str | None, typer.Option(metavar="FIRST:LAST:STEP", help="Counted from 0, LAST included; left out: all.")
    ] = None,
    up: Annotated[
        str, typer.Option(metavar="z|-z|y|-y|x|-x", help="Which axis of the calibration's world points up.")
    ] = "z",
    unit: Annotated[str, typer.Option(metavar="UNIT", help="Of lengths in the calibration.")] = "mm",
    camera_variable: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of the calibration in a .npz or .mat that holds more.")
    ] = None,
    first_pixel: Annotated[
        int | None,
        typer.Option(min=0, max=1, help="Of the calibration's pixels; left out: 1 for DLT coefficients, 0 otherwise."),
    ] = None,
    rows_from_below: Annotated[
        bool, typer.Option("--rows-from-below", help="The calibration counts rows of pixels from below.")
    ] = False,
    film_variable: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of the frames in a .npz that holds several arrays.")
    ] = None,
    silhouettes: Annotated[
        bool | None,
        typer.Option("--silhouettes/--grey", help="What the frames are; left out: as their numbers look."),
    ] = None,
    background: Annotated[
        str | None,
        typer.Option(metavar="PATH", help="Films or pictures of the empty scene; left out: the median over frames."),
    ] = None,
    bright: Annotated[bool, typer.Option("--bright", help="The fly is brighter than its ground.")] = False,
    contrast: Annotated[
        float | None,
        typer.Option(metavar="NUMBER", help="Of silhouette and ground, in grey levels; left out: half the fly's own."),
    ] = None,
    dust: Annotated[
        float, typer.Option(metavar="SHARE", help="Parts below this share of the largest are left out.")
    ] = DUST,
    fly: Annotated[
        str, typer.Option(metavar="FILE", help="Its wings, in TOML, or drosophila_hydei and the like.")
    ] = _FLY,
    body_length: Annotated[
        str | None, typer.Option(metavar="LENGTH", help='As "2.7 mm"; left out: as long as a wing.')
    ] = None,
    stroke_plane_angle: Annotated[
        str | None, typer.Option(metavar="ANGLE", help='From the long axis, as "50 deg"; left out: that of the fly.')
    ] = None,
    fit_sizes: Annotated[
        bool | None,
        typer.Option(
            "--fit-sizes/--no-fit-sizes",
            help="Fit the fly's sizes to the first frames that show it; left out: for films alone.",
        ),
    ] = None,
    hull_only: Annotated[
        bool, typer.Option("--hull-only", help="Read the coordinates off the hull; do not fit a parametric fly.")
    ] = False,
    form: Annotated[str, typer.Option("--format", metavar="netcdf|hdf5|csv", help="Of the recording.")] = "netcdf",
    wingbeats: Annotated[
        int, typer.Option(min=1, max=1000, metavar="NUMBER", help="Of the simulated fly, where there is no INPUT.")
    ] = WINGBEATS,
) -> None:
    """Track a fly through calibrated films: page, recording, summary and animation.

    Exit status 0: tracked; 1: written, but no frame was tracked; 2: refused, nothing written; 3: written, but the fly
    is lost in some frames.

    Example: flycontrol track masks.npz --cameras calibration.csv --frame-rate 8000 --out reports/flight
    """
    from flycontrol.jobs.checkpoint import Checkpoint
    from flycontrol.jobs.files import require_writable_folder

    started = time.perf_counter()
    if not out.strip():
        raise InvalidInputError("--out is empty; name a folder for the recording, such as reports/track.")
    folder = Path(out)
    require_writable_folder(folder)
    asked = {
        "cameras": cameras, "frame-rate": frame_rate, "frames": frames, "up": up, "unit": unit,
        "camera-variable": camera_variable, "first-pixel": first_pixel, "rows-from-below": rows_from_below,
        "film-variable": film_variable, "silhouettes": silhouettes, "background": background, "bright": bright,
        "contrast": contrast, "dust": dust, "fly": fly, "body-length": body_length,
        "stroke-plane-angle": stroke_plane_angle, "fit-sizes": fit_sizes, "hull-only": hull_only, "format": form,
        "wingbeats": wingbeats,
    }  # fmt: skip
    films = FilmOptions(
        inputs=tuple(inputs or ()), cameras=cameras, frame_rate=frame_rate, frames=frames, up=up, unit=unit,
        camera_variable=camera_variable, first_pixel=first_pixel, rows_from_below=rows_from_below,
        film_variable=film_variable, silhouettes=silhouettes, background=background, bright=bright, contrast=contrast,
        dust=dust, wingbeats=wingbeats,
    )  # fmt: skip
    which = FlyOptions(
        file=fly, body_length=body_length, stroke_plane_angle=stroke_plane_angle, fit_sizes=fit_sizes,
        hull_only=hull_only,
    )  # fmt: skip
    form_of_file = _format(form)
    with progress_bar() as progress:
        progress(0, 1, "reading")
        given = track_inputs(films, which)
        if given.check.doubt:
            say(f"{given.check.doubt}.")
        kept = Checkpoint(folder / "unfinished", identity_of(given, films))
        with kept_when_interrupted(kept.folder):
            command = typed_track_command(inputs or (), asked)
            flight = _tracked(given, folder, form_of_file, command, kept, progress)
        kept.remove()
    from flycontrol.report.track.result import nothing_tracked, status_sentence
    from flycontrol.vision.checks.attitude_check import upside_down

    if over := upside_down(flight.track):
        say(f"{over[0].upper()}{over[1:]}.")
    ending = f"wrote {folder / 'index.html'} and what lies beside it in {time.perf_counter() - started:.1f} s"
    if flight.unsmoothed:
        say(flight.unsmoothed)
    say(f"{status_sentence(flight.track)} {ending}")
    if nothing := nothing_tracked(flight.track):
        say(nothing)
        raise typer.Exit(NOTHING_TRACKED)
    if "lost" in flight.track.status:
        raise typer.Exit(PARTLY_LOST)


def _tracked(
    given: TrackInputs, folder: Path, form: TrajectoryFormat, command: str, kept: Checkpoint, progress: Progress
) -> TrackedFlight:
    """Track, then give all files their names together."""
    from flycontrol.io.tracked_mapping import RECORDING_NAMES
    from flycontrol.jobs.files import discard_torn, temporary_file
    from flycontrol.report.track.files import files_beside_the_page
    from flycontrol.report.track.page import WORDS, write_track_report
    from flycontrol.vision.flight_of_film import flight_of_film

    flight = flight_of_film(given.filmed, given.asked, given.check, kept, progress)
    discard_torn(folder, WORDS)
    with temporary_file(folder, RECORDING_NAMES[form]) as path:
        origin = given.origin(command)
        beside = files_beside_the_page(flight, folder, path, form, origin)
        write_track_report(flight, given.filmed.footage, folder, beside, origin=origin, progress=progress)
    return flight


def _format(name: str) -> TrajectoryFormat:
    from flycontrol.io.trajectory_files import FORMATS

    for known in FORMATS:
        if name == known:
            return known
    raise InvalidInputError(f"--format must be one of {', '.join(FORMATS)}, got '{name}'.")

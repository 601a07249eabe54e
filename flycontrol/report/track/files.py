"""What lies beside the page of a tracked flight: recording, mapping, cameras and result."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.io.anipose import anipose_text, without_skew
from flycontrol.io.tracked_mapping import RECORDING_NAMES, tracked_mapping
from flycontrol.io.trajectory_files import TrajectoryFormat
from flycontrol.report.track.page import ANIMATION, WORDS
from flycontrol.report.track.recording import write_tracked_recording
from flycontrol.report.track.result import TrackOrigin, tracked_result_json, wingbeat_frequency
from flycontrol.vision.tracked_flight import TrackedFlight

_ABOUT = 2e-3  #: around the flight, where the cameras of `cameras.toml` are to agree with those of the calibration [m]


def files_beside_the_page(
    flight: TrackedFlight, folder: Path, recording: Path, form: TrajectoryFormat, origin: TrackOrigin
) -> dict[str, str | bytes | Path]:
    """Write the recording, and make the files that shall get their names together with it.

    Parameters
    ----------
    flight
        What was tracked.
    folder
        Where the files go.
    recording
        A new file in that folder that takes the recording until all files get their names.
    form
        Of the recording.
    origin
        Where the flight comes from.

    Raises
    ------
    OutputError
        If the recording cannot be written.
    """
    name = RECORDING_NAMES[form]
    write_tracked_recording(recording, form, flight, str(folder / name))
    cameras, no_cameras = _anipose(flight)
    beside: dict[str, str | bytes | Path] = {name: recording, "mapping.toml": _mapping(flight, form), **cameras}
    animated = (ANIMATION,) if len(flight.time) > 1 else ()
    files = {file: WORDS[file] for file in ("index.html", *beside, *animated)}
    beside["result.json"] = tracked_result_json(flight, origin, files, no_cameras)
    return beside


def _mapping(flight: TrackedFlight, form: TrajectoryFormat) -> str:
    whole = bool(np.all(np.isfinite(flight.smoothed.pose.coordinates)))
    angle = flight.smoothed.pose.stroke_plane_angle
    frequency = wingbeat_frequency(flight)
    return tracked_mapping(
        form, name=flight.name, stroke_plane_angle=angle, frequency=frequency, whole=whole, empty=flight.unsmoothed
    )


def _anipose(flight: TrackedFlight) -> tuple[dict[str, str], str]:
    """cameras.toml, or why there is none."""
    where = flight.track.pose.position_W
    where = where[np.all(np.isfinite(where), axis=1)]
    low, high = where.min(axis=0) - _ABOUT, where.max(axis=0) + _ABOUT
    grid = np.stack(np.meshgrid(*np.linspace(low, high, 4).T, indexing="ij"), axis=-1).reshape(-1, 3)
    try:
        straight = [camera if camera.orthographic else without_skew(camera, grid) for camera in flight.cameras]
        return {"cameras.toml": anipose_text(straight)}, ""
    except InvalidInputError as error:
        return {}, str(error)

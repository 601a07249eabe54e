"""A tracked flight as the columns of a recording."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flycontrol.io.trajectory_columns import VARIABLES, Variable
from flycontrol.io.trajectory_files import TrajectoryFormat, table_file
from flycontrol.model.morphology import pitch_rotation
from flycontrol.model.pose import ANGLES, COORDINATES, POSITION, Pose
from flycontrol.vision.tracked_flight import TrackedFlight
from flycontrol.vision.tracked_frame import STATUSES

FloatArray = NDArray[np.float64]

_PARTS = ("body", "left_wing", "right_wing")
_CODES = ", ".join(f"{code} {status}" for code, status in enumerate(STATUSES))
#: What a simulated flight's variables mean of a tracked one, where that differs.
_OF_A_FILM = {
    "time": "time since frame 0 of the film",
    "position_W": "centre of the body's volume; world x and y level, z up",
    "velocity_S": "of the body's centre, stroke-plane frame: forward, right, down",
}
_MOTION = tuple(replace(variable, meaning=_OF_A_FILM.get(variable.name, variable.meaning)) for variable in VARIABLES)
_QUALITY = (
    Variable("frame", "1", "number of the frame in the film, from 0"),
    Variable("status", "1", _CODES),
    Variable("doubted", "1", "1 where this part was not believed, and stands where it was expected", _PARTS),
    Variable("smoothed", "m, rad", "the 18 coordinates, smoothed over time", COORDINATES),
    Variable("smoothed_sd", "m, rad", "their standard deviations", COORDINATES),
    Variable("smoothed_rate", "m/s, rad/s", "their rates", COORDINATES),
    Variable("smoothed_rate_sd", "m/s, rad/s", "standard deviations of the rates", COORDINATES),
    Variable("set_aside", "1", "1 where a coordinate was seen but was too far from the others to count", COORDINATES),
    Variable("raw", "m, rad", "the 18 coordinates, frame by frame", COORDINATES),
    Variable("raw_sd", "m, rad", "their standard deviations", COORDINATES),
)
_TRUE = Variable("true", "m, rad", "the 18 coordinates of the simulated fly", COORDINATES)


def write_tracked_recording(path: Path, form: TrajectoryFormat, flight: TrackedFlight, name: str) -> None:
    """Write the smoothed motion, and beside it what it was made of; lost frames are NaN.

    Parameters
    ----------
    path
        The file, which must not exist yet.
    form
        netcdf and hdf5 are the same bytes.
    flight
        What was tracked.
    name
        What a refusal calls the file.

    Raises
    ------
    OutputError
        If the disk takes no more.
    """
    rows = _motion(flight) | _quality(flight)
    variables = [*_MOTION, *_QUALITY, *_views(len(flight.cameras))]
    if flight.truth is not None:
        variables.append(_TRUE)
        rows["true"] = flight.truth.coordinates
    about: dict[str, str | float] = {
        "title": flight.name,
        "cameras": ", ".join(camera.name for camera in flight.cameras),
        "world": flight.world,
    }
    if flight.unsmoothed:
        about["unsmoothed"] = flight.unsmoothed
    with table_file(path, form, variables, about=about, name=name) as table:
        table.append(rows)


def _views(cameras: int) -> tuple[Variable, ...]:
    each = tuple(f"camera_{k}" for k in range(1, cameras + 1))
    return (
        Variable("overlap", "1", "intersection over union of fly and silhouette, for each camera", each),
        Variable("precision", "1", "share of the fly's pixels that lie on the silhouette, for each camera", each),
    )


def _motion(flight: TrackedFlight) -> dict[str, FloatArray]:
    pose, rate = flight.smoothed.pose, flight.smoothed.rate
    to_stroke_plane = pitch_rotation(pose.stroke_plane_angle)
    velocity_B = np.einsum("nji,nj->ni", _body_axes(pose), rate[:, POSITION])
    return {
        "time": flight.time,
        "yaw": _heading(pose),
        "position_W": pose.position_W,
        "q_WB": _attitude(pose),
        "velocity_S": velocity_B @ to_stroke_plane.T,
        "angular_velocity_S": flight.smoothed.angular_velocity_B @ to_stroke_plane.T,
        "left": pose.coordinates[:, ANGLES["left"]],
        "right": pose.coordinates[:, ANGLES["right"]],
        "left_rate": rate[:, ANGLES["left"]],
        "right_rate": rate[:, ANGLES["right"]],
    }


def _quality(flight: TrackedFlight) -> dict[str, FloatArray]:
    track, smoothed = flight.track, flight.smoothed
    doubts = track.doubts or (("", "", ""),) * len(track)
    doubted = np.array([[bool(why) for why in parts] for parts in doubts], dtype=np.float64).reshape(-1, len(_PARTS))
    set_aside = smoothed.set_aside if len(smoothed.set_aside) else np.zeros_like(smoothed.uncertainty)
    return {
        "frame": flight.numbers.astype(np.float64),
        "status": np.array([STATUSES.index(status) for status in track.status], dtype=np.float64),
        "doubted": doubted,
        "smoothed": smoothed.pose.coordinates,
        "smoothed_sd": smoothed.uncertainty,
        "smoothed_rate": smoothed.rate,
        "smoothed_rate_sd": smoothed.rate_uncertainty,
        "set_aside": set_aside.astype(np.float64),
        "raw": track.pose.coordinates,
        "raw_sd": track.uncertainty,
        "overlap": track.overlap,
        "precision": track.precision,
    }


def _known(pose: Pose) -> NDArray[np.bool_]:
    return np.all(np.isfinite(pose.coordinates), axis=1)


def _body_axes(pose: Pose) -> FloatArray:
    """R_WB, NaN where nothing is known."""
    axes = np.full((len(pose), 3, 3), np.nan)
    known = _known(pose)
    axes[known] = pose[known].body_axes_W
    return axes


def _heading(pose: Pose) -> FloatArray:
    """(N,) of the stroke plane's forward axis, unwrapped over the frames that are known [rad]."""
    ahead = _body_axes(pose) @ pitch_rotation(pose.stroke_plane_angle).T[:, 0]
    yaw, known = np.full(len(pose), np.nan), _known(pose)
    yaw[known] = np.unwrap(np.arctan2(-ahead[known, 1], ahead[known, 0]))
    return yaw


def _attitude(pose: Pose) -> FloatArray:
    """(N, 4) scalar first, without jumps of sign; NaN where nothing is known."""
    q, known = np.full((len(pose), 4), np.nan), _known(pose)
    turned = pose[known].q_WB
    flips = np.cumprod(np.where(np.sum(turned[1:] * turned[:-1], axis=1) < 0, -1.0, 1.0))
    turned[1:] *= flips[:, None]
    q[known] = turned
    return q

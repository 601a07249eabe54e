"""result.json of a tracked flight; `FIELDS` says what each field holds."""

from __future__ import annotations

import json
import platform
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.camera import Camera
from flycontrol.model.pose import COORDINATES
from flycontrol.report.result import finite
from flycontrol.report.track.beats import stroke_reversals
from flycontrol.report.track.truth import rms_errors
from flycontrol.units import deg, mm, um
from flycontrol.vision.checks.calibration_check import CalibrationCheck
from flycontrol.vision.tracked_flight import TrackedFlight
from flycontrol.vision.tracked_frame import STATUSES, Track

FloatArray = NDArray[np.float64]

_MADE_WITH = ("flycontrol", "numpy", "scipy", "numba", "matplotlib", "h5py", "pillow")

FIELDS: dict[str, str] = {
    "name": "of the flight",
    "status": "a sentence: how many frames were tracked",
    "unsmoothed": "why there are no smoothed coordinates, yaw, attitude and rates; null: there are",
    "frames.first": "number of the first frame in the films, from 0",
    "frames.step": "from one frame to the next",
    "frames.count": "how many",
    "frames.rate_hz": "frames a second",
    "frames.tracked": "seen and believed",
    "frames.partial": "seen, but a wing is not, or cut by the border of an image, or with another animal in view",
    "frames.bridged": "not believed: expected from the frames before, and smoothed over",
    "frames.lost": "bridged for too long, or before the fly was found: no coordinates",
    "unusual[].first": "number of the first frame of a stretch that was not plainly tracked",
    "unusual[].last": "of its last frame",
    "unusual[].status": "partial, bridged or lost",
    "unusual[].reason": "a sentence",
    "wingbeat_frequency_hz": "of the stroke; from reversal to reversal; null where no whole wingbeat was seen",
    "world": "how the world of this file lies in that of the calibration",
    "cameras[].name": "of a camera",
    "cameras[].rows": "of its images",
    "cameras[].columns": "of its images",
    "cameras[].overlap_median": "intersection over union of the fly and the silhouette",
    "cameras[].overlap_10_percent": "one frame in ten is worse",
    "calibration.residual_px": "median epipolar residual of the silhouettes' extremes, all pairs of cameras",
    "calibration.pairs[].cameras[]": "two of them",
    "calibration.pairs[].shift_px": "median of |shift|: how far planes that touch the silhouettes miss each other",
    "calibration.pairs[].growth_px": "median growth of the second silhouette: thresholds that differ, parts unseen",
    "calibration.doubt": "a sentence: a large residual, few frames a second, a fly seen on its back; null: none",
    "fly.file": "that the sizes were taken from",
    "fly.wing_length_mm": "base to tip, as tracked",
    "fly.body_length_mm": "as tracked",
    "fly.stroke_plane_angle_deg": "of the stroke plane from the body's long axis; all wing angles depend on it",
    "fly.fitted": "whether sizes were fitted to the silhouettes",
    "fly.factors.*": "fitted sizes over those of the file",
    "refined": "whether the parametric fly was fitted to the silhouettes; otherwise the hull alone was read",
    "uncertainty.raw.*": "median standard deviation of each coordinate, frame by frame; um or deg",
    "uncertainty.smoothed.*": "likewise of the smoothed coordinates",
    "set_aside.*": "numbers of frames in which a coordinate was seen but is too far from its neighbours to count",
    "error.raw.*": "root mean square against the truth of a simulated flight, frames tracked or partial, a wing's "
    "over those of them in which it was seen; um or deg",
    "error.smoothed.*": "of the smoothed coordinates, all frames tracked or partial",
    "anipose": "why there is no cameras.toml; null: there is one",
    "files.*": "what lies beside this file",
    "provenance.command": "that made this",
    "provenance.films[]": "names of the films",
    "provenance.images_sha256": "of the pixels of frames spread over the films",
    "provenance.cameras": "name of the calibration's file",
    "provenance.cameras_sha256": "of its bytes",
    "provenance.fly_sha256": "of the fly's file",
    "provenance.notes[]": "what was decided in reading the films",
    "provenance.versions.*": "of Python and the packages that computed",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackOrigin:
    """Where a tracked flight comes from: no clock, no machine, no user."""

    command: str
    films: tuple[str, ...]
    images_sha256: str
    cameras: str | None  #: name of the calibration's file; None: simulated
    cameras_sha256: str | None
    fly: str  #: name of its file
    fly_sha256: str
    notes: tuple[str, ...] = ()


def tracked_result(
    flight: TrackedFlight, origin: TrackOrigin, files: Mapping[str, str], no_anipose: str = ""
) -> dict[str, Any]:
    """All fields, numbers unrounded, None where a number does not exist."""
    fields = {
        "name": flight.name,
        "status": status_sentence(flight.track),
        "unsmoothed": flight.unsmoothed or None,
        "frames": _frames(flight),
        "unusual": unusual_stretches(flight),
        "wingbeat_frequency_hz": wingbeat_frequency(flight),
        "world": flight.world,
        "cameras": [_camera(camera, view) for camera, view in zip(flight.cameras, flight.track.overlap.T, strict=True)],
        "calibration": _calibration(flight.check) | {"doubt": flight.doubt or None},
        "fly": _fly(flight, origin),
        "refined": flight.refined,
        "uncertainty": {
            "raw": _per_coordinate(_median(flight.track.uncertainty)),
            "smoothed": _per_coordinate(_median(flight.smoothed.uncertainty)),
        },
        "set_aside": _set_aside(flight),
        **_errors(flight),
        "anipose": no_anipose or None,
        "files": dict(files),
        "provenance": _provenance(origin),
    }
    return finite(fields)


def tracked_result_json(
    flight: TrackedFlight, origin: TrackOrigin, files: Mapping[str, str], no_anipose: str = ""
) -> str:
    """`tracked_result` as text, with the meaning and unit of each field."""
    return json.dumps({"fields": FIELDS} | tracked_result(flight, origin, files, no_anipose), indent=1) + "\n"


def status_sentence(track: Track) -> str:
    """How many frames were tracked, and what became of the others."""
    counts = Counter(track.status)
    others = [f"{counts[status]} {status}" for status in STATUSES[1:] if counts[status]]
    seen = f"{counts['tracked']} of {len(track)} frames tracked"
    return f"{seen}, {', '.join(others)}." if others else f"{seen}."


def nothing_tracked(track: Track) -> str:
    """That no frame was tracked and why most often; empty where one was, or most show the fly in part."""
    partial = track.status.count("partial")
    if "tracked" in track.status or 2 * partial >= len(track):
        return ""
    (reason, often), *_ = Counter(track.reasons).most_common(1)
    return f"No frame was tracked; most often, in {often} of {len(track)}: {reason or 'no reason given'}."


def wingbeat_frequency(flight: TrackedFlight) -> float | None:
    """Of the mean stroke of both wings in the longest stretch without a gap [1/s]; None without a whole wingbeat."""
    return stroke_reversals(flight).frequency


def unusual_stretches(flight: TrackedFlight) -> list[dict[str, Any]]:
    """Frames that were not plainly tracked, neighbours of one status and reason together."""
    track, numbers = flight.track, flight.numbers
    stretches: list[dict[str, Any]] = []
    for (status, reason), run in groupby(range(len(track)), key=lambda k: (track.status[k], track.reasons[k])):
        frames = list(run)
        if status != "tracked":
            ends = {"first": int(numbers[frames[0]]), "last": int(numbers[frames[-1]])}
            stretches.append({**ends, "status": status, "reason": reason})
    return stretches


def _frames(flight: TrackedFlight) -> dict[str, Any]:
    numbers, counts = flight.numbers, Counter(flight.track.status)
    return {
        "first": int(numbers[0]),
        "step": int(numbers[1] - numbers[0]) if len(numbers) > 1 else 1,
        "count": len(numbers),
        "rate_hz": flight.frame_rate,
        **{status: counts[status] for status in STATUSES},
    }


def _camera(camera: Camera, overlap: FloatArray) -> dict[str, Any]:
    compared = overlap[np.isfinite(overlap)]
    middle, low = np.percentile(compared, [50, 10]) if len(compared) else (np.nan, np.nan)
    return {
        "name": camera.name,
        "rows": int(camera.shape[0]),
        "columns": int(camera.shape[1]),
        "overlap_median": middle,
        "overlap_10_percent": low,
    }


def _calibration(check: CalibrationCheck) -> dict[str, Any]:
    pairs = [
        {"cameras": list(pair.cameras), "shift_px": pair.median, "growth_px": float(np.nanmedian(pair.growth))}
        for pair in check.pairs
    ]
    return {"residual_px": check.residual, "pairs": pairs}


def _fly(flight: TrackedFlight, origin: TrackOrigin) -> dict[str, Any]:
    return {
        "file": origin.fly,
        "wing_length_mm": float(flight.fly.shape.wing[-1, 0]) / mm,
        "body_length_mm": flight.fly.shape.body_length / mm,
        "stroke_plane_angle_deg": flight.fly.stroke_plane_angle / deg,
        "fitted": flight.sizes_fitted,
        "factors": {} if flight.sizes is None else asdict(flight.sizes),
    }


def _set_aside(flight: TrackedFlight) -> dict[str, list[int]]:
    aside = flight.smoothed.set_aside.astype(np.bool_)
    where = {name: flight.numbers[aside[:, k]].tolist() for k, name in enumerate(COORDINATES)} if len(aside) else {}
    return {name: frames for name, frames in where.items() if frames}


def _errors(flight: TrackedFlight) -> dict[str, Any]:
    if flight.truth is None:
        return {}
    raw, smooth = rms_errors(flight, flight.truth)
    return {"error": {"raw": _per_coordinate(raw), "smoothed": _per_coordinate(smooth)}}


def _median(values: FloatArray) -> FloatArray:
    known = values[np.all(np.isfinite(values), axis=1)]
    return np.median(known, axis=0) if len(known) else np.full(len(COORDINATES), np.nan)


def _per_coordinate(values: Sequence[float] | FloatArray) -> dict[str, float]:
    angle = [3 <= k < 12 for k in range(len(COORDINATES))]
    return {
        f"{name}_{'deg' if turns else 'um'}": float(value) / (deg if turns else um)
        for name, value, turns in zip(COORDINATES, values, angle, strict=True)
    }


def _provenance(origin: TrackOrigin) -> dict[str, Any]:
    return {
        "command": origin.command,
        "films": list(origin.films),
        "images_sha256": origin.images_sha256,
        "cameras": origin.cameras,
        "cameras_sha256": origin.cameras_sha256,
        "fly_sha256": origin.fly_sha256,
        "notes": list(origin.notes),
        "versions": {"Python": platform.python_version()} | {name: version(name) for name in _MADE_WITH},
    }

"""What a tracked flight's page says in words and tables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.camera import Camera
from flycontrol.model.camera_forms import pinhole_of
from flycontrol.report.numbers import counted, fixed, milliseconds, sentence
from flycontrol.report.track.beats import StrokeReversals
from flycontrol.report.track.spans import Span, spans, tally
from flycontrol.report.track.truth import CoordinateError, coordinate_errors
from flycontrol.units import deg, mm
from flycontrol.vision.tracked_flight import TrackedFlight
from flycontrol.vision.tracked_frame import STATUSES

FloatArray = NDArray[np.float64]

STATUS_MEANING = {
    "tracked": "body and both wings seen, and believed",
    "partial": "the body is believed; a wing is not, or a silhouette reaches the border of its image, or another "
    "animal is in view",
    "bridged": "not believed, or not to be seen: expected from the frames before, with growing uncertainty",
    "lost": "bridged for too long: no coordinates",
}
_MOST_SPANS = 60  #: rows of the table of frames that are not tracked


@dataclass(frozen=True, slots=True)
class Row:
    """A line of a table."""

    head: str
    values: tuple[str, ...]


def lead(flight: TrackedFlight, reversals: StrokeReversals) -> list[str]:
    """What was found, in a few sentences; the first is the main one."""
    counts, count = tally(flight.track), len(flight.track)
    others = [f"{counts[status]} {status}" for status in STATUSES[1:] if counts[status]]
    lasting = float(flight.time[-1] - flight.time[0]) if count > 1 else 0.0
    first = f"{counts['tracked']} of {counted(count, 'frame')} {'is' if counts['tracked'] == 1 else 'are'} tracked"
    first += f" over {milliseconds(lasting)}" if lasting else ""
    first += f", {_listed(others)}." if others else "."
    sentences = [sentence for sentence in (first, flight.unsmoothed, _method(flight)) if sentence]
    overlap = median_overlap(flight)
    if overlap is not None:
        sentences.append(
            f"In the median over frames and views the fly and its silhouette share {fixed(100 * overlap, 1, '%')} of "
            "the area that either of them covers."
        )
    if reversals.frequency is not None:
        sentences.append(f"The wings beat at {fixed(reversals.frequency, 1, 'Hz')}.")
    residual = flight.check.residual
    sentences.append(f"The cameras and the silhouettes agree to {fixed(residual, 2, 'px')} across the epipolar planes.")
    if flight.truth is not None and np.any(flight.track.believed):
        sentences.append(_against_truth(coordinate_errors(flight, flight.truth)))
    if flight.doubt:
        told = sentence(flight.doubt).rstrip(".")
        sentences.append(f"{told[0].upper()}{told[1:]}.")
    return sentences


def median_overlap(flight: TrackedFlight) -> float | None:
    """Intersection over union of fly and silhouette, median over seen frames and views."""
    seen = flight.track.overlap[flight.track.believed]
    return float(np.nanmedian(seen)) if np.any(np.isfinite(seen)) else None


def status_rows(flight: TrackedFlight) -> list[Row]:
    """How many frames of each status, all of them counted."""
    count = max(len(flight.track), 1)
    rows = [
        Row(status.capitalize(), (str(number), fixed(100 * number / count, 1, "%"), STATUS_MEANING[status]))
        for status, number in tally(flight.track).items()
    ]
    return [*rows, Row("All", (str(len(flight.track)), "", ""))]


def camera_rows(flight: TrackedFlight) -> list[Row]:
    """Every camera: its images, scale at the fly, focal length, place and lens."""
    position = flight.track.pose.position_W
    known = position[np.all(np.isfinite(position), axis=1)]
    return [_camera_row(camera, known) for camera in flight.cameras]


def pair_rows(flight: TrackedFlight) -> list[Row]:
    """Every pair of cameras: how far the planes that touch the silhouettes miss each other."""
    return [
        Row(
            " and ".join(pair.cameras),
            (
                _of_known(np.abs(pair.shift), 50),
                _of_known(np.abs(pair.shift), 90),
                _of_known(pair.growth, 50),
            ),
        )
        for pair in flight.check.pairs
    ]


def size_rows(flight: TrackedFlight) -> list[Row]:
    """The fly."""
    shape = flight.fly.shape
    span, leading, trailing = shape.wing.T
    area = float(np.trapezoid(leading - trailing, span))
    base = " / ".join(fixed(value / mm, 2) for value in shape.right_base_B)
    how = "fitted to the silhouettes of this flight" if flight.sizes_fitted else "as given"
    by = {name: _factor(flight, name) for name in ("body_length", "body_radius", "wing_length", "wing_chord")}
    return [
        Row("Body length", (fixed(shape.body_length / mm, 2, "mm"), how + by["body_length"])),
        Row(
            "Largest width of the body",
            (fixed(2 * float(shape.profile[:, 1].max()) / mm, 2, "mm"), how + by["body_radius"]),
        ),
        Row("Wing length", (fixed(float(span[-1]) / mm, 2, "mm"), f"base to tip; {how}{by['wing_length']}")),
        Row(
            "Mean chord",
            (fixed(area / float(span[-1] - span[0]) / mm, 2, "mm"), f"area over length; {how}{by['wing_chord']}"),
        ),
        Row("Base of the right wing", (f"{base} mm", f"forward, right, down of the body’s centre; {how}")),
        Row(
            "Stroke plane",
            (fixed(flight.fly.stroke_plane_angle / deg, 1) + "°", "nose down from the body’s long axis; as given"),
        ),
    ]


def span_rows(flight: TrackedFlight) -> list[Row]:
    """Frames that are not simply tracked, neighbours together, with the reason; the last row counts what is left."""
    found = [span for span in spans(flight.track) if span.status != "tracked"]
    rows = [
        Row(
            _numbers(flight, span),
            (
                milliseconds(float(flight.time[span.first]), 2),
                str(len(span)),
                span.status,
                sentence(span.reason) or "no reason given",
            ),
        )
        for span in found[:_MOST_SPANS]
    ]
    left = found[_MOST_SPANS:]
    if left:
        frames = sum(len(span) for span in left)
        rows.append(Row("later", ("", str(frames), "", f"{counted(len(left), 'more range')}, in the files")))
    return rows


def _against_truth(errors: list[CoordinateError]) -> str:
    by_name = {error.name: error.smoothed for error in errors}
    wings = {
        words: max(by_name[f"Left {name}"], by_name[f"Right {name}"])
        for words, name in (("stroke", "stroke"), ("deviation", "deviation"), ("wing pitch", "wing pitch"))
    }
    body = ", ".join(f"{name.lower()} by {fixed(by_name[name], 2)}°" for name in ("Yaw", "Pitch", "Roll"))
    sides = ", ".join(f"{words} by {fixed(value, 2)}°" for words, value in wings.items())
    return f"Against the simulated truth, smoothed, {body} are off in the root mean square, and {sides} at the most."


def _numbers(flight: TrackedFlight, span: Span) -> str:
    first, last = flight.numbers[[span.first, span.last]]
    return str(first) if len(span) == 1 else f"{first}–{last}"


def _method(flight: TrackedFlight) -> str:
    sizes = "fitted to it" if flight.sizes_fitted else "given"
    if flight.refined:
        return f"A parametric fly, its sizes {sizes}, was fitted to all silhouettes of each frame."
    return f"The coordinates were read off the visual hull alone, without a fit; the fly’s sizes were {sizes}."


def _camera_row(camera: Camera, known: FloatArray) -> Row:
    scale = fixed(float(np.median(camera.pixels_per_metre(known))) * mm, 2) if len(known) else "—"
    if camera.orthographic:
        place = f"looks along ({', '.join(fixed(part, 2) for part in camera.direction)})"
        focal = "none: orthographic"
    else:
        place = ", ".join(fixed(part / mm, 1) for part in camera.centre)
        K = pinhole_of(camera).intrinsic
        focal = fixed(float(np.sqrt(abs(K[0, 0] * K[1, 1]))), 0)
    lens = "ideal" if camera.distortion is None else "distorting"
    return Row(camera.name, (f"{camera.shape[1]} × {camera.shape[0]}", scale, focal, place, lens))


def _factor(flight: TrackedFlight, name: str) -> str:
    return "" if flight.sizes is None else f", {fixed(getattr(flight.sizes, name), 3)} times what was given"


def _of_known(values: FloatArray, percentile: float) -> str:
    known = values[np.isfinite(values)]
    return fixed(float(np.percentile(known, percentile)), 2) if len(known) else "—"


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"

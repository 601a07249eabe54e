"""The figures of a tracked flight, each with a caption that states what it shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flycontrol.report.figures.track_coordinates import (
    BASES,
    BODY,
    WINGS,
    bands_are_cut,
    coordinates_over_time,
)
from flycontrol.report.figures.track_hull import hull_from_two_sides
from flycontrol.report.figures.track_overlay import frame_overlay
from flycontrol.report.figures.track_quality import agreement_over_time, uncertainty_over_time
from flycontrol.report.figures.track_rates import body_rates
from flycontrol.report.numbers import fixed, milliseconds, sentence
from flycontrol.report.page_figures import PageFigure
from flycontrol.report.style import svg
from flycontrol.report.track.beats import CLOSELY, StrokeReversals, piece_shown_closely
from flycontrol.report.track.chosen import ChosenFrame
from flycontrol.report.track.curves import Curves, curves
from flycontrol.report.track.hulls import SeenHull
from flycontrol.report.track.overlays import FrameOverlay
from flycontrol.report.track.spans import Span, spans
from flycontrol.report.track.survey import Survey
from flycontrol.units import deg, um
from flycontrol.vision.dissection import BODY as BODY_VOXELS
from flycontrol.vision.dissection import LEFT, REST, RIGHT
from flycontrol.vision.tracked_flight import TrackedFlight

FloatArray = NDArray[np.float64]

_WINGS = ("left wing", "right wing")
_ENDS, _SHARE_OF_ENDS = 3, 0.1  #: frames, and share of the flight, at either end of which no largest rate is told


def track_figures(
    flight: TrackedFlight,
    reversals: StrokeReversals,
    survey: Survey,
    looked_at: Sequence[tuple[ChosenFrame, FrameOverlay]],
    hulls: Sequence[SeenHull],
) -> dict[str, PageFigure]:
    """Draw every figure that the flight has parts for, by name, in the order of the page."""
    drawn = [_overlay(flight, chosen, overlay) for chosen, overlay in looked_at]
    if np.any(flight.track.believed) or not flight.unsmoothed:
        drawn += _coordinates(flight, reversals)
    if not flight.unsmoothed:
        drawn.append(_rates(flight))
    drawn += [_hull(flight, seen) for seen in hulls]
    drawn.append(_agreement(flight, survey))
    if np.any(np.isfinite(flight.track.uncertainty)):
        drawn.append(_uncertainty(flight))
    return {figure.name: figure for figure in drawn}


def _page_figure(name: str, figure: Figure, title: str, caption: str) -> PageFigure:
    return PageFigure(name=name, title=title, caption=caption, drawing=svg(figure, name, title))


def _overlay(flight: TrackedFlight, chosen: ChosenFrame, overlay: FrameOverlay) -> PageFigure:
    k = overlay.frame
    status, reason, seen = flight.track.status[k], flight.track.reasons[k], flight.track.overlap[k]
    caption = f"Chosen as {'; and as '.join(chosen.rules)}. The frame is {status}"
    caption += f": {sentence(reason).rstrip('.')}." if reason else "."
    if np.all(np.isfinite(seen)):
        said = ", ".join(
            f"{camera.name} {fixed(100 * float(value), 1, '%')}"
            for value, camera in zip(seen, flight.cameras, strict=True)
        )
        caption += f" Overlap: {said}."
    title = f"Frame {flight.numbers[k]}, {milliseconds(float(flight.time[k]), 2)}, {status}"
    return _page_figure(f"frame-{k}", frame_overlay(overlay), title, caption)


def _coordinates(flight: TrackedFlight, reversals: StrokeReversals) -> list[PageFigure]:
    drawn, found, piece = curves(flight), spans(flight.track), piece_shown_closely(flight, reversals)
    raw = "As read frame by frame alone, since nothing could be smoothed. " if flight.unsmoothed else ""
    figures = [
        _page_figure(
            "body", coordinates_over_time(drawn, BODY, ("place of the centre", "attitude"), found),
            "Place and attitude of the body", f"{raw}{_body_words(drawn)}{_cut(drawn, BODY)}",
        ),
        _page_figure(
            "wings", coordinates_over_time(drawn, WINGS, _WINGS, found), "Angles of the wings",
            f"{raw}{_wing_words(flight)}{_cut(drawn, WINGS)}",
        ),
    ]  # fmt: skip
    if piece is not None:
        figures.append(_closely(flight, drawn, found, piece, reversals))
    caption = (
        f"{raw}Places of the bases from the body’s centre, along body axes. They hardly move on a fly; the fit holds "
        "them near where the shape has them, and their scatter shows how well the roll of a round body can be told."
        f"{_cut(drawn, BASES)}"
    )
    figures.append(
        _page_figure("bases", coordinates_over_time(drawn, BASES, _WINGS, found), "Bases of the wings", caption)
    )
    return figures


def _closely(
    flight: TrackedFlight, drawn: Curves, found: list[Span], piece: tuple[int, int], reversals: StrokeReversals
) -> PageFigure:
    much = "frames" if reversals.frequency is None else f"{CLOSELY} wingbeats"
    first, last = flight.numbers[list(piece)]
    caption = (
        f"The {much} over which the heading changes most: frames {first} to {last}, from "
        f"{milliseconds(float(flight.time[piece[0]]), 2)}.{_cut(drawn, WINGS, slice(piece[0], piece[1] + 1))}"
    )
    return _page_figure(
        "wings-closely", coordinates_over_time(drawn, WINGS, _WINGS, found, piece), "Angles of the wings, closely",
        caption,
    )  # fmt: skip


def _cut(drawn: Curves, panels: Sequence[tuple[int, str]], rows: slice = slice(None)) -> str:
    return " Where a band is far wider than elsewhere the panel cuts it." if bands_are_cut(drawn, panels, rows) else ""


def _body_words(drawn: Curves) -> str:
    yaw = drawn.smooth[:, 3]
    yaw = yaw[np.isfinite(yaw)]
    caption = "World z is up. The heading goes on through 180° without a jump."
    if len(yaw) > 1:
        turned = float(yaw[-1] - yaw[0])
        side = "right" if turned >= 0 else "left"
        caption = f"From first to last the heading turns {fixed(abs(turned), 1)}° to the {side}. {caption}"
    return caption


def _wing_words(flight: TrackedFlight) -> str:
    said: list[str] = []
    for side in ("left", "right"):
        stroke = flight.smoothed.pose.wing(side).stroke / deg
        stroke = stroke[np.isfinite(stroke)]
        if len(stroke) > 1:
            low, high = (fixed(float(value), 0) for value in (stroke.min(), stroke.max()))
            said.append(f"the {side} wing from {low}° to {high}°")
    swept = f"In stroke {' and '.join(said)}. " if said else ""
    return (
        f"{swept}Stroke is positive forward, deviation above the stroke plane, and a pitch of 90° is a vertical chord."
    )


def _rates(flight: TrackedFlight) -> PageFigure:
    caption = (
        "Derivatives of the smoothed curves; bands are those of the smoother and know nothing of errors that frames "
        "share."
    )
    yaw = flight.smoothed.angular_velocity_B[:, 2]
    k = fastest_within(yaw)
    if k is not None:
        side = "right" if yaw[k] >= 0 else "left"
        caption = (
            "Away from the ends of the recording the body turns about its own down axis at up to "
            f"{fixed(abs(float(yaw[k])), 1, 'rad/s')}, to the {side}, at {milliseconds(float(flight.time[k]), 2)}. "
            f"{caption}"
        )
    return _page_figure("rates", body_rates(flight, spans(flight.track)), "Rates of the body", caption)


def fastest_within(rate: FloatArray) -> int | None:
    """Where |rate| (N,) is largest, but for the ends of what is known, where a spline is held from one side only."""
    known = np.flatnonzero(np.isfinite(rate))
    left_out = max(_ENDS, int(np.ceil(_SHARE_OF_ENDS * len(known))))
    inner = known[left_out : len(known) - left_out]
    return int(inner[np.argmax(np.abs(rate[inner]))]) if len(inner) else None


def _hull(flight: TrackedFlight, seen: SeenHull) -> PageFigure:
    parts, number = seen.voxels, flight.numbers[seen.frame]
    caption = (
        f"Frame {number}, {flight.track.status[seen.frame]}: {sum(parts.values())} voxels with edges of "
        f"{fixed(seen.size / um, 0, 'µm')}, {parts[BODY_VOXELS]} of the body, {parts[LEFT]} of the left and "
        f"{parts[RIGHT]} of the right wing, {parts[REST]} of none. Lines are the fitted fly. Where no view looks along "
        "a surface, the hull keeps what nothing denies: it is thicker than the fly."
    )
    if not seen.complete:
        caption += " Not every part has voxels enough to be found by itself."
    return _page_figure(
        f"hull-{seen.frame}", hull_from_two_sides(seen), f"Hull of frame {number}, taken apart", caption
    )


def _agreement(flight: TrackedFlight, survey: Survey) -> PageFigure:
    which = "" if len(survey.frames) == len(flight.track) else f", of {len(survey.frames)} evenly spread frames"
    caption = (
        "Overlap is the area that fly and silhouette share over the area that either covers; precision the share of "
        "the fly on the silhouette: legs lower the first alone. Covered is the share of the silhouette under the hull"
        f"{which}: what is missing another view contradicts."
    )
    uncovered = survey.uncovered[np.isfinite(survey.uncovered)]
    if len(uncovered):
        caption += (
            f" In the median {fixed(float(np.median(uncovered)), 0, 'px')} of a silhouette are uncovered"
            f"{_worst_covered(flight, survey)}."
        )
    return _page_figure(
        "agreement", agreement_over_time(flight, survey, spans(flight.track)), "Agreement frame by frame", caption
    )


def _worst_covered(flight: TrackedFlight, survey: Survey) -> str:
    worst = survey.least_covered
    if worst is None:
        return ""
    row, view = worst
    k = int(survey.frames[row])
    return (
        f", at the most {fixed(float(survey.uncovered[row, view]), 0, 'px')}, "
        f"{fixed(100 * (1 - float(survey.coverage[row, view])), 0, '%')} of the silhouette "
        f"“{flight.cameras[view].name}”, in frame {flight.numbers[k]} at {milliseconds(float(flight.time[k]), 2)}, "
        "which is among the frames looked at"
    )


def _uncertainty(flight: TrackedFlight) -> PageFigure:
    caption = (
        "Standard deviations of what was read in each frame by itself, root mean square within each group. They come "
        "from the fit’s curvature and grow over a bridge, of a wing alone too."
    )
    return _page_figure(
        "uncertainty", uncertainty_over_time(flight, spans(flight.track)), "Uncertainty frame by frame", caption
    )

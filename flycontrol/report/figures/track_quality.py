"""How well fly and silhouettes agree, frame by frame, and how certain the coordinates are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator
from numpy.typing import NDArray

from flycontrol.report.figures.track_panels import (
    SERIES,
    SHADES,
    drawn_line,
    frame_edges,
    leave_room_for_labels,
    legend_on_top,
    limit_to,
    shade,
    shade_keys,
)
from flycontrol.report.style import EXACT, in_house_style, new_figure, plain_log_ticks
from flycontrol.report.track.spans import Span
from flycontrol.report.track.survey import Survey
from flycontrol.units import deg, ms, um
from flycontrol.vision.tracked_flight import TrackedFlight
from flycontrol.vision.tracked_frame import STATUSES

FloatArray = NDArray[np.float64]

_GROUPS = (
    (((slice(0, 3), "body’s centre"), (slice(12, 18), "wings’ bases")), um, "σ of places [µm]"),
    (
        ((slice(3, 5), "body’s yaw and pitch"), (slice(5, 6), "roll"), ((6, 7, 9, 10), "stroke and deviation"),
         ((8, 11), "wing pitch")),
        deg, "σ of angles [deg]",
    ),
)  # fmt: skip


_FEW = 150  #: frames


@in_house_style()
def agreement_over_time(flight: TrackedFlight, survey: Survey, spans: Sequence[Span]) -> Figure:
    """Status, overlap and precision of fly and silhouettes in each view, and what the hull covers [%]."""
    figure = new_figure(5.6)
    strip, *panels = figure.subplots(4, 1, sharex=True, height_ratios=[0.5, 1, 1, 1])
    time = flight.time / ms
    _strip(strip, time, spans)
    every = np.arange(len(time))
    rows = (
        ("overlap [%]", flight.track.overlap, every),
        ("precision [%]", flight.track.precision, every),
        ("covered by\nthe hull [%]", survey.coverage, survey.frames),
    )
    for ax, (label, value, at) in zip(panels, rows, strict=True):
        shade(ax, time, spans)
        for c, line in enumerate(_lines(flight)):
            ax.plot(*drawn_line(time[at], 100 * value[:, c]), **line, **_dots(len(at)))
        ax.set_ylabel(label)
        _to_full(ax)
    panels[-1].set_xlabel("time [ms]")
    limit_to(strip, time)
    figure.align_ylabels([strip, *panels])
    legend_on_top(figure, [Line2D([], [], **line) for line in _lines(flight)] + shade_keys(spans))
    leave_room_for_labels(figure)
    return figure


@in_house_style()
def uncertainty_over_time(flight: TrackedFlight, spans: Sequence[Span]) -> Figure:
    """Standard deviations of the coordinates as read in each frame, root mean square of a group [um, deg]."""
    figure = new_figure(4.0)
    panels = figure.subplots(2, 1, sharex=True)
    time = flight.time / ms
    for ax, (groups, unit, label) in zip(panels, _GROUPS, strict=True):
        shade(ax, time, spans)
        for (columns, name), line in zip(groups, SERIES, strict=False):
            chosen = flight.track.uncertainty[:, columns if isinstance(columns, slice) else list(columns)]
            spread = np.sqrt(np.mean(np.square(chosen), axis=1)) / unit
            ax.plot(*drawn_line(time, spread), **line, **_dots(len(time)), label=name)
        ax.set_ylabel(label)
        _logarithmic(ax)
        ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=4, borderaxespad=0.2)
    panels[-1].set_xlabel("time [ms]")
    limit_to(panels[-1], time)
    figure.align_ylabels(panels)
    if shade_keys(spans):
        legend_on_top(figure, shade_keys(spans))
    leave_room_for_labels(figure)
    return figure


def _strip(ax: Axes, time: FloatArray, spans: Sequence[Span]) -> None:
    """A row for each status that occurs, and bars where it does."""
    edges = frame_edges(time)
    present = [status for status in STATUSES if any(span.status == status for span in spans)]
    for row, status in enumerate(reversed(present)):
        bars = [
            (edges[span.first], edges[span.last + 1] - edges[span.first]) for span in spans if span.status == status
        ]
        look: dict[str, Any] = {"facecolor": EXACT} if status == "tracked" else SHADES[status]
        ax.broken_barh(bars, (row + 0.1, 0.8), **{**look, "edgecolor": look.get("edgecolor", "none")})
    ax.set_yticks(np.arange(len(present)) + 0.5, list(reversed(present)))
    ax.set_ylim(0, len(present))
    ax.tick_params(axis="y", length=0)


def _lines(flight: TrackedFlight) -> list[dict[str, Any]]:
    return [
        {**SERIES[c % len(SERIES)], "label": camera.name, "linewidth": 1.0} for c, camera in enumerate(flight.cameras)
    ]


def _dots(count: int) -> dict[str, Any]:
    """A dot for each frame where there are few: one between two that were not seen has no line."""
    return {"marker": "o", "markersize": 1.6} if count <= _FEW else {}


def _to_full(ax: Axes) -> None:
    """Up to 100 %, and down to what there is."""
    low = ax.get_ylim()[0]
    ax.set_ylim(max(min(low, 90.0), -2.0), 101.0)


def _logarithmic(ax: Axes) -> None:
    values = np.concatenate([np.asarray(line.get_ydata(), dtype=np.float64) for line in ax.lines])
    if not np.any(values > 0):
        return
    low, high = np.nanmin(values[values > 0]), np.nanmax(values)
    ax.set_ylim(low / 1.5, max(high * 1.5, 12 * low))
    ax.set_yscale("log")
    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    plain_log_ticks(ax, "y")

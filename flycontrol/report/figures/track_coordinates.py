"""The 18 coordinates over time: as read frame by frame, smoothed with its band, and the truth where it is known."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from flycontrol.report.figures.track_panels import (
    BAND,
    SMOOTHED,
    TRUTH,
    drawn_line,
    drawn_points,
    leave_room_for_labels,
    legend_on_top,
    limit_to,
    shade,
    shade_keys,
)
from flycontrol.report.style import EXACT, in_house_style, new_figure
from flycontrol.report.track.curves import SIGMAS, Curves
from flycontrol.report.track.spans import Span

FloatArray = NDArray[np.float64]

#: Columns of a pose, panel by panel from the left, row by row, and what stands beside them.
BODY = (
    (0, "x [mm]"), (3, "yaw, to the right [deg]"), (1, "y [mm]"), (4, "pitch, nose up [deg]"), (2, "z, up [mm]"),
    (5, "roll, right down [deg]"),
)  # fmt: skip
WINGS = (
    (6, "stroke [deg]"), (9, "stroke [deg]"), (7, "deviation [deg]"), (10, "deviation [deg]"), (8, "pitch [deg]"),
    (11, "pitch [deg]"),
)  # fmt: skip
BASES = (
    (12, "forward [mm]"), (15, "forward [mm]"), (13, "right [mm]"), (16, "right [mm]"), (14, "down [mm]"),
    (17, "down [mm]"),
)  # fmt: skip
_RAW: dict[str, Any] = {
    "linestyle": "none", "marker": "o", "markersize": 2.2, "color": "#8a8a8a", "markeredgewidth": 0,
}  # fmt: skip
_RAW_KEY: dict[str, Any] = {**_RAW, "markersize": 3}
_MOST_OF_A_BAND, _MARGIN = (3.0, 97.0), 0.05  #: percentiles that a panel shows, and share of its height beyond
_FAR = 1.5  #: times that height, beyond which the rest of a band is cut
_LEAST = {"deg": 1.0, "mm": 0.02}  #: of a panel's height: less is noise


@in_house_style()
def coordinates_over_time(
    curves: Curves,
    panels: Sequence[tuple[int, str]],
    titles: tuple[str, str],
    spans: Sequence[Span],
    piece: tuple[int, int] | None = None,
) -> Figure:
    """Six panels in two columns [mm, deg]; of the whole flight, or of the frames of a piece."""
    figure = new_figure(5.2)
    axes = figure.subplots(3, 2, sharex=True)
    rows = slice(0, None) if piece is None else slice(piece[0], piece[1] + 1)
    for ax, (column, label) in zip(axes.flat, panels, strict=True):
        shade(ax, curves.time, spans)
        _draw(ax, curves, column, rows)
        ax.set_ylabel(label)
        limits = shown_limits(curves, column, rows)
        if limits is not None:
            ax.set_ylim(*limits)
        _widen(ax, _LEAST["deg" if "deg" in label else "mm"])
        limit_to(ax, curves.time[rows])
    for ax, title in zip(axes[0], titles, strict=True):
        ax.set_title(title)
    for ax in axes[-1]:
        ax.set_xlabel("time [ms]")
    figure.align_ylabels(axes)
    legend_on_top(figure, [*_keys(curves), *shade_keys(spans)])
    leave_room_for_labels(figure)
    return figure


def shown_limits(curves: Curves, column: int, rows: slice) -> tuple[float, float] | None:
    """Of a panel: points, lines, and the band but for a few frames in which it is far wider; None if of no height."""
    lines = [curves.raw, curves.smooth] if curves.truth is None else [curves.raw, curves.smooth, curves.truth]
    drawn = np.concatenate([line[rows, column] for line in lines])
    band = np.concatenate(_band(curves, column, rows))
    most = [np.percentile(end, _MOST_OF_A_BAND) for end in _band(curves, column, rows) if len(end)]
    known = np.concatenate([drawn[np.isfinite(drawn)], *most])
    if not len(known) or known.min() == known.max():
        return None
    if np.ptp(whole := np.concatenate([known, band])) < _FAR * np.ptp(known):
        known = whole
    low, high = float(known.min()), float(known.max())
    return low - _MARGIN * (high - low), high + _MARGIN * (high - low)


def bands_are_cut(curves: Curves, panels: Sequence[tuple[int, str]], rows: slice) -> bool:
    """Whether some band reaches beyond its panel."""
    for column, _ in panels:
        limits = shown_limits(curves, column, rows)
        if limits is not None and any(
            np.any((end < limits[0]) | (end > limits[1])) for end in _band(curves, column, rows)
        ):
            return True
    return False


def _band(curves: Curves, column: int, rows: slice) -> list[FloatArray]:
    smooth, half = curves.smooth[rows, column], curves.half_band[rows, column]
    known = np.isfinite(smooth) & np.isfinite(half)
    return [(smooth - half)[known], (smooth + half)[known]]


def _draw(ax: Axes, curves: Curves, column: int, rows: slice) -> None:
    time, smooth, half = curves.time[rows], curves.smooth[rows, column], curves.half_band[rows, column]
    low, high = drawn_line(time, smooth - half), drawn_line(time, smooth + half)
    if len(time) > 1:
        ax.fill_between(low[0], low[1], np.interp(low[0], *high), color=BAND, linewidth=0, zorder=1)
        ax.plot(*drawn_line(time, smooth), **SMOOTHED, zorder=3)
    else:
        ax.errorbar(time, smooth, yerr=half, fmt="o", color=EXACT, markersize=3, zorder=3)
    few = drawn_points(len(time))
    ax.plot(time[few], curves.raw[rows, column][few], **_RAW, zorder=2)
    if curves.truth is not None:
        ax.plot(*drawn_line(time, curves.truth[rows, column]), **TRUTH, zorder=4)


def _widen(ax: Axes, least: float) -> None:
    low, high = ax.get_ylim()
    if high - low < least:
        ax.set_ylim((low + high - least) / 2, (low + high + least) / 2)


def _keys(curves: Curves) -> list[Line2D | Patch]:
    keys: list[Line2D | Patch] = [Line2D([], [], label="frame by frame", **_RAW_KEY)]
    if np.any(np.isfinite(curves.smooth)):
        keys.append(Line2D([], [], label="smoothed", **SMOOTHED))
        keys.append(Patch(facecolor=BAND, label=f"95 % band, ±{SIGMAS:.2f} σ"))
    return keys if curves.truth is None else [*keys, Line2D([], [], label="truth", **TRUTH)]

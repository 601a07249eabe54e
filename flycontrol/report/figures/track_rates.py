"""How fast the body turns and moves."""

from __future__ import annotations

from collections.abc import Sequence

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
    leave_room_for_labels,
    legend_on_top,
    limit_to,
    shade,
    shade_keys,
)
from flycontrol.report.style import GUIDE_LINE, in_house_style, new_figure
from flycontrol.report.track.curves import SIGMAS, true_rates
from flycontrol.report.track.spans import Span
from flycontrol.units import ms
from flycontrol.vision.tracked_flight import TrackedFlight

FloatArray = NDArray[np.float64]

_TURNS = ("roll rate [rad/s]", "pitch rate [rad/s]", "yaw rate [rad/s]")
_MOVES = ("along x [m/s]", "along y [m/s]", "along z, up [m/s]")


@in_house_style()
def body_rates(flight: TrackedFlight, spans: Sequence[Span]) -> Figure:
    """Angular velocity in body axes [rad/s] and velocity in the world [m/s], with 95 % bands."""
    smoothed = flight.smoothed
    velocity, turning = (None, None) if flight.truth is None else true_rates(flight.truth, flight.time)
    figure = new_figure(5.2)
    axes = figure.subplots(3, 2, sharex=True)
    for row in range(3):
        columns = (
            (_TURNS[row], smoothed.angular_velocity_B, smoothed.angular_velocity_uncertainty, turning),
            (_MOVES[row], smoothed.rate[:, :3], smoothed.rate_uncertainty[:, :3], velocity),
        )
        for ax, (label, value, spread, truth) in zip(axes[row], columns, strict=True):
            shade(ax, flight.time / ms, spans)
            ax.axhline(0, **GUIDE_LINE)
            _draw(
                ax, flight.time / ms, value[:, row], SIGMAS * spread[:, row], None if truth is None else truth[:, row]
            )
            ax.set_ylabel(label)
            limit_to(ax, flight.time / ms)
    axes[0, 0].set_title("about forward, right, down of the body")
    axes[0, 1].set_title("of the body’s centre, in the world")
    for ax in axes[-1]:
        ax.set_xlabel("time [ms]")
    figure.align_ylabels(axes)
    keys: list[Line2D | Patch] = [
        Line2D([], [], label="smoothed", **SMOOTHED), Patch(facecolor=BAND, label="95 % band")
    ]  # fmt: skip
    keys += [] if flight.truth is None else [Line2D([], [], label="truth", **TRUTH)]
    legend_on_top(figure, [*keys, *shade_keys(spans)])
    leave_room_for_labels(figure)
    return figure


def _draw(ax: Axes, time: FloatArray, value: FloatArray, half: FloatArray, truth: FloatArray | None) -> None:
    low, high = drawn_line(time, value - half), drawn_line(time, value + half)
    ax.fill_between(low[0], low[1], np.interp(low[0], *high), color=BAND, linewidth=0, zorder=1)
    ax.plot(*drawn_line(time, value), **SMOOTHED, zorder=3)
    if truth is not None:
        ax.plot(*drawn_line(time, truth), **TRUTH, zorder=4)

"""Stability chart: where the loop lies among all gains, and how much delay each gain bears."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from flycontrol.delay.chart import StabilityChart
from flycontrol.delay.margins import Margins
from flycontrol.delay.system import FloatArray
from flycontrol.model.gain_plane import DelaySlice, GainPlane
from flycontrol.report.style import INK, MARK, STRENGTHS, in_house_style, new_figure
from flycontrol.units import ms

MODULUS_LEVELS = (0.3, 0.5, 0.7)  #: modulus margins that are drawn as lines
_SHADES = LinearSegmentedColormap.from_list("decay", ["#ffffff", *STRENGTHS[:4]])
_UNSTABLE = "#cdc8c1"  # darker than elsewhere: apart from the lightest shade in greyscale too
_STABLE = "#eaf4fa"
_DASHES = ("dotted", "dashed", "solid")
_FLY: dict[str, Any] = {
    "marker": "s",
    "linestyle": "none",
    "color": INK,
    "markeredgecolor": "white",
    "markersize": 7,
    "zorder": 5,
}
_FASTEST: dict[str, Any] = {
    "marker": "*", "linestyle": "none", "color": "white", "markeredgecolor": INK, "markersize": 11, "zorder": 5,
}  # fmt: skip


@in_house_style()
def gain_chart(plane: GainPlane, slice_: DelaySlice | None, margins: Margins | None, delay: float) -> Figure:
    """Left the plane of the gains at this delay, right a common gain factor against the delay [ms].

    Parameters
    ----------
    plane
        Regions, decay rate, modulus margin, D-curve, fastest decay.
    slice_
        Largest stable delay over the gain factor; None leaves the right panel out.
    margins
        Of this loop, drawn as arrows on the right; None for an unstable loop.
    delay
        Of this loop [s].
    """
    figure = new_figure(4.6)
    if slice_ is None:
        _draw_plane(figure, figure.subplots(), plane)
    else:
        left, right = figure.subplots(1, 2, width_ratios=[1.5, 1])
        _draw_plane(figure, left, plane)
        _draw_slice(right, slice_, margins, delay)
    figure.legend(handles=_legend(), loc="outside upper left", ncols=5, borderaxespad=0, columnspacing=1.4)
    return figure


def _legend() -> list[Line2D]:
    lines = [
        Line2D([], [], color=MARK, linewidth=1.1, linestyle=style, label=f"modulus margin {level:g}")
        for level, style in zip(MODULUS_LEVELS, _DASHES, strict=True)
    ]
    return [Line2D([], [], **_FLY, label="this fly"), Line2D([], [], **_FASTEST, label="fastest decay"), *lines]


def _draw_plane(figure: Figure, ax: Axes, plane: GainPlane) -> None:
    kp, kd, rate = plane.chart.x.values, plane.chart.y.values, plane.chart.decay_rate
    assert rate is not None
    ax.set_facecolor(_UNSTABLE)
    levels = _round_levels(plane.fastest_rate)
    shades = ax.contourf(kp, kd, rate, levels, cmap=_SHADES)
    lines = ax.contour(
        kp, kd, plane.distance, MODULUS_LEVELS, colors=MARK, linewidths=1.1, linestyles=[*_DASHES]
    )  # fmt: skip
    stable = ax.fill(plane.edge.kp, plane.edge.kd, facecolor="none", edgecolor="none")[0]
    for drawn in (shades, lines):
        drawn.set_clip_path(stable)
    ax.plot(plane.boundary.kp, plane.boundary.kd, color=INK, linewidth=1.6)
    ax.axvline(0, color=INK, linewidth=1.6)
    ax.plot(*plane.fastest, **_FASTEST)
    ax.set_xlim(kp[0], kp[-1])
    ax.set_ylim(kd[0], kd[-1])
    _mark_fly(ax, plane)
    _write_counts(ax, plane.chart, 1.0, [plane.own, plane.fastest], _on_lines(plane.distance))
    ax.set_xlabel("proportional gain over inertia [1/s²]")
    ax.set_ylabel("derivative gain over inertia [1/s]")
    bar = figure.colorbar(shades, ax=ax, orientation="horizontal", pad=0.02, aspect=40)
    bar.set_label("decay rate of the slowest mode [1/s]")


def _round_levels(fastest: float) -> FloatArray:
    """Six to twelve rounded levels from 0 to just above the fastest decay rate."""
    size = 10.0 ** np.floor(np.log10(fastest))
    step = next(part * size for part in (0.1, 0.2, 0.5, 1.0) if fastest / (part * size) <= 12)
    return step * np.arange(np.ceil(fastest / step) + 1)


def _mark_fly(ax: Axes, plane: GainPlane) -> None:
    """The loop's own place, or an arrow at the edge towards it."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    place = min(max(plane.own[0], left), right), min(max(plane.own[1], low), high)
    ax.plot(*place, **_FLY, clip_on=False)
    if place != plane.own:
        words = f"outside, at {plane.own[0]:.3g} 1/s² and {plane.own[1]:.3g} 1/s".replace("-", "−")
        ax.set_title(f"this fly lies {words}", weight="normal", fontsize=8, color=INK)


def _draw_slice(ax: Axes, slice_: DelaySlice, margins: Margins | None, delay: float) -> None:
    x, y = slice_.chart.x.values, slice_.chart.y.values / ms
    ax.set_facecolor(_UNSTABLE)
    critical = slice_.largest_stable_delay / ms
    ax.fill_between(slice_.factor, 0, np.minimum(critical, 2 * y[-1]), color=_STABLE, linewidth=0)
    ax.plot(slice_.factor, critical, color=INK, linewidth=1.6)
    ax.plot(slice_.factor, slice_.next_crossing / ms, color=INK, linewidth=0.9)
    ax.set_xlim(0, x[-1])
    ax.set_ylim(0, y[-1])
    if margins is not None:
        _mark_margins(ax, margins, delay / ms)
    ax.plot(1.0, delay / ms, **_FLY)
    later = delay if margins is None else delay + 0.5 * min(margins.delay_margin, slice_.chart.y.values[-1])
    words = [(factor, delay) for factor in (0.7, 1.0, 1.7, 2.4)] + [(factor, later) for factor in (0.4, 0.7, 1.0)]
    _write_counts(ax, slice_.chart, 1 / ms, words)
    ax.set_xlabel("factor on both gains [1]")
    ax.set_ylabel("delay [ms]")


def shows_second_pair(slice_: DelaySlice) -> bool:
    """Whether the line above which a second pair is unstable runs through the chart."""
    inside = slice_.factor <= slice_.chart.x.values[-1]
    return bool((slice_.next_crossing[inside] < slice_.chart.y.values[-1]).any())


def _mark_margins(ax: Axes, margins: Margins, delay: float) -> None:
    """Arrows from the fly to the boundary, to the right and upwards."""
    arrow = {"arrowstyle": "-|>", "color": MARK, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
    right, top = ax.get_xlim()[1], ax.get_ylim()[1]
    if margins.gain_margin < right:
        ax.annotate("", (margins.gain_margin, delay), xytext=(1.0, delay), arrowprops=arrow)
        ax.annotate(
            f"gain × {margins.gain_margin:.2f}", (1.0, delay), xytext=(6, -5), textcoords="offset points", color=MARK,
            va="top",
        )  # fmt: skip
    later = margins.delay_margin / ms
    if delay + later < top:
        ax.annotate("", (1.0, delay + later), xytext=(1.0, delay), arrowprops=arrow)
        ax.annotate(
            f"delay + {later:.1f} ms", (1.0, delay + 0.5 * later), xytext=(-3, 0), textcoords="offset points",
            color=MARK, ha="right", va="center", rotation=90,
        )  # fmt: skip


def _on_lines(distance: FloatArray) -> NDArray[np.bool_]:
    """Grid points with a line of equal modulus margin on the way to a neighbour."""
    crossed = np.zeros(distance.shape, dtype=np.bool_)
    for level in MODULUS_LEVELS:
        above = distance >= level
        rows, columns = above[1:] != above[:-1], above[:, 1:] != above[:, :-1]
        crossed[1:] |= rows
        crossed[:-1] |= rows
        crossed[:, 1:] |= columns
        crossed[:, :-1] |= columns
    return crossed


def _write_counts(
    ax: Axes,
    chart: StabilityChart,
    scale: float,
    marks: list[tuple[float, float]],
    taken: NDArray[np.bool_] | None = None,
) -> None:
    """The number of unstable roots in each region, where it has most room beside marks and points that are taken."""
    x, y = chart.x.values, chart.y.values
    for count in np.unique(chart.unstable_roots[chart.unstable_roots >= 0]):
        within = chart.unstable_roots == count
        free = np.pad(within if taken is None else within & ~taken, 1)
        for mark in marks:
            free[1 + int(np.argmin(np.abs(y - mark[1]))), 1 + int(np.argmin(np.abs(x - mark[0])))] = False
        room = np.asarray(distance_transform_edt(free))[1:-1, 1:-1]
        i, j = np.unravel_index(int(np.argmax(room)), room.shape)
        if room[i, j] >= 2:
            ax.text(x[j], scale * y[i], f"{count}", ha="center", va="center", weight="bold")

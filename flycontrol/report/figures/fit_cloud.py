"""The fly's cloud: gains from data drawn anew, over the stability chart of the fitted damping and delay."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flycontrol.model.gain_plane import GainPlane
from flycontrol.report.style import EXACT, FORBIDDEN, INK, MARK, in_house_style, new_figure

FloatArray = NDArray[np.float64]
_STABLE = "#c5dcec"


@in_house_style()
def gain_cloud(plane: GainPlane, draws: FloatArray, ellipse: FloatArray | None) -> Figure:
    """Left all gains, right the surroundings of the fly.

    Parameters
    ----------
    plane
        Stability boundary at the fitted damping and delay.
    draws
        Proportional gain [1/s^2] and derivative gain [1/s] of each fit to data drawn anew, shape (b, 2); may be empty.
    ellipse
        Edge of the confidence region by the covariance, shape (m, 2); None leaves it out.
    """
    figure = new_figure(3.3)
    left, right = figure.subplots(1, 2)
    for ax in (left, right):
        ax.set_facecolor(FORBIDDEN)
        ax.fill(plane.edge.kp, plane.edge.kd, color=_STABLE, linewidth=0)
        ax.plot(plane.boundary.kp, plane.boundary.kd, color=INK, linewidth=1.6)
        ax.axvline(0, color=INK, linewidth=1.6)
        ax.plot(draws[:, 0], draws[:, 1], ".", color=EXACT, markersize=2.5, markeredgewidth=0, alpha=0.5)
        if ellipse is not None:
            ax.plot(ellipse[:, 0], ellipse[:, 1], color=MARK, linewidth=1.3)
        ax.plot(*plane.own, "s", color=INK, markeredgecolor="white", markersize=6)
        ax.set_xlabel("proportional gain over inertia [1/s²]")
    left.set_xlim(*plane.chart.x.values[[0, -1]])
    left.set_ylim(*plane.chart.y.values[[0, -1]])
    left.set_ylabel("derivative gain over inertia [1/s]")
    left.set_title("among all gains")
    right.set_title("the fly's surroundings")
    _zoom(right, [draws, *([] if ellipse is None else [ellipse])], plane.own)
    return figure


def _zoom(ax: Axes, shown: list[FloatArray], own: tuple[float, float]) -> None:
    """Limits that leave a fifth of their extent around everything shown."""
    points = np.vstack([np.array([own]), *shown])
    low, high = points.min(axis=0), points.max(axis=0)
    room = np.maximum(0.2 * (high - low), 1e-3 * np.abs(points[0]) + 1e-9)
    ax.set_xlim(low[0] - room[0], high[0] + room[0])
    ax.set_ylim(low[1] - room[1], high[1] + room[1])

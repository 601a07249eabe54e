"""Where data cannot tell two unknowns apart: the least deviance over both."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from flycontrol.identify.gains.ridge import Ridge
from flycontrol.report.figures.fit_profiles import axis_label
from flycontrol.report.fit.words import KINDS
from flycontrol.report.style import INK, MARK, in_house_style, new_figure

_LEVELS = (0.0, 1.0, 2.0, 4.0, 8.0, 16.0)  #: of the deviance, in units of the threshold
_SHADES = ("#1c5c98", "#69add5", "#b5d6ea", "#dfecf4", "#f1f5f8", "#ffffff")


@in_house_style()
def deviance_ridge(ridge: Ridge) -> Figure:
    """Left the deviance over both unknowns, right the least of it along the first."""
    figure = new_figure(3.2)
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
    one, other = ridge.names
    x, y = ridge.first / KINDS[one][3], ridge.second / KINDS[other][3]
    z = np.where(np.isfinite(ridge.deviance), ridge.deviance, np.inf) / ridge.threshold
    _map(figure, left, x, y, np.minimum(z, 2 * _LEVELS[-1]))
    valley = ridge.valley / np.array([KINDS[one][3], KINDS[other][3]])
    left.plot(valley[:, 0], valley[:, 1], ".", color=INK, markersize=4)
    left.plot(
        ridge.estimate[0] / KINDS[one][3], ridge.estimate[1] / KINDS[other][3], "s", color=MARK,
        markeredgecolor="white", markersize=6,
    )  # fmt: skip
    left.set_xlabel(axis_label(one))
    left.set_ylabel(axis_label(other))
    right.plot(x, z.min(axis=1), "o-", color=_SHADES[0], markersize=3, linewidth=1.4)
    right.axhline(1.0, color=INK, linewidth=1.2)
    right.set_ylim(0, 4)
    right.set_xlabel(axis_label(one))
    right.set_ylabel("least deviance / threshold [1]")
    return figure


def _map(figure: Figure, ax: Axes, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> None:
    colours = ListedColormap(_SHADES)
    shading = ax.pcolormesh(
        x, y, z.T, cmap=colours, norm=BoundaryNorm([*_LEVELS, 2 * _LEVELS[-1]], len(_SHADES)), shading="nearest"
    )
    if z.min() < 1 < z.max():
        ax.contour(x, y, z.T, levels=[1.0], colors=INK, linewidths=1.2)
    bar = figure.colorbar(shading, ax=ax, ticks=_LEVELS)
    bar.set_label("deviance / threshold [1]")

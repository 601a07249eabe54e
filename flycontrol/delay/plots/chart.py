"""Stability charts and the curves that bound their regions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.spatial

from flycontrol.delay.chart import Axis, StabilityChart
from flycontrol.delay.dcurve import DCurve
from flycontrol.delay.plots.comparison import listed
from flycontrol.delay.plots.regions import UNKNOWN, Regions, regions_of
from flycontrol.delay.plots.style import APPROXIMATE, DASHES, INK, QUIET, legend, panel, tell
from flycontrol.delay.system import FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_NAMES = {"decay_rate": "decay rate [1/s]", "modulus_margin": "modulus margin min |1 + L| [1]"}
_LEVELS = 12
_VEILED = (0.93, 0.88, 0.84, 1.0)  # of regions whose roots are not known
_ROOM = 0.03  # of a region around its number, in units of the picture; else it is written beside


def stability_chart_plot(
    data: StabilityChart,
    quantity: str | None = None,
    *,
    ax: Axes | None = None,
    approximation: StabilityChart | None = None,
    title: str | None = None,
) -> Axes:
    """Regions by their number of unstable roots, a quantity where the loop is stable, and the D-curves on top.

    With the chart's "boundary" the regions end on the D-curves; without, each grid point stands for its surroundings.
    A question mark stands in a region too narrow for the grid.

    Parameters
    ----------
    quantity
        "decay_rate", "modulus_margin" or "unstable_roots"; when left out, the first of these that the chart has.
    approximation
        Another chart over the same plane, whose boundary is drawn dashed.

    Raises
    ------
    InvalidParameterError
        If the chart is a slice, or does not have the quantity.
    """
    x, y = data.x.values, data.y.values
    if min(len(x), len(y)) < 2:
        raise InvalidParameterError(
            "A chart with one value on an axis is a slice and no picture of a plane: plot its quantities against the "
            "other axis."
        )
    shown = _values(data, quantity)
    ax = panel(ax)
    found = regions_of(data)
    if shown is not None:
        _filled(ax, data, *shown)
    _regions(ax, data, found)
    _boundary(ax, data, {"color": INK, "linewidth": 1.6}, "exact" if approximation else "")
    if approximation is not None:
        _boundary(ax, approximation, {"color": APPROXIMATE, "linewidth": 1.6, "linestyle": DASHES}, "approximation")
    ax.set_xlim(x[0], x[-1])
    ax.set_ylim(y[0], y[-1])
    _numbers(ax, found)
    ax.set_xlabel(_axis_name(data.x))
    ax.set_ylabel(_axis_name(data.y))
    legend(ax, loc="best")
    tell(ax, title)
    return ax


def d_curve_plot(
    data: DCurve | Sequence[DCurve], *, ax: Axes | None = None, label: str | None = None, **line: Any
) -> Axes:
    """Stability boundaries in the plane of two parameters; a root at the origin dotted, a pair on the axis solid.

    Parameters
    ----------
    data
        One curve or several.
    label
        Of the first curve.
    **line
        Of matplotlib's lines, such as `color`.
    """
    curves = listed(data)
    for curve in curves:
        if not isinstance(curve, DCurve):
            raise InvalidParameterError(f"A stability boundary is drawn from DCurves, got {type(curve).__name__}.")
    ax = panel(ax)
    for k, curve in enumerate(curves):
        style: dict[str, Any] = {"color": INK, "linewidth": 1.6, "linestyle": (0, (1, 1)) if curve.static else "-"}
        ax.plot(curve.x, curve.y, **(style | line), label=label if k == 0 else None)
    if not ax.get_xlabel():
        ax.set_xlabel("first parameter")
        ax.set_ylabel("second parameter")
    return ax


def _axis_name(axis: Axis) -> str:
    return f"{axis.name} [{axis.unit or '1'}]"


def _values(chart: StabilityChart, quantity: str | None) -> tuple[FloatArray, str] | None:
    """Quantity to fill the stable region with, and its name; None for the regions alone."""
    wanted = quantity or next((name for name in _NAMES if getattr(chart, name) is not None), "unstable_roots")
    if wanted == "unstable_roots":
        return None
    values = getattr(chart, wanted, None) if wanted in _NAMES else None
    if values is None:
        has = [name for name in _NAMES if getattr(chart, name) is not None]
        raise InvalidParameterError(
            f"This chart has no {wanted!r} to draw, only {', '.join([*has, 'unstable_roots'])}; ask "
            "stability_chart for it."
        )
    return values, _NAMES[wanted]


def _regions(ax: Axes, chart: StabilityChart, found: Regions) -> None:
    """Unstable the greyer the more roots, over whatever contours reach there; stable left as it is."""
    from matplotlib import colormaps

    many = found.unstable_roots
    picture = np.asarray(colormaps["Greys"](0.22 + 0.05 * np.clip(many, 0, 8)))
    picture[many == UNKNOWN] = _VEILED
    picture[..., 3] = many != 0
    x, y = chart.x.values, chart.y.values
    ax.imshow(
        picture, origin="lower", extent=(x[0], x[-1], y[0], y[-1]), aspect="auto", interpolation="nearest", zorder=1.5
    )


def _filled(ax: Axes, chart: StabilityChart, values: FloatArray, name: str) -> None:
    """Contours of a quantity over the stable region, darker where there is more of it."""
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm
    from matplotlib.ticker import MaxNLocator

    stable = np.where(chart.stable, values, np.nan)
    highest = float(stable.max(where=np.isfinite(stable), initial=0.0))
    if not highest > 0:
        return
    levels = MaxNLocator(_LEVELS).tick_values(0.0, highest)
    style: dict[str, Any] = {"cmap": "YlGnBu", "zorder": 1, "norm": BoundaryNorm(levels, colormaps["YlGnBu"].N)}
    points, heights = _known(chart, values, name)
    if chart.boundary and np.linalg.matrix_rank(points - points[0], 1e-9) == 2:
        filled = ax.tricontourf(_triangulated(chart, points), heights, levels, **style)
    else:
        filled = ax.pcolormesh(chart.x.values, chart.y.values, np.minimum(stable, highest), shading="nearest", **style)
    ax.figure.colorbar(filled, ax=ax, label=name)


def _triangulated(chart: StabilityChart, points: FloatArray) -> Any:
    """Delaunay's triangles between points in units of the box."""
    from matplotlib.tri import Triangulation

    x, y = (
        axis.values[0] + share * (axis.values[-1] - axis.values[0])
        for axis, share in zip((chart.x, chart.y), points.T, strict=True)
    )
    return Triangulation(x, y, scipy.spatial.Delaunay(points).simplices)


def _known(chart: StabilityChart, values: FloatArray, name: str) -> tuple[FloatArray, FloatArray]:
    """Points in units of the box, shape (k, 2), and what the quantity is there: stable grid points and the curves.

    On a curve the decay rate is 0. So is the modulus margin where a pair of roots passes; where a real root passes the
    origin of a loop with an integrator it is not, and has the value of the nearest stable grid point.
    """
    x, y = chart.x.values, chart.y.values
    i, j = np.nonzero(chart.stable & np.isfinite(values))
    low, size = np.array([x[0], y[0]]), np.array([x[-1] - x[0], y[-1] - y[0]])
    points, heights = [(np.column_stack([x[j], y[i]]) - low) / size], [values[i, j]]
    if len(i):
        nearest = scipy.spatial.KDTree(points[0])
        for curve in chart.boundary or ():
            on = (np.column_stack([curve.x, curve.y]) - low) / size
            beside = values[i, j][nearest.query(on)[1]]
            points.append(on)
            heights.append(beside if curve.static and name != _NAMES["decay_rate"] else np.zeros(len(on)))
    return np.concatenate(points), np.concatenate(heights)


def _numbers(ax: Axes, found: Regions) -> None:
    """The number of unstable roots in the middle of every region, or beside one that is too narrow for it."""
    box = {"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": QUIET, "alpha": 0.85}
    middle = np.mean(ax.get_xlim()), np.mean(ax.get_ylim())
    for region in found.regions:
        inwards = (24.0 if region.x < middle[0] else -24.0, 24.0 if region.y < middle[1] else -24.0)
        away = (0.0, 0.0) if region.room >= _ROOM else inwards
        words = "?" if region.unstable_roots == UNKNOWN else str(region.unstable_roots)
        leader = None if region.room >= _ROOM else {"arrowstyle": "-", "color": INK, "linewidth": 0.8}
        ax.annotate(
            words, (region.x, region.y), xytext=away, textcoords="offset points", ha="center", va="center", color=INK,
            zorder=3, bbox=box, arrowprops=leader,
        )  # fmt: skip


def _boundary(ax: Axes, chart: StabilityChart, line: dict[str, Any], label: str) -> None:
    if chart.boundary:
        ax.set_xlabel(_axis_name(chart.x))  # so that d_curve_plot leaves the names alone
        d_curve_plot(chart.boundary, ax=ax, label=label or None, **{**line, "linestyle": line.get("linestyle", "-")})
    elif label == "approximation":
        stable = chart.stable.astype(np.float64)
        ax.contour(
            chart.x.values,
            chart.y.values,
            stable,
            [0.5],
            colors=line["color"],
            linestyles=[line["linestyle"]],
            zorder=2,
        )
        ax.plot([], [], **line, label=label)

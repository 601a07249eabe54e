"""Stability charts and the curves that bound their regions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.ndimage

from flycontrol.delay.chart import Axis, StabilityChart
from flycontrol.delay.dcurve import DCurve
from flycontrol.delay.plots.comparison import listed
from flycontrol.delay.plots.style import APPROXIMATE, DASHES, INK, QUIET, legend, panel, tell
from flycontrol.delay.system import FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_NAMES = {"decay_rate": "decay rate [1/s]", "modulus_margin": "modulus margin min |1 + L| [1]"}
_LEVELS = 12
_LEAST_REGION = 0.004  # of the chart, for its number to be written


def stability_chart_plot(
    data: StabilityChart,
    quantity: str | None = None,
    *,
    ax: Axes | None = None,
    approximation: StabilityChart | None = None,
    title: str | None = None,
) -> Axes:
    """Regions by their number of unstable roots, a quantity where the loop is stable, and the D-curves on top.

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
    _regions(ax, data, none_white=shown is not None and shown[1] == _NAMES["decay_rate"])
    if shown is not None:
        _filled(ax, data, *shown)
    _numbers(ax, data)
    _boundary(ax, data, {"color": INK, "linewidth": 1.6}, "exact" if approximation else "")
    if approximation is not None:
        _boundary(ax, approximation, {"color": APPROXIMATE, "linewidth": 1.6, "linestyle": DASHES}, "approximation")
    ax.set_xlim(x[0], x[-1])
    ax.set_ylim(y[0], y[-1])
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


def _regions(ax: Axes, chart: StabilityChart, *, none_white: bool) -> None:
    """Stable white, unstable the greyer the more roots; none white where contours reach across the boundary."""
    unknown = chart.unstable_roots < 0  # a root on the axis: as beside it
    nearest: Any = scipy.ndimage.distance_transform_edt(unknown, return_distances=False, return_indices=True)
    many = np.clip(chart.unstable_roots[tuple(nearest)], 1 if none_white else 0, 8)
    ax.pcolormesh(chart.x.values, chart.y.values, many, cmap="Greys", vmin=0.0, vmax=16.0, shading="nearest", zorder=0)


def _filled(ax: Axes, chart: StabilityChart, values: FloatArray, name: str) -> None:
    """Contours of a quantity over the stable region, darker where there is more of it."""
    from matplotlib.ticker import MaxNLocator

    stable = np.where(chart.stable, values, np.nan)
    if not np.isfinite(stable).any():
        return
    # a decay rate goes through zero at the boundary: contours from its values on both sides end there, on the curve
    drawn = values if name == _NAMES["decay_rate"] else stable
    highest = float(np.nanmax(stable))
    if highest <= 0:
        return
    levels = MaxNLocator(_LEVELS).tick_values(0.0, highest)
    filled = ax.contourf(chart.x.values, chart.y.values, np.ma.masked_invalid(drawn), levels, cmap="YlGnBu", zorder=1)
    ax.figure.colorbar(filled, ax=ax, label=name)


def _numbers(ax: Axes, chart: StabilityChart) -> None:
    """The number of unstable roots, in the middle of every region."""
    for many in np.unique(chart.unstable_roots[chart.unstable_roots >= 0]):
        label: Any = scipy.ndimage.label(chart.unstable_roots == many)
        for k in range(1, label[1] + 1):
            region = label[0] == k
            if region.mean() < _LEAST_REGION:
                continue
            depth: Any = scipy.ndimage.distance_transform_edt(np.pad(region, 1))
            if depth.max() < 2:
                continue
            i, j = np.unravel_index(int(depth[1:-1, 1:-1].argmax()), region.shape)
            ax.text(
                chart.x.values[j], chart.y.values[i], str(many), ha="center", va="center", color=INK, zorder=3,
                bbox={"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": QUIET, "alpha": 0.85},
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

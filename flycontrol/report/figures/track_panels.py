"""What all figures of a tracked flight share: time in ms, spans that were not seen, how lines and parts look."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from flycontrol.report.style import EXACT, FORBIDDEN, INK, MARK, PADE, PULSE
from flycontrol.report.track.spans import Span

FloatArray = NDArray[np.float64]

PART_LINES: dict[str, dict[str, Any]] = {
    "body": {"color": INK, "linewidth": 1.0, "linestyle": (0, (1, 1))},
    "left": {"color": "#1c5c98", "linewidth": 1.2, "linestyle": "solid"},
    "right": {"color": "#b46a00", "linewidth": 1.4, "linestyle": (0, (3.5, 1.5))},
}
#: One for each view, or pair of views.
SERIES: tuple[dict[str, Any], ...] = (
    {"color": EXACT, "linewidth": 1.3, "linestyle": "solid"},
    {"color": PADE, "linewidth": 1.3, "linestyle": (0, (4, 2))},
    {"color": "#69add5", "linewidth": 1.3, "linestyle": (0, (4, 1.5, 1, 1.5))},
    {"color": MARK, "linewidth": 1.3, "linestyle": (0, (1, 1.2))},
)
SMOOTHED: dict[str, Any] = {"color": EXACT, "linewidth": 1.1}
TRUTH: dict[str, Any] = {"color": MARK, "linewidth": 1.1, "linestyle": (0, (3, 2))}
BAND = "#b9d2e3"  #: of 95 %
SHADES: dict[str, dict[str, Any]] = {
    "partial": {"facecolor": "#cddae3", "edgecolor": "none", "linewidth": 0},
    "bridged": {"facecolor": PULSE, "edgecolor": "none", "linewidth": 0},
    "lost": {"facecolor": FORBIDDEN, "edgecolor": "#c9c5c0", "linewidth": 0, "hatch": "////"},
}
_MOST = 1200  #: samples of a line that are drawn one by one


def frame_edges(time: FloatArray) -> FloatArray:
    """(N + 1,) between the frames, in the unit of the time."""
    if len(time) < 2:
        return np.array([time[0] - 0.5, time[0] + 0.5])
    middles = (time[1:] + time[:-1]) / 2
    return np.concatenate([[2 * time[0] - middles[0]], middles, [2 * time[-1] - middles[-1]]])


def shade(ax: Axes, time: FloatArray, spans: Sequence[Span]) -> None:
    """Colour the frames that are partial, bridged or lost behind a panel over time [ms]."""
    edges = frame_edges(time)
    for span in spans:
        if span.status != "tracked":
            ax.axvspan(edges[span.first], edges[span.last + 1], **SHADES[span.status], zorder=0)


def shade_keys(spans: Sequence[Span]) -> list[Patch]:
    """What the colours behind mean, for a legend."""
    present = [status for status in SHADES if any(span.status == status for span in spans)]
    return [Patch(label=status, **SHADES[status]) for status in present]


def limit_to(ax: Axes, time: FloatArray) -> None:
    """The panel ends with the frames; the time in ms."""
    edges = frame_edges(time)
    ax.set_xlim(edges[0], edges[-1])


def drawn_line(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """As it is, or where there are too many samples the least and the largest of each few of them."""
    if len(time) <= _MOST:
        return time, values
    bins = np.array_split(np.arange(len(time)), _MOST // 2)
    ends = np.array([_ends(values, rows) for rows in bins]).ravel()
    return time[ends], values[ends]


def drawn_points(count: int, most: int = 240) -> slice:
    """Every so manieth of many points."""
    return slice(None, None, max(1, -(-count // most)))


def leave_room_for_labels(figure: Figure) -> None:
    """Widen the margins a little: labels that are aligned across panels stand farther out than the layout expects."""
    figure.set_layout_engine("constrained", w_pad=0.11, h_pad=0.04)


def legend_on_top(figure: Figure, handles: Sequence[Any], columns: int = 6) -> None:
    """In rows above all panels."""
    figure.legend(handles=list(handles), loc="outside upper left", ncols=columns, borderaxespad=0)


def _ends(values: FloatArray, rows: NDArray[np.int_]) -> tuple[int, int]:
    """Where the least and the largest are, in order."""
    here = values[rows]
    if np.all(np.isnan(here)):
        return int(rows[0]), int(rows[-1])
    low, high = sorted((int(rows[np.nanargmin(here)]), int(rows[np.nanargmax(here)])))
    return low, high

"""What all figures of a simulated flight share: time in ms, wingbeats above, the pulses, and how terms are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.flight.pulses import BodyPulse
from flycontrol.report.style import GUIDE_LINE, INK, MARK, PADE, PULSE, new_figure, wingbeat_axis
from flycontrol.units import ms

TOTAL_LINE: dict[str, Any] = {"color": INK, "linewidth": 1.9, "label": "all"}
TERM_LINES: dict[str, dict[str, Any]] = {
    "translational": {"color": "#1c5c98", "linewidth": 1.3, "label": "translational"},
    "rotational": {"color": PADE, "linewidth": 1.3, "linestyle": (0, (4, 2)), "label": "rotational"},
    "added_mass": {"color": "#69add5", "linewidth": 1.3, "linestyle": (0, (4, 1.5, 1, 1.5)), "label": "added mass"},
    "dissipative": {"color": MARK, "linewidth": 1.3, "linestyle": (0, (1, 1.2)), "label": "dissipative"},
}


def panels_over_time(
    labels: Sequence[str], frequency: float, pulses: Sequence[BodyPulse], *, height: float
) -> tuple[Figure, list[Axes]]:
    """Panels over time in ms, one above the other, wingbeats along the top, pulses shaded."""
    figure = new_figure(height)
    panels: list[Axes] = list(np.atleast_1d(figure.subplots(len(labels), 1, sharex=True)))
    for ax, label in zip(panels, labels, strict=True):
        ax.set_ylabel(label)
        ax.axhline(0, **GUIDE_LINE)
        for pulse in pulses:
            ax.axvspan(pulse.start / ms, (pulse.start + pulse.duration) / ms, color=PULSE, linewidth=0, zorder=0)
    panels[-1].set_xlabel("time [ms]")
    wingbeat_axis(panels[0], frequency)
    return figure, panels


def span_of(panels: Sequence[Axes], times: np.ndarray) -> None:
    """Limit the panels to the times drawn [s]."""
    if len(times) > 1:
        panels[0].set_xlim(times[0] / ms, times[-1] / ms)


def legend_above(figure: Figure, ax: Axes, columns: int = 6) -> None:
    """The panel's lines, in a row above all panels."""
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper left", ncols=columns, borderaxespad=0)


def at_least(ax: Axes, span: float) -> None:
    """Keep rounding errors from filling a panel."""
    low, high = ax.get_ylim()
    if high - low < span:
        ax.set_ylim((low + high - span) / 2, (low + high + span) / 2)

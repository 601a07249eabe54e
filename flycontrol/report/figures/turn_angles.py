"""Turn by turn: measured turn angle against what the paddling predicts (after Fig. 5c)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from flycontrol.model.turn import PaddlingTurn
from flycontrol.report.style import EXACT, GUIDE_LINE, MARK, PADE, QUIET, in_house_style, new_figure
from flycontrol.units import deg


@in_house_style()
def turn_angles(turns: Sequence[PaddlingTurn]) -> Figure:
    """Measured turn angle [deg] against predicted [deg]: by Eq. 5, trimmed, and with the plant's gamma/beta."""
    figure = new_figure(4.2)
    ax = figure.subplots()
    measured = np.array([turn.angle for turn in turns]) / deg
    kinds = (
        ("ω ∫Δα dt, Eq. 5", [t.by_wing_speed for t in turns], {"marker": "o", "color": EXACT}),
        ("the same, median Δα as zero", [t.by_wing_speed_trimmed for t in turns], {"marker": "s", "color": PADE}),
        ("(γ/β) ∫Δα dt, identified", [t.by_plant for t in turns], {"marker": "D", "color": MARK, "fillstyle": "none"}),
    )
    everything = [measured]
    for label, predicted, look in kinds:
        angles = np.array(predicted) / deg
        if np.isfinite(angles).any():
            ax.plot(angles, measured, linestyle="none", markersize=6, label=label, **look)  # pyright: ignore[reportArgumentType]
            everything.append(angles[np.isfinite(angles)])
    span = np.concatenate(everything)
    low, high = float(min(span.min(), 0.0)) - 8, float(max(span.max(), 0.0)) + 8
    ax.plot([low, high], [low, high], color=QUIET, linewidth=0.9)
    ax.text(high, high, "measured = predicted ", ha="right", va="bottom", color=QUIET)
    ax.axhline(0, **GUIDE_LINE)
    ax.axvline(0, **GUIDE_LINE)
    for number, turn in enumerate(turns, start=1):
        ax.axhline(turn.angle / deg, color=QUIET, linewidth=0.3, zorder=0)
        at = (turn.by_wing_speed / deg, turn.angle / deg)
        ax.annotate(str(number), at, xytext=(0, 5), textcoords="offset points", ha="center", weight="bold")
    ax.set_aspect("equal")
    ax.set_xlim(low, high)
    ax.set_ylim(low, high)
    ax.set_xlabel("predicted turn [deg]")
    ax.set_ylabel("measured turn [deg]")
    ax.legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))
    return figure

"""Wingbeat phase averages of the three wing angles, left and right, with their spread."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.identify.flight import FlightAnalysis
from flycontrol.model.stroke import ANGLES
from flycontrol.model.wingbeats import PhaseAverage
from flycontrol.report.style import EXACT, EXACT_LINE, GUIDE_LINE, PADE, PADE_LINE, QUIET, in_house_style, new_figure
from flycontrol.units import deg


@in_house_style()
def wing_motion(analysis: FlightAnalysis) -> Figure:
    """Stroke, deviation and pitch [deg] over the phase of the wingbeat, mean and standard deviation of all beats."""
    figure = new_figure(2.9)
    panels = figure.subplots(1, 3)
    stroke = 0.5 * (analysis.left["stroke"].mean + analysis.right["stroke"].mean)
    turn = float(analysis.left["stroke"].phase[int(np.argmax(stroke))])
    for ax, angle in zip(panels, ANGLES, strict=True):
        _average(ax, analysis.left[angle], {**EXACT_LINE, "label": "left wing"}, EXACT)
        _average(ax, analysis.right[angle], {**PADE_LINE, "label": "right wing"}, PADE)
        ax.axvline(turn, **GUIDE_LINE)
        ax.set_xlim(0, 1)
        ax.set_xlabel("phase [wingbeats]")
        ax.set_ylabel(f"{angle} [deg]")
    low, high = panels[0].get_ylim()
    panels[0].set_ylim(low - 0.14 * (high - low), high)
    for words, where in (("forward", turn / 2), ("backward", (1 + turn) / 2)):
        panels[0].text(where, low - 0.05 * (high - low), words, ha="center", va="center", color=QUIET)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=2, borderaxespad=0)
    return figure


def _average(ax: Axes, average: PhaseAverage, line: dict[str, object], colour: str) -> None:
    low, high = (average.mean - average.spread) / deg, (average.mean + average.spread) / deg
    ax.fill_between(average.phase, low, high, color=colour, alpha=0.18, linewidth=0)
    ax.plot(average.phase, average.mean / deg, **line)  # pyright: ignore[reportArgumentType]

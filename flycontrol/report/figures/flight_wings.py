"""The wings within a few wingbeats: their angles, and the paths of their tips with the chord at instants."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flycontrol.flight.flight_record import Closely, FlightRecord
from flycontrol.model.stroke import Side, wing_axes
from flycontrol.report.figures.flight_panels import legend_above, panels_over_time, span_of
from flycontrol.report.style import EXACT, INK, PADE, QUIET, in_house_style, new_figure
from flycontrol.units import deg, mm, ms

_SIDES: tuple[Side, Side] = ("left", "right")
_LINES: dict[str, dict[str, Any]] = {
    "left": {"color": EXACT, "linewidth": 1.6, "label": "left wing"},
    "right": {"color": PADE, "linewidth": 1.6, "linestyle": (0, (4, 2)), "label": "right wing"},
}


@in_house_style()
def wing_angles_over_time(record: FlightRecord, closely: Closely) -> Figure:
    """Stroke, deviation and pitch of both wings [deg]."""
    planned, flight = record.planned, closely.flight
    labels = ("stroke [deg]", "deviation [deg]", "pitch [deg]")
    figure, panels = panels_over_time(labels, planned.frequency, planned.plan.pulses, height=4.6)
    for side in _SIDES:
        wing = flight.wing(side)
        for ax, angle in zip(panels, (wing.stroke, wing.deviation, wing.pitch), strict=True):
            ax.plot(flight.time / ms, angle / deg, **_LINES[side])
    low, high = panels[1].get_ylim()
    if high - low < 2:
        panels[1].set_ylim((low + high) / 2 - 1, (low + high) / 2 + 1)
    span_of(panels, flight.time)
    figure.align_ylabels(panels)
    legend_above(figure, panels[0])
    return figure


@in_house_style()
def wing_tip_paths(record: FlightRecord, closely: Closely) -> Figure:
    """Tips of both wings in the stroke-plane frame [mm], from the side and from above, chords as sticks."""
    figure = new_figure(3.3)
    left, right, above = figure.subplots(1, 3)
    for ax, side in zip((left, right), _SIDES, strict=True):
        _from_the_side(ax, record, closely, side)
        ax.set_title(f"{side} tip, from its side")
    reach = _reach(record)
    for side in _SIDES:
        tip, _ = _tip_and_chord(record, closely, side)
        above.plot(tip[:, 1], tip[:, 0], **_LINES[side])
        hinge = np.array(record.planned.experiment.morphology.right_hinge) / mm
        above.plot((1 if side == "right" else -1) * hinge[1], hinge[0], "o", color=INK, markersize=3.5)
    _frame(above, 1.15 * reach, 1.15 * reach, 0.0)
    above.set_title("from above")
    above.set_xlabel("to the right [mm]")
    above.set_ylabel("ahead [mm]")
    figure.legend(
        handles=[Line2D([], [], **_LINES[side]) for side in _SIDES]
        + [Line2D([], [], color=QUIET, linewidth=1, marker="o", markersize=3, label="chord, leading edge dotted")],
        loc="outside upper left", ncols=3, borderaxespad=0,
    )  # fmt: skip
    return figure


def _from_the_side(ax: Axes, record: FlightRecord, closely: Closely, side: Side) -> None:
    """One wingbeat: path of the tip, and the mean chord there at some instants; ahead is to the right."""
    per_beat = record.planned.settings.samples
    tip, chord = _tip_and_chord(record, closely, side)
    half = 0.5 * record.planned.experiment.morphology.mean_chord / mm * chord
    ax.plot(tip[: per_beat + 1, 0], -tip[: per_beat + 1, 2], **_LINES[side])
    for k in range(0, min(per_beat, len(tip)), max(1, per_beat // 16)):
        front, back = tip[k] + half[k], tip[k] - half[k]
        ax.plot([back[0], front[0]], [-back[2], -front[2]], color=QUIET, linewidth=0.9)
        ax.plot(front[0], -front[2], "o", color=QUIET, markersize=2.5)
    _frame(ax, 1.15 * _reach(record), 0.6 * _reach(record), -record.planned.experiment.morphology.right_hinge[2] / mm)
    ax.set_xlabel("ahead [mm]")
    ax.set_ylabel("up [mm]")


def _frame(ax: Axes, half_width: float, half_height: float, middle: float) -> None:
    """The same scale along both axes."""
    ax.set_xlim(-half_width, half_width)
    ax.set_ylim(middle - half_height, middle + half_height)
    ax.set_aspect("equal", adjustable="box")


def _reach(record: FlightRecord) -> float:
    """From the plane of symmetry to a tip that points sideways [mm]."""
    morphology = record.planned.experiment.morphology
    return (morphology.wing_length + abs(morphology.right_hinge[1])) / mm


def _tip_and_chord(record: FlightRecord, closely: Closely, side: Side) -> tuple[np.ndarray, np.ndarray]:
    """Tip (N, 3) [mm] and the chord's direction (N, 3), frame S."""
    morphology = record.planned.experiment.morphology
    axes = wing_axes(closely.flight.wing(side), side)
    hinge = np.array(morphology.right_hinge) * (1.0, 1.0 if side == "right" else -1.0, 1.0)
    return (hinge + morphology.wing_length * axes.span) / mm, axes.chord

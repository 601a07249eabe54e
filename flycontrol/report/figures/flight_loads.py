"""Forces and torques of the air on both wings within a few wingbeats, term by term."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flycontrol.flight.flight_record import Closely, FlightRecord
from flycontrol.flight.quasi_steady import TERMS
from flycontrol.report.figures.flight_panels import (
    TERM_LINES,
    TOTAL_LINE,
    at_least,
    legend_above,
    panels_over_time,
    span_of,
)
from flycontrol.report.style import in_house_style
from flycontrol.units import ms, nN_m

FloatArray = NDArray[np.float64]


@in_house_style()
def force_terms(record: FlightRecord, closely: Closely) -> Figure:
    """Upward, forward and sideways force in the stroke-plane frame, over the weight."""
    weight = record.planned.experiment.morphology.weight
    labels = ("upward [weights]", "forward [weights]", "to the right [weights]")
    turn = np.array([[0, 0, -1], [1, 0, 0], [0, 1, 0]]) / weight
    return _terms(record, closely, "force", labels, turn)


@in_house_style()
def torque_terms(record: FlightRecord, closely: Closely) -> Figure:
    """Roll, pitch and yaw torque about the body's centre of mass [nN m]."""
    return _terms(record, closely, "torque", ("roll [nN m]", "pitch [nN m]", "yaw [nN m]"), np.eye(3) / nN_m)


def _terms(record: FlightRecord, closely: Closely, what: str, labels: tuple[str, ...], turn: FloatArray) -> Figure:
    planned = record.planned
    figure, panels = panels_over_time(labels, planned.frequency, planned.plan.pulses, height=5.6)
    time = closely.flight.time / ms
    shown = [term for term in TERMS if term in planned.plan.fly.air.terms]
    loads = {
        term: sum(getattr(getattr(closely.loads, side).terms[term], what) for side in ("left", "right")) @ turn.T
        for term in shown
    }
    for k, ax in enumerate(panels):
        ax.plot(time, getattr(closely.loads.total, what) @ turn[k], **TOTAL_LINE)
        for term, load in loads.items():
            ax.plot(time, load[:, k], **TERM_LINES[term])
        at_least(ax, 0.02)
    span_of(panels, closely.flight.time)
    figure.align_ylabels(panels)
    legend_above(figure, panels[0])
    return figure

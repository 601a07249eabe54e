"""Forces and torques of the whole flight, averaged wingbeat by wingbeat."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from flycontrol.flight.flight_record import FlightRecord
from flycontrol.flight.quasi_steady import TERMS
from flycontrol.report.figures.flight_panels import (
    TERM_LINES,
    TOTAL_LINE,
    at_least,
    legend_above,
    panels_over_time,
)
from flycontrol.report.style import GUIDE_LINE, in_house_style
from flycontrol.units import ms, nN_m


@in_house_style()
def wingbeat_mean_loads(record: FlightRecord) -> Figure:
    """Vertical force over the weight, term by term, and roll, pitch and yaw torque [nN m]."""
    planned, beats = record.planned, record.beats
    labels = ("upward in the\nworld [weights]", "roll [nN m]", "pitch [nN m]", "yaw [nN m]")
    figure, panels = panels_over_time(labels, planned.frequency, planned.plan.pulses, height=6.4)
    time = beats.phase / planned.frequency / ms
    dots: dict[str, Any] = {"marker": "o", "markersize": 2.5} if len(time) <= 100 else {}
    lift = beats.lift / planned.experiment.morphology.weight
    panels[0].axhline(1, **GUIDE_LINE)
    panels[0].plot(time, lift.sum(axis=1), **TOTAL_LINE, **dots)
    for k, term in enumerate(TERMS):
        if term in planned.plan.fly.air.terms:
            panels[0].plot(time, lift[:, k], **TERM_LINES[term])
    for axis, ax in enumerate(panels[1:]):
        ax.plot(time, beats.torque_S.sum(axis=1)[:, axis] / nN_m, **TOTAL_LINE, **dots)
        at_least(ax, 0.05)
    panels[0].set_xlim(0, record.wingbeats / planned.frequency / ms)
    figure.align_ylabels(panels)
    legend_above(figure, panels[0])
    return figure

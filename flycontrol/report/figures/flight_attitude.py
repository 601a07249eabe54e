"""Attitude and rates of the body over the flight."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flycontrol.flight.flight_record import FlightRecord
from flycontrol.flight.heading import nose_heading
from flycontrol.report.figures.flight_panels import at_least, legend_above, panels_over_time, span_of
from flycontrol.report.style import EXACT, MARK, PADE, in_house_style
from flycontrol.units import deg, ms, nN_m

_LINES: tuple[dict[str, Any], ...] = (
    {"color": EXACT, "linewidth": 1.6, "label": "heading, to the right"},
    {"color": PADE, "linewidth": 1.6, "linestyle": (0, (4, 2)), "label": "nose up"},
    {"color": MARK, "linewidth": 1.6, "linestyle": (0, (1, 1.2)), "label": "roll, right side down"},
)


@in_house_style()
def body_attitude(record: FlightRecord) -> Figure:
    """Heading, nose-up angle and roll of the stroke plane [deg], and the rates about its axes [rad/s]."""
    planned, body = record.planned, record.body
    labels = ("angle [deg]", "rate about own\naxes [rad/s]")
    figure, panels = panels_over_time(labels, planned.frequency, planned.plan.pulses, height=4.4)
    for angle, rate, line in zip(
        (body.yaw, body.nose_up, body.roll), body.angular_velocity_S.T[[2, 1, 0]], _LINES, strict=True
    ):
        panels[0].plot(body.time / ms, angle / deg, **line)
        panels[1].plot(body.time / ms, rate, **line)
    for ax in panels:
        at_least(ax, 0.5)
    span_of(panels, body.time)
    figure.align_ylabels(panels)
    legend_above(figure, panels[0])
    return figure


@in_house_style()
def yaw_response(record: FlightRecord) -> Figure:
    """Torque of the pulses, heading and yaw rate: what is applied and what comes of it."""
    planned, body, beats = record.planned, record.body, record.beats
    labels = ("yaw torque from\noutside [nN m]", "heading [deg]", "yaw rate [rad/s]")
    figure, panels = panels_over_time(labels, planned.frequency, planned.plan.pulses, height=5.2)
    edges = [0.0]
    torque = [0.0]
    for pulse in sorted(planned.plan.pulses, key=lambda pulse: pulse.start):
        edges += [pulse.start, pulse.start, pulse.start + pulse.duration, pulse.start + pulse.duration]
        torque += [0.0, pulse.torque_S[2], pulse.torque_S[2], 0.0]
    end = planned.experiment.wingbeats / planned.frequency
    panels[0].plot(np.array([*edges, end]) / ms, np.array([*torque, 0.0]) / nN_m, color=EXACT, linewidth=1.6)
    panels[1].plot(body.time / ms, body.yaw / deg, color=EXACT, linewidth=1.6, label="stroke plane")
    nose = nose_heading(body.q_WS, planned.experiment.morphology.stroke_plane_angle)
    panels[1].plot(body.time / ms, nose / deg, color=PADE, linewidth=1.4, linestyle=(0, (4, 2)), label="nose")
    panels[1].legend(loc="upper left", ncols=2)
    panels[2].plot(
        body.time / ms, body.angular_velocity_S[:, 2], color="#69add5", linewidth=0.9, label="within wingbeats"
    )
    middle = beats.phase / planned.frequency / ms
    panels[2].plot(
        middle, beats.angular_velocity_S[:, 2], color=EXACT, linewidth=1.2, marker="o", markersize=2.5,
        label="mean of each wingbeat",
    )  # fmt: skip
    for ax in panels[1:]:
        at_least(ax, 0.5)
    panels[2].legend(loc="upper right", ncols=2)
    span_of(panels, body.time)
    figure.align_ylabels(panels)
    return figure

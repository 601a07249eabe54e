"""Mechanical power at the wing hinges within a few wingbeats, and its mean over each wingbeat of the flight."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from flycontrol.flight.flight_record import Closely, FlightRecord
from flycontrol.report.style import EXACT, GUIDE_LINE, PULSE, in_house_style, new_figure, wingbeat_axis
from flycontrol.units import ms

_MICRO = 1e-6


@in_house_style()
def hinge_power(record: FlightRecord, closely: Closely) -> Figure:
    """Power of both hinges [uW], closely and wingbeat by wingbeat."""
    planned, beats = record.planned, record.beats
    figure = new_figure(2.8)
    near, means = figure.subplots(1, 2, sharey=False)
    for ax in (near, means):
        ax.axhline(0, **GUIDE_LINE)
        for pulse in planned.plan.pulses:
            ax.axvspan(pulse.start / ms, (pulse.start + pulse.duration) / ms, color=PULSE, linewidth=0, zorder=0)
        ax.set_xlabel("time [ms]")
        wingbeat_axis(ax, planned.frequency)
    near.plot(closely.flight.time / ms, closely.power / _MICRO, color=EXACT, linewidth=1.4)
    near.set_ylabel("power at the hinges [µW]")
    middle = beats.phase / planned.frequency / ms
    means.plot(
        middle, beats.power / _MICRO, color=EXACT, linewidth=1.4, marker="o" if len(middle) <= 100 else "", markersize=3
    )
    means.set_ylim(bottom=min(0.0, 1.1 * float(np.min(beats.power, initial=0)) / _MICRO))
    means.set_ylabel("mean of each wingbeat [µW]")
    near.set_xlim(closely.flight.time[0] / ms, closely.flight.time[-1] / ms)
    return figure

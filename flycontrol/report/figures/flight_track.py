"""Where the body went: seen from above, from the side, and over time."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.flight.flight_record import FlightRecord
from flycontrol.report.style import EXACT, GUIDE_LINE, INK, MARK, PADE, PULSE, in_house_style, new_figure
from flycontrol.units import mm, ms

_LEAST = 0.5  #: side of a panel [mm]


@in_house_style()
def body_track(record: FlightRecord) -> Figure:
    """Position of the centre of mass in the world [mm]: from above, from the right, and over time."""
    body = record.body
    x, y, z = body.position_W.T / mm
    figure = new_figure(3.1)
    above, side, over_time = figure.subplots(1, 3, width_ratios=[1, 1, 1.25])
    _path(above, x, -y, "x, ahead [mm]", "to the right [mm]")
    above.invert_yaxis()
    above.set_title("from above")
    _path(side, x, z, "x, ahead [mm]", "z, up [mm]")
    side.set_title("from the side")
    for pulse in record.planned.plan.pulses:
        over_time.axvspan(pulse.start / ms, (pulse.start + pulse.duration) / ms, color=PULSE, linewidth=0, zorder=0)
    over_time.axhline(0, **GUIDE_LINE)
    time = body.time / ms
    over_time.plot(time, x, color=EXACT, linewidth=1.6, label="ahead")
    over_time.plot(time, -y, color=PADE, linewidth=1.6, linestyle=(0, (4, 2)), label="right")
    over_time.plot(time, z, color=MARK, linewidth=1.6, linestyle=(0, (1, 1.2)), label="up")
    if len(time) > 1:
        over_time.set_xlim(time[0], time[-1])
    over_time.set_xlabel("time [ms]")
    over_time.set_ylabel("position [mm]")
    over_time.legend(loc="best")
    return figure


def _path(ax: Axes, across: np.ndarray, up: np.ndarray, x_label: str, y_label: str) -> None:
    ax.plot(across, up, color=EXACT, linewidth=1.4)
    if len(across):
        ax.plot(across[0], up[0], "o", color=INK, markersize=4)
        ax.plot(across[-1], up[-1], "s", color=MARK, markersize=4)
        _square(ax, across, up)
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)


def _square(ax: Axes, across: np.ndarray, up: np.ndarray) -> None:
    """The same scale along both axes."""
    half = 0.55 * max(float(np.ptp(across)), float(np.ptp(up)), _LEAST)
    for middle, limit in ((across, ax.set_xlim), (up, ax.set_ylim)):
        centre = (float(middle.min()) + float(middle.max())) / 2
        limit(centre - half, centre + half)
    ax.set_aspect("equal", adjustable="box")

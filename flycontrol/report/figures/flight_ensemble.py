"""Attitude of an ensemble of flights: each of them, their median and the middle nine tenths."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from flycontrol.flight.experiment_ensemble import ANGLES, FlownEnsemble
from flycontrol.flight.flight_record import FlightRecord
from flycontrol.report.figures.flight_panels import at_least, legend_above, panels_over_time
from flycontrol.report.style import EXACT, PADE_LINE, in_house_style
from flycontrol.units import deg, ms

_MOST_LINES = 60
_MIDDLE = (5.0, 95.0)  #: percent


@in_house_style()
def ensemble_attitude(record: FlightRecord, ensemble: FlownEnsemble) -> Figure:
    """Heading, nose-up angle and roll over time [deg]."""
    planned = record.planned
    labels = ("heading [deg]", "nose up [deg]", "roll [deg]")
    figure, panels = panels_over_time(labels, planned.frequency, planned.plan.pulses, height=5.6)
    time = ensemble.phase / planned.frequency / ms
    flying = np.count_nonzero(np.isfinite(ensemble.yaw), axis=0) > 0
    for ax, name in zip(panels, ANGLES, strict=True):
        angles = getattr(ensemble, name) / deg
        for k, one in enumerate(angles[:_MOST_LINES]):
            ax.plot(time, one, color="#69add5", linewidth=0.6, alpha=0.7, label=None if k else "single flights")
        low, high = np.nanpercentile(angles[:, flying], _MIDDLE, axis=0)
        ax.fill_between(time[flying], low, high, color=EXACT, alpha=0.15, linewidth=0, label="middle nine tenths")
        ax.plot(time[flying], np.nanmedian(angles[:, flying], axis=0), color=EXACT, linewidth=1.8, label="median")
        own = getattr(record.body, name) / deg
        ax.plot(record.body.time / ms, own, **PADE_LINE, label="the flight above")
        at_least(ax, 0.5)
    panels[0].set_xlim(0, time[-1])
    figure.align_ylabels(panels)
    legend_above(figure, panels[0])
    return figure

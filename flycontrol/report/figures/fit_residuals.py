"""What the fit leaves: residuals over time, their autocorrelation, and that of the innovations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.identify.gains.recording_fits import RecordingFit, autocorrelation
from flycontrol.report.style import BAND, EXACT, GUIDE_LINE, INK, QUIET, in_house_style, new_figure
from flycontrol.units import deg, ms

_MOST = 40  #: recordings drawn


@in_house_style()
def residuals(recordings: Sequence[RecordingFit]) -> Figure:
    """Yaw residuals [deg] over time [ms] of every recording, and autocorrelations [1] over lags [ms].

    The band holds 95 % of the autocorrelations of independent samples.
    """
    figure = new_figure(4.4)
    grid = figure.add_gridspec(2, 2, height_ratios=[1, 1.15])
    over_time = figure.add_subplot(grid[0, :])
    left = figure.add_subplot(grid[1, 0])
    right = figure.add_subplot(grid[1, 1], sharey=left)
    drawn = recordings[:_MOST]
    for recording in drawn:
        over_time.plot(recording.yaw.time / ms, recording.yaw.residual / deg, color=QUIET, linewidth=0.4, alpha=0.5)
    over_time.axhline(0, **GUIDE_LINE)
    over_time.set_xlabel("time [ms]")
    over_time.set_ylabel("residual yaw [deg]")
    _correlations(left, drawn, "residual")
    _correlations(right, drawn, "innovation")
    left.set_ylabel("autocorrelation [1]")
    left.set_title("residuals")
    right.set_title("innovations of the noise model")
    right.tick_params(labelleft=False)
    return figure


def _correlations(ax: Axes, recordings: Sequence[RecordingFit], kind: str) -> None:
    step = float(np.median([1 / r.trial.rate for r in recordings]))
    found = np.array([autocorrelation(getattr(r.yaw, kind), r.yaw.firsts) for r in recordings])
    found = found[:, ~np.isnan(found).all(axis=0)]  # no stretch is as long as the longest lags
    lags = np.arange(found.shape[1]) * step / ms
    width = 1.96 / np.sqrt(np.median([len(r.yaw.time) for r in recordings]))
    ax.axhspan(-width, width, color=BAND, linewidth=0, zorder=0)
    ax.axhline(0, **GUIDE_LINE)
    for row in found:
        ax.plot(lags, row, color=QUIET, linewidth=0.5, alpha=0.6)
    ax.plot(lags, np.nanmedian(found, axis=0), color=EXACT, linewidth=1.6)
    ax.annotate(
        "median", (lags[-1], float(np.nanmedian(found[:, -1]))), xytext=(0, 8), textcoords="offset points", ha="right",
        color=INK,
    )  # fmt: skip
    ax.set_xlim(0, lags[-1])
    ax.set_xlabel("lag [ms]")

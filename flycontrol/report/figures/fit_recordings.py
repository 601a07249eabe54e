"""Small multiples: measured and fitted yaw of each recording."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.identify.gains.recording_fits import RecordingFit
from flycontrol.model.trial import Pulse
from flycontrol.report.style import EXACT, GUIDE_LINE, PULSE, in_house_style, new_figure
from flycontrol.units import deg, ms

COLUMNS = 4
MEASURED = "#8a8a8a"
_POINTS = 260  #: drawn of each recording


@in_house_style()
def fitted_recordings(recordings: Sequence[RecordingFit]) -> Figure:
    """Yaw less heading [deg] over time [ms], dots measured, line fitted; one scale for all."""
    rows = -(-len(recordings) // COLUMNS)
    figure = new_figure(0.75 + 1.25 * rows)
    columns = min(COLUMNS, len(recordings))
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for ax, recording in zip(axes.flat, recordings, strict=False):
        _draw(ax, recording)
    for ax in axes.flat[len(recordings) :]:
        ax.set_visible(False)
    figure.supxlabel("time [ms]", fontsize=8.5)
    figure.supylabel("yaw from the heading kept [deg]", fontsize=8.5)
    return figure


def _draw(ax: Axes, recording: RecordingFit) -> None:
    fit, heading = recording.yaw, recording.heading
    pulse = recording.trial.perturbation
    if isinstance(pulse, Pulse):
        ax.axvspan(pulse.onset / ms, (pulse.onset + pulse.duration) / ms, color=PULSE, linewidth=0, zorder=0)
    ax.axhline(0, **GUIDE_LINE)
    every = max(1, len(fit.time) // _POINTS)
    ax.plot(
        fit.time[::every] / ms, (fit.measured[::every] - heading) / deg, ".", color=MEASURED, markersize=2.6,
        markeredgewidth=0, zorder=2.5,
    )  # fmt: skip
    ax.plot(fit.curve_time / ms, (fit.curve - heading) / deg, color=EXACT, linewidth=0.9)
    ax.set_title(_short(recording.trial.name), fontsize=7.5, weight="normal", pad=2)
    up = np.abs(np.max(fit.curve) - heading) >= np.abs(np.min(fit.curve) - heading)
    ax.text(
        0.98, 0.95 if up else 0.05, f"{fit.rms / deg:.2f}° rms", transform=ax.transAxes, ha="right",
        va="top" if up else "bottom", fontsize=7,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8},
    )  # fmt: skip


def _short(name: str, most: int = 24) -> str:
    """The end of a long name, where names of recordings differ."""
    return name if len(name) <= most else f"…{name[1 - most :]}"

"""The fly's torque as the fit predicts it from yaw alone, and the paddling that was measured (after Fig. 7d)."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from flycontrol.identify.gains.recording_fits import RecordingFit
from flycontrol.model.trial import Pulse
from flycontrol.report.figures.fit_recordings import COLUMNS, MEASURED
from flycontrol.report.style import EXACT, GUIDE_LINE, PULSE, in_house_style, new_figure
from flycontrol.units import deg, ms


@in_house_style()
def paddling_angles(recordings: Sequence[RecordingFit]) -> Figure:
    """Paddling angle d_alpha [deg] over time [ms]: dots measured, line N_fly / gamma of the fit."""
    rows, columns = -(-len(recordings) // COLUMNS), min(COLUMNS, len(recordings))
    figure = new_figure(0.75 + 1.35 * rows)
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for ax, recording in zip(axes.flat, recordings, strict=False):
        fit, pulse = recording.channels[1], recording.trial.perturbation
        if isinstance(pulse, Pulse):
            ax.axvspan(pulse.onset / ms, (pulse.onset + pulse.duration) / ms, color=PULSE, linewidth=0, zorder=0)
        ax.axhline(0, **GUIDE_LINE)
        ax.plot(fit.time / ms, fit.measured / deg, "o", color=MEASURED, markersize=2.4, markeredgewidth=0)
        ax.plot(fit.curve_time / ms, fit.curve / deg, color=EXACT, linewidth=1.1)
        ax.set_title(recording.trial.name, fontsize=7.5, weight="normal", pad=2)
    for ax in axes.flat[len(recordings) :]:
        ax.set_visible(False)
    figure.supxlabel("time [ms]", fontsize=8.5)
    figure.supylabel("paddling angle Δα [deg]", fontsize=8.5)
    return figure

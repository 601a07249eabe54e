"""Recovery time against strength: measured recordings over the band that the fit predicts (after Fig. 8c)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.identify.gains.recoveries import MeasuredRecovery
from flycontrol.identify.gains.recovery_band import RecoveryAgainstStrength
from flycontrol.report.style import EXACT_LINE, GUIDE_LINE, INK, MARK, QUIET, in_house_style, new_figure
from flycontrol.units import deg, ms

_BAND = "#c5dcec"


@in_house_style()
def recovery_points(found: RecoveryAgainstStrength) -> Figure:
    """Recovery time [ms] against peak deflection [deg]; dots measured with intervals, open where not recovered."""
    figure = new_figure(3.9)
    ax = figure.subplots()
    band = found.band
    times = [r.time for r in found.measured if np.isfinite(r.time)]
    top = 1.25 * max([*times, float(np.nanmax(band.times))]) / ms
    x = band.peaks / deg
    ax.fill_between(
        x, band.low / ms, np.minimum(band.high / ms, 2 * top), color=_BAND, linewidth=0,
        label=f"predicted, {100 * band.level:g} %",
    )  # fmt: skip
    ax.plot(x, band.times / ms, **EXACT_LINE, label="predicted, estimates")
    for measured in found.measured:
        _point(ax, measured, top)
    ax.plot([], [], "o", color=MARK, markeredgecolor="white", markersize=5, label="measured")
    if any(not r.recovered for r in found.measured):
        ax.plot([], [], "^", color="white", markeredgecolor=INK, markersize=6, label="not recovered in the recording")
    ax.axvline(band.tolerance / deg, **GUIDE_LINE)
    ax.annotate(
        f"smaller peaks never leave ±{band.tolerance / deg:g}°", (band.tolerance / deg, 0.03 * top), xytext=(5, 0),
        textcoords="offset points", color=QUIET,
    )  # fmt: skip
    ax.set_xlim(0, x[-1])
    ax.set_ylim(0, top)
    ax.set_xlabel("peak deflection in yaw, either side [deg]")
    ax.set_ylabel("recovery time [ms]")
    figure.legend(loc="outside upper left", ncols=4, borderaxespad=0)
    return figure


def _point(ax: Axes, measured: MeasuredRecovery, top: float) -> None:
    x = abs(measured.peak) / deg
    if not measured.recovered:
        ax.plot(x, 0.97 * top, "^", color="white", markeredgecolor=INK, markersize=6, clip_on=False)
        return
    ends = [measured.low / ms, min(measured.high / ms, 2 * top)]
    ax.plot([x, x], ends, color=MARK, linewidth=1.1)
    ax.plot(x, measured.time / ms, "o", color=MARK, markeredgecolor="white", markersize=5)

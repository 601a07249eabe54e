"""Recovery time against strength of flies that differ: each one's prediction and recordings in a look of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from flycontrol.identify.gains.recovery_band import RecoveryAgainstStrength
from flycontrol.report.style import GUIDE_LINE, INK, STRENGTHS, in_house_style, new_figure
from flycontrol.units import deg, ms

_MARKS = "os^Dv"
_LINES = ("-", (0, (5, 2)), (0, (1, 1.2)), (0, (6, 2, 1, 2)), (0, (3, 1, 1, 1, 1, 1)))
_NAMED = 10  #: flies with a line in the legend


@in_house_style()
def recoveries_apart(found: Sequence[tuple[str, RecoveryAgainstStrength]]) -> Figure:
    """Recovery time [ms] against peak deflection [deg]."""
    figure = new_figure(3.9)
    ax = figure.subplots()
    times = [r.time for _, each in found for r in each.measured if np.isfinite(r.time)]
    top = 1.2 * max([*times, *(float(np.nanmax(each.band.times)) for _, each in found)]) / ms
    for k, (name, each) in enumerate(found):
        colour = STRENGTHS[1:][k % 4] if k % 5 else INK
        label = name if k < _NAMED else None
        ax.plot(
            each.band.peaks / deg, each.band.times / ms, linestyle=_LINES[k % 5], linewidth=1.3, label=label,
            marker=_MARKS[k % 5], markevery=[-1], markersize=4, color=colour,
        )  # fmt: skip
        for r in each.measured:
            x = abs(r.peak) / deg
            if not r.recovered:
                ax.plot(x, 0.985 * top, _MARKS[k % 5], markerfacecolor="white", markersize=5, color=colour)
                continue
            ax.plot([x, x], [r.low / ms, min(r.high / ms, 2 * top)], linewidth=0.9, color=colour)
            ax.plot(x, r.time / ms, _MARKS[k % 5], markeredgecolor="white", markersize=5.5, color=colour)
    ax.axvline(found[0][1].band.tolerance / deg, **GUIDE_LINE)
    ax.set_xlim(0, max(float(each.band.peaks[-1]) for _, each in found) / deg)
    ax.set_ylim(0, top)
    ax.set_xlabel("peak deflection in yaw, either side [deg]")
    ax.set_ylabel("recovery time [ms]")
    figure.legend(loc="outside upper left", ncols=5, borderaxespad=0)
    return figure

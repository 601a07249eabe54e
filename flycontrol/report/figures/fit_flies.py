"""Each fly, or each recording, fitted alone: estimates with intervals beside the pooled one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import scipy.special
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.identify.gains.alone import LoneFit
from flycontrol.identify.gains.random_effects import RandomEffects
from flycontrol.identify.gains.result import Estimate
from flycontrol.report.figures.fit_profiles import axis_label
from flycontrol.report.fit.words import KINDS
from flycontrol.report.style import BAND, EXACT, INK, MARK, in_house_style, new_figure

MOST = 40  #: fits drawn


@in_house_style()
def fits_compared(
    fits: Sequence[LoneFit], pooled: Mapping[str, Estimate], effects: Sequence[RandomEffects], level: float
) -> Figure:
    """One panel an unknown, one row a fit: dots with intervals; band the pooled interval, diamond the mean of all."""
    shown = [fit for fit in fits if fit.usable][:MOST]
    kinds = shown[0].kinds
    figure = new_figure(1.0 + 0.16 * max(len(shown), 5))
    axes = figure.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
    means = {effect.kind: effect for effect in effects}
    for ax, kind in zip(axes, kinds, strict=True):
        _draw(ax, shown, kind, pooled.get(kind), level)
        if kind in means:
            _mean(ax, means[kind], len(shown))
        ax.set_xlabel(axis_label(kind))
    axes[0].set_yticks(range(len(shown) + 1), [*(fit.name for fit in shown), "mean"], fontsize=7)
    axes[0].set_ylim(len(shown) + 0.7, -0.7)
    return figure


def _draw(ax: Axes, shown: Sequence[LoneFit], kind: str, pooled: Estimate | None, level: float) -> None:
    size = KINDS[kind][3]
    if pooled is not None and np.isfinite(pooled.low + pooled.high):
        ax.axvspan(pooled.low / size, pooled.high / size, color=BAND, linewidth=0, zorder=0)
    for row, fit in enumerate(shown):
        error, value = fit.standard_error(kind), fit.estimate(kind)
        width = float(scipy.special.stdtrit(fit.freedom[fit.kinds.index(kind)], 0.5 + level / 2)) * error
        ax.plot([(value - width) / size, (value + width) / size], [row, row], color=EXACT, linewidth=1.1)
        ax.plot(value / size, row, "o", color=EXACT, markersize=3.5)


def _mean(ax: Axes, mean: RandomEffects, row: int) -> None:
    size = KINDS[mean.kind][3]
    ax.plot([mean.mean_low / size, mean.mean_high / size], [row, row], color=MARK, linewidth=1.6)
    ax.plot(mean.mean / size, row, "D", color=MARK, markeredgecolor=INK, markeredgewidth=0.5, markersize=4.5)

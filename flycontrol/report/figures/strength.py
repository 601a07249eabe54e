"""Recovery time against perturbation strength: sharp rise, plateau, and jumps where a later swing leaves the band."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.model.recovery import RecoveryCurve
from flycontrol.model.stability import StabilityResult
from flycontrol.report.style import (
    EXACT,
    EXACT_LINE,
    GUIDE_LINE,
    MARK,
    QUIET,
    in_house_style,
    new_figure,
    wingbeat_axis,
)
from flycontrol.units import deg, ms

_ROOM = 0.9  #: of the longest time; words stand above lower jumps


@in_house_style()
def recovery_against_strength(
    curve: RecoveryCurve, result: StabilityResult, wingbeat_frequency: float, deadline: float
) -> Figure:
    """Recovery time [ms] and [wingbeats] against peak deflection [deg] (after Fig. 8c).

    Parameters
    ----------
    curve
        Exact recovery times; drawn broken at its jumps.
    result
        Gives the nominal pulse, which is marked.
    wingbeat_frequency
        For the second axis [1/s].
    deadline
        The review's limit, drawn as a guide [s].
    """
    figure = new_figure(3.9)
    ax = figure.subplots()
    top = 1.12 * float(curve.times.max()) / ms
    _draw_broken(ax, curve)
    _mark_deadline(ax, curve, deadline, top)
    _mark_jumps(ax, curve)
    _mark_nominal(ax, result)
    _mark_band(ax, curve, top)
    ax.set_xlim(0, float(curve.peaks[-1]) / deg)
    ax.set_ylim(0, top)
    ax.set_xlabel("peak deflection in yaw [deg]")
    ax.set_ylabel("recovery time [ms]")
    wingbeat_axis(ax, wingbeat_frequency, "y")
    return figure


def _draw_broken(ax: Axes, curve: RecoveryCurve) -> None:
    """Recovery time between its jumps."""
    bounds = [float(curve.peaks[0]), *curve.jumps, float(curve.peaks[-1])]
    for left, right in pairwise(bounds):
        part = (curve.peaks >= left) & (curve.peaks < right) if right < bounds[-1] else curve.peaks >= left
        ax.plot(curve.peaks[part] / deg, curve.times[part] / ms, **EXACT_LINE)


def _mark_deadline(ax: Axes, curve: RecoveryCurve, deadline: float, top: float) -> None:
    ax.axhline(deadline / ms, **GUIDE_LINE)
    ax.text(
        curve.tolerance / deg + 0.016 * float(curve.peaks[-1]) / deg, deadline / ms + 0.012 * top,
        f"{deadline / ms:.3g} ms", color=QUIET, va="bottom",
    )  # fmt: skip


def _mark_nominal(ax: Axes, result: StabilityResult) -> None:
    if result.recovery_time is None:
        return
    place = (result.task.peak / deg, result.recovery_time / ms)
    ax.plot(*place, "o", color=MARK, markersize=6)
    ax.annotate(
        f"nominal pulse: {result.recovery_time / ms:.1f} ms", place, xytext=(6, -14), textcoords="offset points",
        color=MARK,
    )  # fmt: skip


def _mark_band(ax: Axes, curve: RecoveryCurve, top: float) -> None:
    """Peaks that need no recovery."""
    ax.axvline(curve.tolerance / deg, **GUIDE_LINE)
    ax.annotate(
        f"smaller peaks never leave ±{curve.tolerance / deg:g}°", (curve.tolerance / deg, 0.05 * top), xytext=(5, 0),
        textcoords="offset points", color=QUIET,
    )  # fmt: skip


def _mark_jumps(ax: Axes, curve: RecoveryCurve) -> None:
    """Both sides of each jump: filled where the value is taken, open where it is not; nothing joins them."""
    for k, jump in enumerate(curve.jumps):
        before, after = curve.times[curve.peaks < jump], curve.times[curve.peaks >= jump]
        if not (len(before) and len(after)):
            continue
        ax.plot(jump / deg, before[-1] / ms, "o", color=EXACT, markersize=5)
        ax.plot(jump / deg, after[0] / ms, "o", markeredgecolor=EXACT, markerfacecolor="white", markersize=5)
        swing = float(np.sort(curve.swings[curve.swings < 1])[::-1][k]) if len(curve.swings) > k + 1 else np.nan
        above = after[0] < _ROOM * curve.times.max()
        ax.annotate(
            f"jump at {jump / deg:.1f}°:\na later swing, {swing:.2%}\nof the peak, leaves the band",
            (jump / deg, after[0] / ms), xytext=(-6, 4 if above else 0), textcoords="offset points", ha="right",
            va="bottom" if above else "center",
        )  # fmt: skip

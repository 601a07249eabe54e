"""The best P and the best PD over the published range of yaw damping, against the recovery time of real flies."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from flycontrol.model.study import DampingRow
from flycontrol.report.style import EXACT_LINE, GUIDE_LINE, MARK, PADE_LINE, QUIET, in_house_style, new_figure
from flycontrol.units import ms


@in_house_style()
def p_against_pd(rows: Sequence[DampingRow], deadline: float, suffices_from: float | None, own: float) -> Figure:
    """Shortest recovery time [ms] and its modulus margin against beta/I [1/s].

    Parameters
    ----------
    rows
        Best controllers at each damping.
    deadline
        Recovery time that P alone is held against [s].
    suffices_from
        beta/I from which the best P meets the deadline [1/s]; None where that was not found.
    own
        beta/I of this fly [1/s].
    """
    figure = new_figure(3.7)
    left, right = figure.subplots(1, 2, width_ratios=[1.6, 1])
    b = [row.b for row in rows]
    p = {**PADE_LINE, "linewidth": 1.2, "marker": "o", "markersize": 5}
    pd = {**EXACT_LINE, "linewidth": 1.2, "marker": "s", "markersize": 5}
    left.plot(b, [row.proportional.recovery_time / ms for row in rows], **p, label="best P")
    left.plot(b, [row.derivative.recovery_time / ms for row in rows], **pd, label="best PD")
    right.plot(b, [row.proportional.modulus_margin for row in rows], **p)
    right.plot(b, [row.derivative.modulus_margin for row in rows], **pd)
    left.axhline(deadline / ms, color=MARK, linewidth=0.9)
    left.annotate(
        f"{deadline / ms:.3g} ms", (b[0], deadline / ms), xytext=(8, 2), textcoords="offset points", color=MARK
    )
    if suffices_from is not None:
        left.plot(suffices_from, deadline / ms, "D", color=MARK, markersize=6)
        left.annotate(
            f"P suffices from {suffices_from:.0f} 1/s", (suffices_from, deadline / ms), xytext=(4, -9),
            textcoords="offset points", color=MARK, ha="right" if suffices_from > b[-1] else "center", va="top",
        )  # fmt: skip
    for ax in (left, right):
        ax.axvline(own, **GUIDE_LINE)
        ax.set_xlabel("yaw damping β/I [1/s]")
        ax.set_ylim(0, 1.12 * ax.get_ylim()[1])
    left.annotate("this fly", (own, 0), xytext=(3, 4), textcoords="offset points", color=QUIET)
    left.set_ylabel("recovery time [ms]")
    right.set_ylabel("modulus margin [1]")
    left.legend(loc="lower right")
    return figure

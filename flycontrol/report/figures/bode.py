"""Bode diagram of the open loop: exact beside Pade, with gain and phase margins."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.delay.margins import Margins
from flycontrol.model.loop_shape import LoopShape
from flycontrol.report.style import (
    EXACT_LINE,
    GUIDE_LINE,
    MARK,
    PADE_LINE,
    in_house_style,
    new_figure,
    plain_log_ticks,
)
from flycontrol.units import deg


@in_house_style()
def bode(shape: LoopShape, margins: Margins | None, delay: float) -> Figure:
    """|L| in dB and arg L in deg against angular frequency, up to eight radians of delay.

    Parameters
    ----------
    shape
        Open-loop frequency response.
    margins
        Marked where they exist; None for an unstable loop.
    delay
        The loop's delay [s]; sets how far the frequencies reach.
    """
    figure = new_figure(4.6)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1, 1.15])
    omega = shape.exact.omega
    phase, phase_pade = shape.exact.phase / deg, np.unwrap(np.angle(shape.pade)) / deg
    upper.semilogx(omega, 20 * np.log10(shape.exact.magnitude), **EXACT_LINE, label="exact delay")
    upper.semilogx(omega, 20 * np.log10(np.abs(shape.pade)), **PADE_LINE, label=f"Padé, order {shape.pade_order}")
    lower.semilogx(omega, phase, **EXACT_LINE)
    lower.semilogx(omega, phase_pade, **PADE_LINE)
    upper.axhline(0, **GUIDE_LINE)
    lower.axhline(-180, **GUIDE_LINE)
    far = min(8.0 / max(delay, 1e-3), float(omega[-1]))
    lower.set_xlim(max(omega[0], far / 250), far)
    shown = (omega >= lower.get_xlim()[0]) & (omega <= far)
    upper.set_ylim(
        20 * np.log10(shape.exact.magnitude[shown].min()) - 3, 20 * np.log10(shape.exact.magnitude[shown].max()) + 3
    )
    lower.set_yticks(np.arange(-1080, 1, 90))
    lower.set_ylim(max(phase[shown].min(), -1080) - 30, phase[shown].max() + 30)
    upper.set_ylabel("magnitude |L| [dB]")
    lower.set_ylabel("phase of L [deg]")
    lower.set_xlabel("angular frequency [rad/s]")
    plain_log_ticks(lower)
    upper.legend(loc="lower left")
    if margins is not None:
        _mark_margins(upper, lower, margins)
    return figure


def _mark_margins(upper: Axes, lower: Axes, margins: Margins) -> None:
    if len(margins.gain_crossovers) and np.isfinite(margins.phase_margin):
        where, left = float(margins.gain_crossovers[-1]), margins.phase_margin / deg
        _guide((upper, lower), where)
        _span(lower, where, -180, -180 + left)
        _label(lower, (where, -180), (-8, -6), f"phase margin {left:.1f}° at {where:.1f} rad/s")
    if len(margins.phase_crossovers) and np.isfinite(margins.gain_margin):
        where, down = float(margins.phase_crossovers[0]), -20 * np.log10(margins.gain_margin)
        _guide((upper, lower), where)
        _span(upper, where, 0, down)
        _label(
            upper, (where, 0), (8, 14), f"gain margin {margins.gain_margin:.2f} = {-down:.1f} dB at {where:.0f} rad/s"
        )


def _guide(panels: tuple[Axes, Axes], x: float) -> None:
    for ax in panels:
        ax.axvline(x, **GUIDE_LINE)


def _span(ax: Axes, x: float, start: float, end: float) -> None:
    ax.plot([x, x], [start, end], color=MARK, linewidth=2.4, solid_capstyle="butt")
    ax.plot([x, x], [start, end], color=MARK, linestyle="none", marker="_", markersize=8, markeredgewidth=1.4)


def _label(ax: Axes, at: tuple[float, float], offset: tuple[float, float], text: str) -> None:
    side = "left" if offset[0] > 0 else "right"
    ax.annotate(text, at, xytext=offset, textcoords="offset points", color=MARK, ha=side, va="top")

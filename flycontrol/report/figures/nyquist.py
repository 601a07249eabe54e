"""Nyquist diagram of the open loop around -1, with gain, phase and modulus margins."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle

from flycontrol.delay.margins import Margins
from flycontrol.delay.system import ComplexArray
from flycontrol.model.loop_shape import LoopShape
from flycontrol.report.style import (
    EXACT,
    EXACT_LINE,
    GUIDE_LINE,
    INK,
    MARK,
    PADE_LINE,
    QUIET,
    in_house_style,
    new_figure,
)
from flycontrol.units import deg

_LEFT, _RIGHT, _LOW, _HIGH = -2.4, 1.6, -2.1, 1.25  #: the picture, unless the curve crosses further left


@in_house_style()
def nyquist(shape: LoopShape, margins: Margins | None) -> Figure:
    """L(j w) for w > 0, its mirror image in grey, the unit circle, and around -1 the circle of the modulus margin."""
    figure = new_figure(5.0)
    ax = figure.subplots()
    wide = max(1.0, 1.2 * float(-shape.negative_crossings.min(initial=0.0)) / -_LEFT)  # all crossings left of -1
    near = shape.exact.magnitude < 12 * wide
    exact, approximate = shape.exact.value[near], shape.pade[near]
    ax.axhline(0, **GUIDE_LINE)
    ax.axvline(0, **GUIDE_LINE)
    ax.add_patch(Circle((0, 0), 1.0, fill=False, edgecolor=QUIET, linewidth=0.8))
    if wide < 2:
        ax.text(0.74, 0.74, "unit circle", color=QUIET, ha="left")
    ax.plot(exact.real, -exact.imag, color="#bdbdbd", linewidth=1.0)
    ax.plot(exact.real, exact.imag, **EXACT_LINE, label="exact delay, ω > 0")
    ax.plot(approximate.real, approximate.imag, **PADE_LINE, label=f"Padé, order {shape.pade_order}")
    ax.plot([], [], color="#bdbdbd", linewidth=1.0, label="exact, ω < 0")
    _arrow(ax, exact, wide)
    ax.plot(-1, 0, marker="+", color=INK, markersize=10, markeredgewidth=1.6)
    ax.annotate("−1", (-1, 0), xytext=(5, 5), textcoords="offset points", ha="left", weight="bold")
    if margins is not None:
        _mark_margins(ax, margins)
    ax.set_aspect("equal")
    ax.set_xlim(wide * _LEFT, wide * _RIGHT)
    ax.set_ylim(wide * _LOW, wide * _HIGH)
    ax.set_xlabel("real part of L [1]")
    ax.set_ylabel("imaginary part of L [1]")
    ax.legend(loc="lower right")
    return figure


def _arrow(ax: Axes, curve: ComplexArray, wide: float) -> None:
    """Direction of rising frequency, where the curve comes into the picture."""
    inside = np.flatnonzero((curve.imag > wide * (_LOW + 0.4)) & (curve.imag < 0) & (np.abs(curve) > 1))
    if len(inside) < 2:
        return
    k = int(inside[0])
    ahead = min(k + 2, len(curve) - 1)
    ax.annotate(
        "", (curve[ahead].real, curve[ahead].imag), xytext=(curve[k].real, curve[k].imag),
        arrowprops={"arrowstyle": "-|>", "color": EXACT, "linewidth": 1.4, "mutation_scale": 12},
    )  # fmt: skip


def _mark_margins(ax: Axes, margins: Margins) -> None:
    ax.add_patch(
        Circle((-1, 0), margins.modulus_margin, fill=False, edgecolor=MARK, linewidth=1.2, linestyle=(0, (5, 2)))
    )
    top = margins.modulus_margin * np.exp(1j * 125 * deg) - 1
    _label(ax, top, (-4, 4), f"modulus margin {margins.modulus_margin:.3f}")
    if margins.phase_margin < np.pi:
        _mark_phase_margin(ax, margins.phase_margin)
    if np.isfinite(margins.gain_margin):
        crossing = -1.0 / margins.gain_margin
        ax.plot(crossing, 0, "s", color=MARK, markersize=5)
        ax.annotate(
            f"−1 / gain margin = {crossing:.3f}".replace("= -", "= −"), (crossing, 0), xytext=(crossing, 0.37),
            color=MARK, arrowprops={"arrowstyle": "-", "color": MARK, "linewidth": 0.7, "relpos": (0, 0)},
        )  # fmt: skip


def _mark_phase_margin(ax: Axes, margin: float) -> None:
    ax.add_patch(Arc((0, 0), 2, 2, theta1=180, theta2=180 + margin / deg, color=MARK, linewidth=2.4))
    end = np.exp(1j * (np.pi + margin))
    ax.plot([0, end.real], [0, end.imag], color=MARK, linewidth=0.8)
    ax.plot(end.real, end.imag, "o", color=MARK, markersize=5)
    _label(ax, end, (-8, -4), f"phase margin {margin / deg:.1f}°")


def _label(ax: Axes, at: complex, offset: tuple[float, float], text: str) -> None:
    ax.annotate(
        text, (at.real, at.imag), xytext=offset, textcoords="offset points", ha="right",
        va="bottom" if offset[1] > 0 else "top", color=MARK,
    )  # fmt: skip

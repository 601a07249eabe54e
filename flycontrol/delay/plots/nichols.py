"""Nichols charts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.plots.bode import phase_ticks
from flycontrol.delay.plots.comparison import Beside
from flycontrol.delay.plots.frequencies import frequency_curves
from flycontrol.delay.plots.style import INK, QUIET, legend, line_of, panel, tell

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_CLOSED_LOOP = (12.0, 6.0, 3.0, 1.0, 0.0, -1.0, -3.0, -6.0, -12.0, -20.0)  # |T| of the grid [dB]
_LOWEST, _HIGHEST = -40.0, 40.0  # of what is shown when more than that is there [dB]


def nichols_plot(  # noqa: PLR0913 (python-control's arguments)
    data: Any,
    omega: ArrayLike | None = None,
    *,
    grid: bool = True,
    ax: Axes | None = None,
    omega_limits: Sequence[float] | None = None,
    pade: int | None = None,
    approximation: Any = None,
    label: str | Sequence[str] | None = None,
    title: str | None = None,
) -> Axes:
    """20 log10 |L(jw)| [dB] over arg L(jw) [deg], on contours of equal |T| = |L / (1 + L)| (M-circles).

    Parameters
    ----------
    grid
        Whether the contours are drawn.

    The others, and errors, as in `bode_plot`.
    """
    shown = frequency_curves(data, omega, omega_limits, Beside(pade=pade, approximation=approximation, label=label))
    ax = panel(ax)
    low, high = 0.0, 0.0
    left, right = -200.0, -160.0
    for curve in shown:
        decibels, phase = curve.result.decibels, np.degrees(curve.result.phase)
        ax.plot(phase, decibels, **line_of(curve), label=curve.label or None)
        within = (decibels >= _LOWEST) & (decibels <= _HIGHEST) & (phase > -900.0)
        low, high = min(low, *decibels[within]), max(high, *decibels[within])
        left, right = min(left, *phase[within]), max(right, *phase[within])
    ax.set_xlim(left - 15.0, right + 15.0)
    ax.set_ylim(low - 3.0, high + 3.0)
    if grid:
        _closed_loop_contours(ax)
    for turn in range(int(np.ceil((left - 15.0 + 180.0) / 360.0)), int(np.floor((right + 15.0 + 180.0) / 360.0)) + 1):
        ax.plot(360.0 * turn - 180.0, 0.0, marker="+", color=INK, markersize=10, markeredgewidth=1.6, zorder=3)
    ax.set_xlabel("phase [deg]")
    ax.set_ylabel("magnitude [dB]")
    phase_ticks(ax, "x")
    legend(ax)
    tell(ax, title)
    return ax


def _closed_loop_contours(ax: Axes) -> None:
    """|T| = M: L = T / (1 - T) with T = M exp(j theta), repeated every turn of phase."""
    theta = np.linspace(-2.0 * np.pi, 0.0, 801)[1:-1]
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    for decibels in _CLOSED_LOOP:
        T = 10.0 ** (decibels / 20.0) * np.exp(1j * theta)
        L = T / (1.0 - T)
        phase = np.unwrap(np.angle(L))
        phase += np.pi * (np.round(-phase.mean() / np.pi) - 1.0)  # T = -M lies at -180 degrees
        degrees, height = np.degrees(phase), 20.0 * np.log10(np.abs(L))
        for turn in range(int(np.floor(left / 360.0)), int(np.ceil(right / 360.0)) + 1):
            x = degrees + 360.0 * (turn + 1)
            ax.plot(x, height, color=QUIET, linewidth=0.5, alpha=0.6, zorder=0.5)
            half = slice(None) if decibels > 0 else slice(len(x) // 2)  # both ends of an open contour are highest
            _name(ax, x[half], height[half], f"{decibels:g} dB")
    ax.set_xlim(left, right)
    ax.set_ylim(low, high)


def _name(ax: Axes, x: Any, y: Any, text: str) -> None:
    """Write on a contour, where it is highest inside the picture."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    inside = np.flatnonzero((x > left + 20.0) & (x < right - 20.0) & (y > low) & (y < high))
    if len(inside):
        at = inside[int(np.argmax(y[inside]))]
        ax.text(x[at], y[at], text, color=QUIET, fontsize="x-small", ha="center", va="center", clip_on=True, zorder=0.6)

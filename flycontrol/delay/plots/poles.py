"""Poles in the complex plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from flycontrol.delay.plots.comparison import Beside, Curve, curves
from flycontrol.delay.plots.style import APPROXIMATE, GUIDE, QUIET, SERIES, legend, panel, shade_unstable, tell
from flycontrol.delay.spectrum import Spectrum, rightmost_roots
from flycontrol.delay.system import DelayLTI

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flycontrol.delay.convert import Operand


def pole_map(sysdata: Operand, count: int = 12) -> Spectrum:
    """The rightmost poles of a system, of which one with delays has infinitely many; see `rightmost_roots`."""
    return rightmost_roots(sysdata, count)


def pole_plot(  # noqa: PLR0913 (python-control's arguments)
    data: Any,
    *,
    count: int = 12,
    ax: Axes | None = None,
    pade: int | None = None,
    approximation: Any = None,
    label: str | Sequence[str] | None = None,
    title: str | None = None,
) -> Axes:
    """The rightmost poles [1/s], the unstable half plane tinted, and the line right of which the list is complete.

    Parameters
    ----------
    data
        System or `Spectrum`, or a list of these.
    count
        Poles of each system.
    pade
        Order n of the Padé approximation [n/n] whose poles are drawn beside those of each system.
    approximation
        System or `Spectrum` drawn beside, one for each in `data`.
    label
        Of each in `data`.

    Raises
    ------
    InvalidParameterError
        If arguments do not fit each other.
    NeutralSystemError
        If a system is of neutral type.
    """
    beside = Beside(pade=pade, approximation=approximation, label=label)
    shown = curves(data, Spectrum, lambda system: _found(system, count), beside)
    ax = panel(ax, (5.6, 4.8))
    for curve in shown:
        roots = curve.result.roots
        ax.plot(roots.real, roots.imag, **_marker(curve), label=curve.label or None)
    ax.axhline(0.0, **GUIDE)
    exact = [curve.result for curve in shown if curve.exact]
    _frame(ax, exact)
    shade_unstable(ax)
    if len(exact) == 1:
        _certified_right_of(ax, exact[0])
    ax.set_xlabel("real part [1/s]")
    ax.set_ylabel("imaginary part [rad/s]")
    legend(ax, loc="best")
    tell(ax, title)
    return ax


def _found(system: DelayLTI, count: int) -> Spectrum:
    """All poles of a system without delays, as many as asked for of another."""
    return rightmost_roots(system, count if system.n_delays else max(count, system.n_states))


def _marker(curve: Curve[Spectrum]) -> dict[str, Any]:
    colour = SERIES[curve.series % len(SERIES)]
    if curve.exact:
        marker = ("x", "*", "d", "^", "v")[curve.series % 5]
        return {"color": colour, "marker": marker, "markersize": 7, "markeredgewidth": 1.8, "linestyle": "none"}
    colour = APPROXIMATE if curve.alone else colour
    return {
        "color": colour, "marker": "o", "markersize": 9, "markerfacecolor": "none", "markeredgewidth": 1.3,
        "linestyle": "none",
    }  # fmt: skip


def _frame(ax: Axes, exact: list[Spectrum]) -> None:
    """Show all exact poles and the origin; poles of approximations far left stay outside."""
    roots = np.concatenate([np.zeros(1), *[spectrum.roots for spectrum in exact]])
    lines = [spectrum.line for spectrum in exact if np.isfinite(spectrum.line)]
    left, right = min([roots.real.min(), *lines]), roots.real.max()
    width = max(right - left, 1e-3 * float(np.abs(roots).max()), 1e-12)
    height = max(float(np.abs(roots.imag).max()), 0.3 * width)
    ax.set_xlim(left - 0.1 * width, right + 0.12 * width)
    ax.set_ylim(-1.12 * height, 1.12 * height)


def _certified_right_of(ax: Axes, spectrum: Spectrum) -> None:
    """The line of the count, and the side on which no pole is missing."""
    if not np.isfinite(spectrum.line):
        return
    certified = spectrum.status.startswith("certified")
    words = "complete right of this line, certified" if certified else f"line of the count: {spectrum.status}"
    ax.axvline(spectrum.line, color=QUIET, linewidth=1.1, linestyle="-" if certified else (0, (1, 2)), label=words)

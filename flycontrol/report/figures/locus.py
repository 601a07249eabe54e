"""Root locus in the gain and in the delay: where the exact closed-loop poles go, and where stability ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.delay.locus import RootLocus
from flycontrol.delay.system import ComplexArray, FloatArray
from flycontrol.report.style import EXACT, FORBIDDEN, GUIDE_LINE, INK, MARK, in_house_style, new_figure


@dataclass(frozen=True, slots=True, kw_only=True)
class LocusReading:
    """How a locus is read: its own value, where it crosses, which values are written beside it."""

    own: float  #: value of the loop itself
    crossing: float | None  #: value on the boundary of stability that the study solved for; None: read off the locus
    labels: Sequence[float]  #: values written beside the dominant branch
    scale: float  #: value times scale is what is written
    unit: str  #: written after a value


@in_house_style()
def root_loci(locus: RootLocus, reading: LocusReading) -> Figure:
    """Two panels, upper half plane: around the dominant poles, and the train of poles that the delay brings.

    Parameters
    ----------
    locus
        Roots [1/s] over the gain or the delay.
    reading
        How to read it.
    """
    figure = new_figure(3.9)
    near, whole = figure.subplots(1, 2, width_ratios=[1.35, 1])
    at_own = _at(locus, reading.own)
    size = float(np.abs(at_own[np.argmax(at_own.real)]))
    for ax in (near, whole):
        _draw_branches(ax, locus)
        ax.plot(
            at_own.real,
            at_own.imag,
            "s",
            color=EXACT,
            markersize=5,
            label=f"this loop, {_written(reading, reading.own)}",
        )
        ax.set_xlabel("real part [1/s]")
    near.set_ylabel("imaginary part [1/s]")
    _frame(near, (-2.6 * size, 0.75 * size), 2.3 * size)
    _frame(whole, (-8.0 * size, 0.9 * size), 18.0 * size)
    near.set_title("around the dominant poles")
    whole.set_title("further out")
    where, value = crossing(locus, reading.own)
    if np.isfinite(value):
        exact = reading.crossing is not None
        text = _written(reading, reading.crossing if reading.crossing is not None else value)
        near.plot(0, where, "D", color=MARK, markersize=6, label=f"stability ends at {'' if exact else 'about '}{text}")
    _label_values(near, locus, reading, complex(0, where))
    near.legend(loc="upper left", handletextpad=0.2, borderaxespad=0.2)
    return figure


def crossing(locus: RootLocus, own: float) -> tuple[float, float]:
    """Imaginary part [1/s] and parameter value of the imaginary-axis crossing nearest to `own`, between two samples."""
    best = (np.nan, np.nan)
    for branch in locus.branches:
        a = branch.real
        for k in np.flatnonzero(a[1:] * a[:-1] < 0):
            f = a[k] / (a[k] - a[k + 1])
            value = float(locus.values[k] ** (1 - f) * locus.values[k + 1] ** f)
            if not np.isfinite(best[1]) or abs(np.log(value / own)) < abs(np.log(best[1] / own)):
                best = (float(branch.imag[k] + f * (branch.imag[k + 1] - branch.imag[k])), value)
    return best


def _at(locus: RootLocus, value: float) -> ComplexArray:
    """Roots at a value, interpolated along each branch that exists there."""
    found = [_along(branch, locus.values, value) for branch in locus.branches]
    return np.array([root for root in found if np.isfinite(root.real)])


def _along(branch: ComplexArray, values: FloatArray, value: float) -> complex:
    there = np.isfinite(branch.real)
    if there.sum() < 2 or not values[there][0] <= value <= values[there][-1]:
        return complex(np.nan, np.nan)
    position = np.interp(np.log(value), np.log(values[there]), np.arange(there.sum()))
    k = min(int(position), int(there.sum()) - 2)
    return complex(branch[there][k] + (position - k) * (branch[there][k + 1] - branch[there][k]))


def _draw_branches(ax: Axes, locus: RootLocus) -> None:
    for branch in locus.branches:
        there = branch[np.isfinite(branch.real)]
        ax.plot(there.real, there.imag, color=EXACT, linewidth=1.2, solid_joinstyle="round")
    ax.axvline(0, **GUIDE_LINE)


def _frame(ax: Axes, real: tuple[float, float], top: float) -> None:
    if not real[0] < real[1]:  # a locus that does not move
        real = (real[0] - 1.0, real[0] + 1.0) if np.isfinite(real[0]) else (-1.0, 1.0)
    top = top if np.isfinite(top) and top > 0 else 1.0
    ax.set_xlim(*real)
    ax.set_ylim(-0.03 * top, top)
    ax.axvspan(0, real[1], color=FORBIDDEN, zorder=0, linewidth=0)
    ax.text(real[1], 0.985 * top, "unstable ", ha="right", va="top", color=INK, style="italic")


def _label_values(ax: Axes, locus: RootLocus, reading: LocusReading, end: complex) -> None:
    """Dots and values along the branch that carries the dominant pair."""
    pair = max(locus.branches, key=lambda branch: _dominance(branch, locus.values, reading.own))
    low, high = ax.get_ylim()
    marked = [end, _along(pair, locus.values, reading.own)]
    written: list[complex] = []
    for value in reading.labels:
        root = _along(pair, locus.values, value)
        inside = np.isfinite(root.real) and low < root.imag < high and ax.get_xlim()[0] < root.real < ax.get_xlim()[1]
        if not inside or root.imag < 0.04 * high or any(abs(root - mark) < 0.05 * high for mark in marked):
            continue
        if any(_near(ax, root, other) for other in written):
            continue
        written.append(root)
        ax.plot(root.real, root.imag, "o", color=EXACT, markersize=3)
        ax.annotate(
            _written(reading, value), (root.real, root.imag), xytext=(6, -2), textcoords="offset points", va="center"
        )


def _near(ax: Axes, root: complex, other: complex) -> bool:
    """Whether texts beside two roots could overlap."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    return abs(root.imag - other.imag) < 0.06 * (high - low) and abs(root.real - other.real) < 0.25 * (right - left)


def _dominance(branch: ComplexArray, values: FloatArray, own: float) -> float:
    root = _along(branch, values, own)
    return root.real if np.isfinite(root.real) and root.imag > 0 else -np.inf


def _written(reading: LocusReading, value: float) -> str:
    return f"{value * reading.scale:.3g}{reading.unit}"

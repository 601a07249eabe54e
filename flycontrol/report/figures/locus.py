"""Root locus in the gain and in the delay: where the exact closed-loop poles go, and where stability ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.delay.locus import AxisCrossing, RootLocus
from flycontrol.delay.system import ComplexArray
from flycontrol.report.style import EXACT, FORBIDDEN, GUIDE_LINE, INK, MARK, in_house_style, new_figure


@dataclass(frozen=True, slots=True, kw_only=True)
class LocusReading:
    """How a locus is read: its own value, which values are written beside it, and how."""

    own: float  #: value of the loop itself, one of those of the locus
    labels: Sequence[float]  #: values of the locus that are written beside the dominant branch
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
    at_own = at_own[np.isfinite(at_own)]
    size = float(np.abs(at_own[np.argmax(at_own.real)])) if len(at_own) else np.nan
    for ax in (near, whole):
        _draw_branches(ax, locus)
        ax.plot(
            at_own.real, at_own.imag, "s", color=EXACT, markersize=5,
            label=f"this loop, {_written(reading, reading.own)}",
        )  # fmt: skip
        ax.set_xlabel("real part [1/s]")
    near.set_ylabel("imaginary part [1/s]")
    _frame(near, (-2.6 * size, 0.75 * size), 2.3 * size)
    _frame(whole, (-8.0 * size, 0.9 * size), 18.0 * size)
    near.set_title("around the dominant poles")
    whole.set_title("further out")
    end = nearest_crossing(locus, reading.own)
    if end is not None:
        text = f"stability ends at {_written(reading, end.value)}"
        near.plot(0, end.frequency, "D", color=MARK, markersize=6, label=text)
    _label_values(near, locus, reading, None if end is None else complex(0, end.frequency))
    near.legend(loc="upper left", handletextpad=0.2, borderaxespad=0.2)
    return figure


def nearest_crossing(locus: RootLocus, own: float) -> AxisCrossing | None:
    """The crossing of the imaginary axis whose value is nearest to `own`, as a ratio; None if there is none."""
    return min(locus.crossings, key=lambda crossing: abs(np.log(crossing.value / own)), default=None)


def _at(locus: RootLocus, value: float) -> ComplexArray:
    """Roots at a value of the locus by branch, NaN where a branch is not; none for a value that it does not hold."""
    there = np.flatnonzero(locus.values == value)
    return locus.branches[:, there[0]] if len(there) else np.full(len(locus.branches), np.nan + 0j)


def _draw_branches(ax: Axes, locus: RootLocus) -> None:
    """Each branch through its collisions, where two roots meet."""
    for number, branch in enumerate(locus.branches):
        met = [collision for collision in locus.collisions if number in collision.branches]
        values = np.append(locus.values, [collision.value for collision in met])
        every = np.append(branch, [complex(collision.root) for collision in met])[np.argsort(values, kind="stable")]
        roots: ComplexArray = every[np.isfinite(every)]
        ax.plot(roots.real, roots.imag, color=EXACT, linewidth=1.2, solid_joinstyle="round")
    ax.axvline(0, **GUIDE_LINE)


def _frame(ax: Axes, real: tuple[float, float], top: float) -> None:
    if not real[0] < real[1]:  # a locus that does not move
        real = (real[0] - 1.0, real[0] + 1.0) if np.isfinite(real[0]) else (-1.0, 1.0)
    top = top if np.isfinite(top) and top > 0 else 1.0
    ax.set_xlim(*real)
    ax.set_ylim(-0.03 * top, top)
    ax.axvspan(0, real[1], color=FORBIDDEN, zorder=0, linewidth=0)
    ax.text(real[1], 0.985 * top, "unstable ", ha="right", va="top", color=INK, style="italic")


def _label_values(ax: Axes, locus: RootLocus, reading: LocusReading, end: complex | None) -> None:
    """Dots and values along the branch that carries the dominant pair."""
    at_own = _at(locus, reading.own)
    dominance = np.where(np.isfinite(at_own) & (at_own.imag > 0), at_own.real, -np.inf)
    pair = int(np.argmax(dominance))
    (left, right), high = ax.get_xlim(), ax.get_ylim()[1]
    marks = [mark for mark in (end, complex(at_own[pair])) if mark is not None and np.isfinite(mark)]
    written: list[complex] = []
    for value in reading.labels:
        root = complex(_at(locus, value)[pair])
        inside = np.isfinite(root.real) and 0.04 * high < root.imag < 0.8 * high and left < root.real < 0.6 * right
        if not inside or any(_touches(ax, root, other, 0.25) for other in written):
            continue
        if any(_touches(ax, root, mark, 0.07) for mark in marks):
            continue
        written.append(root)
        ax.plot(root.real, root.imag, "o", color=EXACT, markersize=3)
        slope = _slope(ax, locus, pair, value)
        flat = abs(slope) < 0.6
        ax.annotate(
            _written(reading, value), (root.real, root.imag), xytext=(0, 6) if flat else (6, 2 if slope < 0 else -5),
            textcoords="offset points", ha="center" if flat else "left",
        )  # fmt: skip


def _slope(ax: Axes, locus: RootLocus, branch: int, value: float) -> float:
    """How steeply a branch rises to the right at a value, in heights of the picture a width."""
    k = int(np.flatnonzero(locus.values == value)[0])
    around = locus.branches[branch, max(k - 1, 0) : k + 2]
    moved = around[-1] - around[0]
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    across = moved.real / (right - left)
    return float(moved.imag / (high - low) / across) if across else np.inf


def _touches(ax: Axes, root: complex, other: complex, reach: float) -> bool:
    """Whether the text right of a root could touch another mark, or its text that reaches so far [widths]."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    beside = (other.real - root.real) / (right - left)
    return abs(root.imag - other.imag) < 0.06 * (high - low) and -reach < beside < 0.25


def _written(reading: LocusReading, value: float) -> str:
    return f"{value * reading.scale:.3g}{reading.unit}"

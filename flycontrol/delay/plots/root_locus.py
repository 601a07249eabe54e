"""Root loci."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.interconnect import feedback
from flycontrol.delay.locus import RootLocus, root_locus
from flycontrol.delay.pade import pade as pade_of
from flycontrol.delay.plots.comparison import Curve, listed, pade_label
from flycontrol.delay.plots.style import BACKED, GUIDE, INK, MARK, legend, line_of, panel, shade_unstable, tell
from flycontrol.delay.system import ComplexArray, DelayLTI
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flycontrol.delay.convert import Operand

_MOST_WRITTEN = 6  # values beside crossings
_REACH = 2.5  # of the picture, in sizes of the rightmost roots
_USUAL = 0.75  # share of the values whose rightmost roots set that size; others may lie far out


def root_locus_map(sysdata: Operand | Callable[[float], Any], gains: ArrayLike, count: int = 8) -> RootLocus:
    """Roots of 1 + k L(s) for gains k, or of any family of systems over its parameter; see `root_locus`.

    Parameters
    ----------
    sysdata
        Open loop L, closed by negative feedback, or a function from a parameter to the closed system.
    gains
        Rising or falling values of the gain or parameter.
    """
    return root_locus(_family(sysdata), gains, count)


def root_locus_plot(  # noqa: PLR0913 (python-control's arguments)
    data: Any,
    gains: ArrayLike | None = None,
    *,
    count: int = 8,
    ax: Axes | None = None,
    pade: int | None = None,
    approximation: RootLocus | None = None,
    parameter: str = "",
    unit: str = "",
    title: str | None = None,
) -> Axes:
    """Branches of roots [1/s] over a parameter, the lower half plane thin, with their crossings and collisions.

    The picture shows the surroundings of the rightmost roots, and says how many branches lie outside.

    Parameters
    ----------
    data
        Open loop or family as in `root_locus_map`, with `gains`; or a `RootLocus`.
    pade
        Order n of the Padé approximation [n/n] of every member, drawn beside.
    approximation
        Another `RootLocus` drawn beside.
    parameter, unit
        Name and unit of the parameter, written at crossings.

    Raises
    ------
    InvalidParameterError
        If gains are missing, or the family refuses a value.
    """
    exact, others = _loci(data, gains, count, pade, approximation)
    ax = panel(ax, (6.0, 5.0))
    ax.axhline(0.0, **GUIDE)
    for label, locus in [("exact" if others else "", exact), *others]:
        curve = Curve(locus, label, exact=locus is exact, series=0, alone=True)
        _draw(ax, curve)
    _mark(ax, exact, f"{parameter} = " if parameter else "", f" {unit}" if unit else "")
    _frame(ax, exact)
    shade_unstable(ax)
    _tell_of_the_rest(ax, exact)
    ax.set_xlabel("real part [1/s]")
    ax.set_ylabel("imaginary part [rad/s]")
    legend(ax, loc="best")
    tell(ax, title)
    return ax


def _family(sysdata: Any) -> Callable[[float], DelayLTI]:
    if callable(sysdata) and not isinstance(sysdata, DelayLTI) and not hasattr(sysdata, "ninputs"):
        return lambda value: as_delay_lti(sysdata(value))
    loop = as_delay_lti(sysdata)
    return lambda value: feedback(float(value) * loop)


def _loci(
    data: Any, gains: ArrayLike | None, count: int, order: int | None, given: RootLocus | None
) -> tuple[RootLocus, list[tuple[str, RootLocus]]]:
    """The exact locus, and its approximations by name."""
    if len(listed(data)) > 1:
        raise InvalidParameterError("A root locus is drawn one at a time; call root_locus_plot again on the same ax.")
    source = listed(data)[0]
    others = [] if given is None else [("approximation", given)]
    if isinstance(source, RootLocus):
        if order is not None:
            raise InvalidParameterError(
                "A RootLocus holds no system that could be approximated: plot the loop itself with `gains`, or give "
                "the approximate locus as `approximation`."
            )
        return source, others
    if gains is None:
        raise InvalidParameterError("A root locus needs the gains at which roots are followed, rising or falling.")
    family = _family(source)
    if order is not None:
        near = root_locus(lambda value: pade_of(family(value), order), gains, count)
        others = [(pade_label(order), near), *others]
    return root_locus(family, gains, count), others


def _draw(ax: Axes, curve: Curve[RootLocus]) -> None:
    style, label = line_of(curve), curve.label or None
    thin: dict[str, Any] = {**style, "linewidth": 0.7}
    for branch in range(len(curve.result.branches)):
        path = path_of(curve.result, branch)
        ax.plot(path.real, path.imag, **style, label=label)
        ax.plot(path.real, -path.imag, **thin)
        label = None  # one entry in the legend


def path_of(locus: RootLocus, branch: int) -> ComplexArray:
    """Points of a branch by rising parameter, through the crossings and collisions that lie on it."""
    known = np.isfinite(locus.branches[branch])
    points = list(zip(locus.values[known].tolist(), locus.branches[branch, known].tolist(), strict=True))
    points += [(c.value, 1j * c.frequency) for c in locus.crossings if c.branch == branch]
    points += [(c.value, complex(c.root)) for c in locus.collisions if branch in c.branches]
    return np.array([root for _, root in sorted(points, key=lambda point: point[0])], dtype=np.complex128)


def _mark(ax: Axes, locus: RootLocus, before: str, after: str) -> None:
    """Start, crossings of the axis with their values, collisions."""
    first = locus.branches[:, 0]
    both = np.concatenate([first, first.conj()])
    start = f"{before}{locus.values[0]:.4g}{after}"
    ax.plot(both.real, both.imag, "x", color=INK, markersize=6, markeredgewidth=1.5, linestyle="none", label=start)
    if locus.crossings:
        omega = np.array([c.frequency for c in locus.crossings])
        both = np.concatenate([omega, -omega[omega > 0]])
        ax.plot(0.0 * both, both, "o", color=MARK, markersize=6, linestyle="none", zorder=4, label="crosses the axis")
        for c in locus.crossings[:_MOST_WRITTEN]:
            text = f"{before}{c.value:.4g}{after}, {c.frequency:.3g} rad/s"
            ax.annotate(
                text, (0.0, c.frequency), xytext=(7, 4), textcoords="offset points", color=MARK,
                fontsize="small", bbox=BACKED,
            )  # fmt: skip
    if locus.collisions:
        roots = np.array([c.root for c in locus.collisions])
        ax.plot(roots, 0.0 * roots, "D", color=MARK, markersize=6, markerfacecolor="white", linestyle="none", zorder=4,
                label="double root")  # fmt: skip


def _frame(ax: Axes, locus: RootLocus) -> None:
    """Show the surroundings of the rightmost roots, of all crossings and of collisions nearby; the rest is cut off."""
    present = np.isfinite(locus.branches).any(axis=0)
    known = locus.branches[:, present]
    dominant = known[np.nanargmax(known.real, axis=0), np.arange(known.shape[1])]
    frequencies = [crossing.frequency for crossing in locus.crossings]
    size = max([float(np.quantile(np.abs(dominant), _USUAL)), *frequencies, 1e-12])
    meetings = [c.root for c in locus.collisions if abs(c.root) <= 2.0 * _REACH * size]
    roots = known[np.isfinite(known)]
    roots = roots[roots.imag <= _REACH * size]
    left = min([max(float(roots.real.min()), -_REACH * size), *(1.1 * c for c in meetings)])
    right = max(min(float(roots.real.max()), _REACH * size), -0.05 * left, 0.0)
    within = roots[(roots.real >= left) & (roots.real <= right) & (roots.imag <= _REACH * size)]
    height = max(float(within.imag.max(initial=0.0)), 0.3 * (right - left), *frequencies, 0.0)
    width = right - left
    # room for what is written at crossings
    ax.set_xlim(left - 0.05 * width, right + (0.4 if locus.crossings else 0.1) * width)
    ax.set_ylim(-1.12 * height, 1.12 * height)


def _tell_of_the_rest(ax: Axes, locus: RootLocus) -> None:
    """Say how many branches the picture does not show."""
    (left, right), (_, high) = ax.get_xlim(), ax.get_ylim()
    shown = (locus.branches.real >= left) & (locus.branches.real <= right) & (locus.branches.imag <= high)
    hidden = int((~shown.any(axis=1)).sum())
    if hidden:
        words = f"{hidden} of {len(shown)} branches lie outside this picture"
        ax.text(0.01, 0.01, words, transform=ax.transAxes, va="bottom", fontsize="small", color=INK, bbox=BACKED)

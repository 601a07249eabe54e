"""Nyquist curves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from flycontrol.delay.nyquist import NyquistResponse, nyquist_response
from flycontrol.delay.plots.comparison import Beside, Curve, curves
from flycontrol.delay.plots.style import BACKED, GUIDE, INK, MARK, QUIET, legend, line_of, panel, tell
from flycontrol.delay.system import ComplexArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_FARTHEST = 5.0  # |L| up to which curves decide what is shown
_TALLEST = 0.75  # half height over width of a picture that is cut off: with an integrator it would be a strip


def nyquist_plot(  # noqa: PLR0913 (python-control's arguments)
    data: Any,
    *,
    ax: Axes | None = None,
    pade: int | None = None,
    approximation: Any = None,
    label: str | Sequence[str] | None = None,
    title: str | None = None,
    unit_circle: bool = False,
) -> Axes:
    """L(s) along Nyquist's contour: upwards solid, its mirror image thin, around poles on the imaginary axis dotted.

    The title counts the encirclements of -1, the poles P of L right of the contour and the unstable poles of the closed
    loop, Z = clockwise encirclements + P. Around -1 lies the disk of the modulus margin, if the loop is stable. What
    goes farther out than the picture is cut off, and said.

    Parameters
    ----------
    data
        Open loop or `NyquistResponse`, or a list of these.
    pade
        Order n of the Padé approximation [n/n] drawn beside each loop.
    approximation
        System or `NyquistResponse` drawn beside, one for each in `data`.
    label
        Of each in `data`.
    unit_circle
        Whether |L| = 1 is drawn.

    Raises
    ------
    InvalidParameterError
        If a loop has more than one input or output, or arguments do not fit each other.
    """
    beside = Beside(pade=pade, approximation=approximation, label=label)
    shown = curves(data, NyquistResponse, nyquist_response, beside)
    ax = panel(ax, (7.2, 5.2))
    ax.axhline(0.0, **GUIDE)
    ax.axvline(0.0, **GUIDE)
    for curve in shown:
        _draw(ax, curve, name_detour=curve is shown[0])
    _mark_minus_one(ax, [curve for curve in shown if curve.exact])
    if unit_circle:
        from matplotlib.patches import Circle

        ax.add_patch(Circle((0.0, 0.0), 1.0, fill=False, edgecolor=QUIET, linewidth=0.8, label="|L| = 1"))
    ax.set_aspect("equal", adjustable="datalim" if ax.get_subplotspec() is None else "box")
    _frame(ax, shown)
    ax.set_xlabel("real part of L [1]")
    ax.set_ylabel("imaginary part of L [1]")
    legend(ax, loc="upper left", bbox_to_anchor=(1.01, 1.0))
    tell(ax, title, "\n".join(_said(curve) for curve in shown))
    return ax


def _draw(ax: Axes, curve: Curve[NyquistResponse], *, name_detour: bool) -> None:
    """The curve upwards, its mirror image, and the way around poles on the axis."""
    style, L = line_of(curve), curve.result.response
    on_axis = _on_axis(curve.result)
    thin: dict[str, Any] = {**style, "linewidth": 0.7}
    along: ComplexArray = np.where(on_axis, L, np.nan)
    ax.plot(along.real, along.imag, **style, label=curve.label or None)
    ax.plot(along.real, -along.imag, **thin)
    # a stretch beside the axis takes its first and last point from the axis
    around: ComplexArray = np.where(~on_axis | ~np.roll(on_axis, 1) | ~np.roll(on_axis, -1), L, np.nan)
    dotted: dict[str, Any] = {**style, "linewidth": 1.0, "linestyle": (0, (1, 1.5))}
    if not on_axis.all():
        several = "poles" if len(curve.result.axis_poles) > 1 else "the pole"
        ax.plot(around.real, around.imag, **dotted, label=f"around {several} on the axis" if name_detour else None)
        ax.plot(around.real, -around.imag, **dotted)
    if curve.exact:
        _arrow(ax, along, style["color"])


def _on_axis(response: NyquistResponse) -> Any:
    s = response.contour
    return np.abs(s.real) <= 1e-12 * np.abs(s)


def _arrow(ax: Axes, along: ComplexArray, colour: str) -> None:
    """Direction of rising frequency, where the curve enters the unit circle or, within it, halfway."""
    size = np.abs(along)
    inward = np.flatnonzero((size[:-1] > 1.0) & (size[1:] <= 1.0))
    k = int(inward[0]) if len(inward) else len(along) // 2
    k = max(1, min(k, len(along) - 2))
    a, b = along[k], along[k + 1]
    if np.isfinite(a) and np.isfinite(b) and a != b:
        arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.2, "mutation_scale": 13}
        ax.annotate("", (b.real, b.imag), xytext=(a.real, a.imag), arrowprops=arrow)


def _mark_minus_one(ax: Axes, exact: list[Curve[NyquistResponse]]) -> None:
    from matplotlib.patches import Circle

    ax.plot(-1.0, 0.0, marker="+", color=MARK, markersize=11, markeredgewidth=1.8, linestyle="none", zorder=4)
    ax.annotate("−1", (-1.0, 0.0), xytext=(-7, -5), textcoords="offset points", color=INK, ha="right", va="top")
    if len(exact) == 1 and exact[0].result.closed_loop_unstable == 0:
        radius = modulus_of(exact[0].result)
        name = f"modulus margin {radius:.2f}"
        ax.add_patch(Circle((-1.0, 0.0), radius, facecolor=MARK, edgecolor="none", alpha=0.15, zorder=0.8))
        ax.add_patch(Circle((-1.0, 0.0), radius, fill=False, edgecolor=MARK, linewidth=1.0, zorder=0.8, label=name))


def modulus_of(response: NyquistResponse) -> float:
    """Distance of -1 from the drawn curve on the imaginary axis: from the chords between its points."""
    points = response.response[_on_axis(response)]
    start, chord = points[:-1], np.diff(points)
    size = np.maximum(np.abs(chord) ** 2, 1e-300)
    share = np.clip(((-1.0 - start) * chord.conj()).real / size, 0.0, 1.0)
    return float(np.abs(start + share * chord + 1.0).min())


def _frame(ax: Axes, shown: list[Curve[NyquistResponse]]) -> None:
    """Show what is near -1 and the origin, and say how far out the curve goes where it is cut off."""
    points = np.concatenate([curve.result.response for curve in shown])
    near = points[np.abs(points) <= _FARTHEST]
    farthest = float(np.abs(points).max())
    reach = _FARTHEST if farthest > _FARTHEST else farthest
    left, right = min(-1.6, near.real.min(initial=0.0)), max(0.6, near.real.max(initial=0.0))
    height = max(1.0, np.abs(near.imag).max(initial=0.0))
    if farthest > _FARTHEST:
        height = min(height, max(1.2, _TALLEST * (right - left)))
    ax.set_xlim(left - 0.05 * reach, right + 0.05 * reach)
    ax.set_ylim(-1.05 * height, 1.05 * height)
    if farthest > _FARTHEST:
        text = f"goes out to |L| = {farthest:.3g}"
        ax.text(
            0.99, 0.01, text, transform=ax.transAxes, ha="right", va="bottom", fontsize="small", color=INK, bbox=BACKED
        )  # fmt: skip


def _said(curve: Curve[NyquistResponse]) -> str:
    found = curve.result
    name = f"{curve.label}: " if curve.label else ""
    if found.count is None:
        return f"{name}no count of encirclements: {found.status}"
    times = f"{abs(found.count)} time{'s' if abs(found.count) != 1 else ''}"
    direction = " clockwise" if found.count > 0 else " counter-clockwise" if found.count < 0 else ""
    return f"{name}−1 encircled {times}{direction}, P = {found.open_loop_unstable}, Z = {found.closed_loop_unstable}"

"""Lines, colours and axes of the plots: exact solid, approximate dashed, lightness apart so that greyscale will do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flycontrol.delay.plots.comparison import Curve

#: An array of axes, its shape that of the panels.
AxesArray = NDArray[Any]

INK = "#1a1a1a"
QUIET = "#7d7d7d"
MARK = "#c8323c"
APPROXIMATE = "#e08a00"
UNSTABLE = "#efebe6"  #: the half plane of unstable roots
SERIES = ("#0b3954", "#e08a00", "#7a4f9a", "#5aa7d6", "#9a9a9a")  #: of several systems
DASHES = (0, (4, 2))
BACKED: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5}  #: behind a text
GUIDE: dict[str, Any] = {"color": QUIET, "linewidth": 0.7, "linestyle": (0, (1, 2)), "zorder": 0.5}


def line_of(curve: Curve[Any]) -> dict[str, Any]:
    """Colour, width and dashes of a curve: the approximation of one system alone is orange, else as its system.

    Of several systems the later are drawn thinner, so that a curve that covers another leaves its rim visible.
    """
    colour = APPROXIMATE if not curve.exact and curve.alone else SERIES[curve.series % len(SERIES)]
    width = 1.6 if curve.alone else max(1.0, 2.6 - 0.8 * curve.series)
    style: dict[str, Any] = {"color": colour, "linewidth": width, "zorder": 2.0}
    return style if curve.exact else {**style, "linestyle": DASHES, "zorder": 2.5}


def panels(
    ax: Axes | AxesArray | None, rows: int, columns: int, size: tuple[float, float], sharex: Any = False
) -> AxesArray:
    """The given axes in the shape (rows, columns), or those of a new figure of a size [inch].

    Raises
    ------
    InvalidParameterError
        If there are more or fewer axes given than panels.
    """
    if ax is None:
        import matplotlib.pyplot as plt

        _, made = plt.subplots(rows, columns, figsize=size, sharex=sharex, squeeze=False, layout="constrained")
        return made
    given = np.atleast_1d(np.array(ax, dtype=object))
    if given.size != rows * columns:
        raise InvalidParameterError(
            f"This plot has {rows} x {columns} panels and needs as many axes in `ax`, got {given.size}; make them with "
            f"plt.subplots({rows}, {columns}) or leave `ax` out."
        )
    return given.reshape(rows, columns)


def panel(ax: Axes | None, size: tuple[float, float] = (6.4, 4.4)) -> Axes:
    """The one axis given, or that of a new figure of a size [inch]."""
    return panels(ax, 1, 1, size)[0, 0]


def shade_unstable(ax: Axes) -> None:
    """Tint the half plane Re s > 0 as far as the axes reach, the imaginary axis as its border."""
    ax.axvline(0.0, color=QUIET, linewidth=0.9, zorder=0.6)
    left, right = ax.get_xlim()
    if right > 0:
        ax.axvspan(max(left, 0.0), right, color=UNSTABLE, linewidth=0, zorder=0.1)
        ax.text(1.0, 0.01, "unstable ", transform=ax.transAxes, ha="right", va="bottom", fontsize="small",
                style="italic", color=INK)  # fmt: skip
    ax.set_xlim(left, right)


def legend(ax: Axes, **where: Any) -> None:
    """A legend, if anything has a label."""
    if ax.get_legend_handles_labels()[1]:
        ax.legend(frameon=True, framealpha=0.85, edgecolor="none", fontsize="small", **where)


def tell(ax: Axes, title: str | None, default: str = "") -> None:
    """The title asked for ("" for none), or what the plot says by itself."""
    text = default if title is None else title
    if text:
        ax.set_title(text, fontsize="medium")

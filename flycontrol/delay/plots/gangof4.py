"""The four sensitivity functions of a loop."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.plots.comparison import Beside
from flycontrol.delay.plots.frequencies import frequency_curves
from flycontrol.delay.plots.style import GUIDE, AxesArray, legend, line_of, panels
from flycontrol.delay.sensitivity import GangOfFour, gangof4
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

_PLACES = (
    ("T", "T = PC / (1 + PC)"),
    ("PS", "PS = P / (1 + PC)"),
    ("CS", "CS = C / (1 + PC)"),
    ("S", "S = 1 / (1 + PC)"),
)


def gangof4_plot(  # noqa: PLR0913 (python-control's arguments)
    P: Operand | GangOfFour,
    C: Operand | None = None,
    *,
    omega: ArrayLike | None = None,
    omega_limits: Sequence[float] | None = None,
    ax: AxesArray | None = None,
    pade: int | None = None,
    approximation: GangOfFour | None = None,
) -> AxesArray:
    """Magnitudes [dB] of T, PS, CS and S against w [rad/s].

    Parameters
    ----------
    P, C
        Plant and controller under negative feedback, or the `GangOfFour` alone.
    approximation
        Another `GangOfFour` drawn beside.

    The others, and errors, as in `bode_plot`.

    Returns
    -------
    The axes [[T, PS], [CS, S]], shape (2, 2).
    """
    four = _four(P, C)
    places = panels(ax, 2, 2, (7.6, 5.4), sharex=True)
    for panel, (name, title) in zip(places.flat, _PLACES, strict=True):
        other = None if approximation is None else getattr(approximation, name)
        beside = Beside(pade=pade, approximation=other, label=None)
        for curve in frequency_curves(getattr(four, name), omega, omega_limits, beside):
            panel.semilogx(curve.result.omega, curve.result.decibels, **line_of(curve), label=curve.label or None)
        if panel.get_ylim()[0] < 0.0 < panel.get_ylim()[1]:
            panel.axhline(0.0, **GUIDE)
        panel.set_title(title, fontsize="medium")
    for panel in places[:, 0]:
        panel.set_ylabel("magnitude [dB]")
    for panel in places[1]:
        panel.set_xlabel("angular frequency [rad/s]")
    legend(places[0, 0])
    return np.array(places)


def _four(P: Operand | GangOfFour, C: Operand | None) -> GangOfFour:
    if isinstance(P, GangOfFour):
        if C is not None:
            raise InvalidParameterError("A GangOfFour holds its controller already; leave C out.")
        return P
    if C is None:
        raise InvalidParameterError("The gang of four needs a plant and a controller; give C, or a GangOfFour.")
    return gangof4(P, C)

"""Bode diagrams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.frequency import FrequencyResponse
from flycontrol.delay.margins import margins
from flycontrol.delay.plots.comparison import Beside, Curve
from flycontrol.delay.plots.frequencies import frequency_curves
from flycontrol.delay.plots.style import GUIDE, MARK, AxesArray, legend, line_of, panels, tell
from flycontrol.delay.system import FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_STEPS = np.array([15.0, 30.0, 45.0, 90.0, 180.0, 360.0, 720.0, 1440.0, 3600.0])  # between ticks of phase [deg]


def bode_plot(  # noqa: PLR0913 (python-control's arguments)
    data: Any,
    omega: ArrayLike | None = None,
    *,
    ax: AxesArray | None = None,
    omega_limits: Sequence[float] | None = None,
    pade: int | None = None,
    approximation: Any = None,
    label: str | Sequence[str] | None = None,
    title: str | None = None,
    display_margins: bool = False,
) -> AxesArray:
    """20 log10 |G(jw)| [dB] over arg G(jw) [deg], against w [rad/s].

    Parameters
    ----------
    data
        System or `FrequencyResponse`, or a list of these.
    omega
        Frequencies [rad/s], rising; when left out they follow the turns of each response.
    ax
        Two axes, for magnitude and phase.
    omega_limits
        Lowest and highest frequency [rad/s].
    pade
        Order n of the Padé approximation [n/n] drawn beside each system.
    approximation
        System or `FrequencyResponse` drawn beside, one for each in `data`.
    label
        Of each in `data`.
    display_margins
        Mark gain and phase crossovers, and say the margins in the title; for one system.

    Returns
    -------
    The axes of magnitude and phase, shape (2,).

    Raises
    ------
    InvalidParameterError
        If a system has more than one input or output, or arguments do not fit each other.
    """
    shown = frequency_curves(data, omega, omega_limits, Beside(pade=pade, approximation=approximation, label=label))
    upper, lower = panels(ax, 2, 1, (6.4, 5.2), sharex=True)[:, 0]
    for curve in shown:
        upper.semilogx(curve.result.omega, curve.result.decibels, **line_of(curve), label=curve.label or None)
        lower.semilogx(curve.result.omega, np.degrees(curve.result.phase), **line_of(curve))
    upper.axhline(0.0, **GUIDE)
    lower.axhline(-180.0, **GUIDE)
    lower.set_xlim(shown[0].result.omega[0], shown[0].result.omega[-1])
    upper.set_ylabel("magnitude [dB]")
    lower.set_ylabel("phase [deg]")
    lower.set_xlabel("angular frequency [rad/s]")
    phase_ticks(lower)
    legend(upper)
    tell(upper, title, _with_margins(upper, lower, shown) if display_margins else "")
    return np.array([upper, lower])


def phase_ticks(ax: Axes, which: str = "y") -> None:
    """Ticks of an axis in degrees at parts or multiples of a right angle."""
    from matplotlib.ticker import MultipleLocator

    low, high = ax.get_ylim() if which == "y" else ax.get_xlim()
    step = _STEPS[min(int(np.searchsorted(_STEPS, (high - low) / 7.0)), len(_STEPS) - 1)]
    (ax.yaxis if which == "y" else ax.xaxis).set_major_locator(MultipleLocator(step))


def _with_margins(upper: Axes, lower: Axes, shown: list[Curve[FrequencyResponse]]) -> str:
    """Mark the crossovers that limit gain and phase, and say the margins."""
    system = shown[0].system
    if system is None or sum(curve.exact for curve in shown) > 1:
        raise InvalidParameterError("Margins are displayed for one system, given as such and not as its response.")
    found = margins(system)
    for panel, places in ((lower, found.gain_crossovers), (upper, found.phase_crossovers)):
        _mark(panel, (upper, lower), shown[0].result, places)
    return (
        f"gain margin {20 * np.log10(found.gain_margin):.3g} dB, phase margin {np.degrees(found.phase_margin):.3g}°, "
        f"delay margin {found.delay_margin:.3g} s"
    )


def _mark(panel: Axes, both: tuple[Axes, Axes], response: FrequencyResponse, places: FloatArray) -> None:
    """The crossover from which least is missing to -1, and how much: dB above or degrees beside an odd half turn."""
    inside = places[(places >= response.omega[0]) & (places <= response.omega[-1])]
    if not len(inside):
        return
    values = response.decibels if panel is both[0] else np.degrees(response.phase)
    heights = np.interp(np.log(inside), np.log(response.omega), values)
    bases = np.zeros_like(heights) if panel is both[0] else 360.0 * np.round((heights - 180.0) / 360.0) + 180.0
    k = int(np.abs(heights - bases).argmin())
    for ax in both:
        ax.axvline(inside[k], **GUIDE)
    panel.plot([inside[k], inside[k]], [bases[k], heights[k]], color=MARK, linewidth=2.2, solid_capstyle="butt")

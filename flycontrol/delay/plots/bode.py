"""Bode diagrams."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.frequency import FrequencyResponse
from flycontrol.delay.margins import margins
from flycontrol.delay.plots.comparison import Beside, Curve
from flycontrol.delay.plots.frequencies import frequencies_shown, frequency_curves
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
        Mark the crossovers of the gain and the phase margin, and say the margins in the title, and whether the closed
        loop is unstable; for one system.

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
    lower.set_xlim(*frequencies_shown([curve.result for curve in shown], asked=omega is not None or omega_limits))
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
    """Mark the crossovers of the gain and the phase margin, and say the margins."""
    system = shown[0].system
    if system is None or sum(curve.exact for curve in shown) > 1:
        raise InvalidParameterError("Margins are displayed for one system, given as such and not as its response.")
    found = margins(system)
    response = shown[0].result
    gain, phase = _seen(response, found.gain_crossovers), _seen(response, found.phase_crossovers)
    if len(gain.omega):
        lags = (gain.phase + 180.0) % 360.0
        k = int(lags.argmin())
        _mark(lower, (upper, lower), float(gain.omega[k]), (float(gain.phase[k] - lags[k]), float(gain.phase[k])))
    if (phase.decibels < 0).any():
        k = int(np.where(phase.decibels < 0, phase.decibels, -np.inf).argmax())
        _mark(upper, (upper, lower), float(phase.omega[k]), (0.0, float(phase.decibels[k])))
    warning = "" if found.stable else f"{found.status}\n"
    return (
        f"{warning}gain margin {20 * np.log10(found.gain_margin):.3g} dB, phase margin "
        f"{np.degrees(found.phase_margin):.3g}°, delay margin {found.delay_margin:.3g} s"
    )


class _Seen(NamedTuple):
    """A response at crossovers within its range."""

    omega: FloatArray  #: [rad/s]
    decibels: FloatArray
    phase: FloatArray  #: [deg]


def _seen(response: FrequencyResponse, places: FloatArray) -> _Seen:
    omega = places[(places >= response.omega[0]) & (places <= response.omega[-1])]
    grid = np.log(response.omega)
    decibels, phase = (np.interp(np.log(omega), grid, y) for y in (response.decibels, np.degrees(response.phase)))
    return _Seen(omega, decibels, phase)


def _mark(panel: Axes, both: tuple[Axes, Axes], omega: float, ends: tuple[float, float]) -> None:
    """A crossover, and what is missing there to -1: dB above or degrees beside an odd half turn."""
    for ax in both:
        ax.axvline(omega, **GUIDE)
    panel.plot([omega, omega], ends, color=MARK, linewidth=2.2, solid_capstyle="butt")

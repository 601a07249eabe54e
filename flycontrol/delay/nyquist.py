"""Nyquist's criterion for a loop with delays and poles on the imaginary axis, by a count of encirclements."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from flycontrol.delay.asymptote import Asymptote
from flycontrol.delay.frequency import require_siso
from flycontrol.delay.frequency_domain import FrequencyDomain, frequency_domain
from flycontrol.delay.kernels import bernstein
from flycontrol.delay.open_loop import AxisPole
from flycontrol.delay.panels import Panels, bernstein_matrix, joined, panels_along
from flycontrol.delay.system import ComplexArray
from flycontrol.errors import InvalidParameterError, NeutralSystemError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flycontrol.delay.convert import Operand

_SHRINKINGS = 40
_PER_PANEL = 8  # points of the curve


@dataclass(frozen=True, slots=True, eq=False)
class NyquistResponse:
    """L along the upper half of Nyquist's contour, and how often the whole of it goes around -1.

    Closed-loop unstable poles = clockwise encirclements + open-loop unstable poles.
    """

    count: int | None  #: clockwise encirclements of -1 by the whole curve; None with the reason in `status`
    open_loop_unstable: int  #: poles of L right of the contour, which passes poles on the axis on their right
    closed_loop_unstable: int | None  #: poles with Re s > 0 under negative unit feedback
    axis_poles: tuple[AxisPole, ...]  #: where the contour is indented
    contour: ComplexArray  #: s, from the real axis upwards [1/s], shape (k,)
    response: ComplexArray  #: L(s), shape (k,)
    status: str  #: "certified", or why there is no count

    def plot(self, **options: Any) -> Axes:
        """Draw it; options and return value as in `nyquist_plot`."""
        from flycontrol.delay.plots import nyquist_plot

        return nyquist_plot(self, **options)


def nyquist_response(loop: Operand) -> NyquistResponse:
    """Nyquist's contour of a loop with one input and one output, closed by negative unit feedback.

    The contour runs up the imaginary axis and passes each pole on it by two straight lines on its right. On its panels
    L is a polynomial with a proven error; halved until all control points lie in a half plane seen from -1, it turns
    around -1 by principal values. The contour ends where a bound keeps L nearer to its limit than -1 is: from there
    to infinity, 1 + L turns by a principal value.

    Raises
    ------
    InvalidParameterError
        If the loop has more than one input or output, or its direct path is -1.
    NeutralSystemError
        If its direct path through delays has so much gain that closing it makes a neutral system.
    """
    it = frequency_domain(loop)
    require_siso(it.system)
    on_axis = it.poles.on_axis
    radii = [_indentation(it, pole) for pole in on_axis]
    shown = [radius or 1e-6 * it.slowest_rate() for radius in radii]
    corners = _contour(on_axis, shown, it.far.beyond(0.9 * _room(it.far)))
    pieces = joined([panels_along(it.blocks, a, b, first=0.1 * abs(a) or None) for a, b in pairwise(corners)])
    count = _encirclements(pieces, float(it.far.undelayed[0, 0]))
    status = "certified" if count is not None else "the curve meets -1: a closed-loop pole lies on the contour"
    if None in radii:
        count, status = None, "a pole on the imaginary axis is hidden from L, or a zero lies next to it"
    unstable = it.poles.unstable
    contour, response = _sampled(joined([pieces, *_onward(it, corners[-1].imag)]))
    return NyquistResponse(
        count=count,
        open_loop_unstable=unstable,
        closed_loop_unstable=None if count is None else count + unstable,
        axis_poles=tuple(on_axis),
        contour=contour,
        response=response,
        status=status,
    )


def _room(far: Asymptote) -> float:
    """How near L may come to its undelayed limit without being as far from it as -1 is."""
    direct, delayed = float(far.undelayed[0, 0]), float(far.delayed[0, 0])
    if direct == -1:
        raise InvalidParameterError(
            "The loop's direct path is -1: closing it has no solution; put a lag into the loop."
        )
    if delayed >= abs(1.0 + direct):
        raise NeutralSystemError(
            f"The loop's direct path through delays has a gain of up to {delayed:.3g}, so L surrounds -1 at all high "
            "frequencies: closing it makes a neutral system. Put a lag into that path."
        )
    return abs(1.0 + direct) - delayed


def _indentation(it: FrequencyDomain, pole: AxisPole) -> float | None:
    """Half the diagonal of a diamond around a pole that holds no closed-loop pole [1/s]; None if none is found.

    On the diamond |L| > 1, so that by Rouche's theorem L and 1 + L have equally many zeros in it: none, if L turns
    around 0 as often as there are poles in the diamond.
    """
    centre = 1j * pole.frequency
    near = [pole.frequency] if pole.frequency else []
    radius = 0.2 * min([it.far.beyond(1.0), *np.abs(it.poles.others - centre), *near])
    for _ in range(_SHRINKINGS):
        if radius < 10.0 * pole.spread + 1e-13 * pole.frequency:
            return None
        if it.poles.alone(pole, radius) and _turns_alone(it, centre, radius) == -pole.multiplicity:
            return radius
        radius /= 4.0
    return None


def _turns_alone(it: FrequencyDomain, centre: complex, radius: float) -> int | None:
    """Turns of L around 0 on a diamond, counter-clockwise; None unless |L| > 1 all along."""
    corners = [centre + radius * corner for corner in (-1j, 1.0, 1j, -1.0, -1j)]
    pieces = joined([panels_along(it.blocks, a, b) for a, b in pairwise(corners)])
    series = pieces.entry
    square = bernstein.squared(series)
    least, _, _ = bernstein.smallest(square @ bernstein_matrix(square.shape[1] - 1).T, 1e-3)
    turn = bernstein.turn(series @ bernstein_matrix(series.shape[1] - 1).T, pieces.error).sum() / (2 * np.pi)
    return round(turn) if least > 1.1 and abs(turn - np.round(turn)) < 1e-6 else None


def _contour(on_it: list[AxisPole], radii: list[float], top: float) -> list[complex]:
    """Corners of the upper half of the contour, from the real axis up."""
    corners: list[complex] = [0j]
    for pole, radius in zip(on_it, radii, strict=True):
        around = [1j * pole.frequency + radius * corner for corner in (-1j, 1.0, 1j)]
        corners = around[1:] if pole.frequency == 0 else corners + around
    return [*corners, 1j * top]


def _encirclements(pieces: Panels, direct: float) -> int | None:
    """Clockwise turns of 1 + L along the contour and its mirror image; None if it passes through 0."""
    series = pieces.entry.copy()
    series[:, 0] += 1.0
    points = series @ bernstein_matrix(series.shape[1] - 1).T
    along = bernstein.turn(points, pieces.error).sum()
    beyond = -np.angle(points[-1, -1] / (1.0 + direct))
    halves = -(along + beyond) / np.pi
    return round(halves) if abs(halves - np.round(halves)) < 1e-6 else None


def _onward(it: FrequencyDomain, top: float) -> list[Panels]:
    """Panels beyond the end of what a count needs [rad/s], so that the curve is seen to come to its limit."""
    end = min(it.far.beyond(0.05), 50.0 * top)
    return [it.panels(top, end)] if end > top and it.affordable(end) else []


def _sampled(pieces: Panels) -> tuple[ComplexArray, ComplexArray]:
    """Points of the contour and of the curve, in order."""
    u = np.linspace(-1.0, 1.0, _PER_PANEL, endpoint=False)
    powers = u[:, None] ** np.arange(pieces.series.shape[1])
    s = pieces.centre[:, None] + pieces.half[:, None] * u
    return s.ravel(), (pieces.entry @ powers.T).ravel()

"""The largest gain of a system over all frequencies, between a lower and an upper bound."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import fminbound

from flycontrol.delay.frequency_domain import FrequencyDomain, frequency_domain
from flycontrol.delay.kernels import bernstein
from flycontrol.delay.panels import Panels, bernstein_matrix, joined
from flycontrol.delay.real import real_number
from flycontrol.errors import InvalidParameterError, UnstableSystemError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

_MOST_CHANNELS = 8  # whose signs are tried for the gain at infinite frequency


@dataclass(frozen=True, slots=True, kw_only=True)
class PeakGain:
    """The largest singular value of G(j w) over w."""

    lower: float  #: attained at `frequency`
    upper: float  #: never exceeded
    frequency: float  #: [rad/s]; inf if only approached
    status: str  #: "certified" when the bounds agree to the tolerance, or what keeps them apart


def linfnorm(system: Operand, tol: float = 1e-6, floor: float = 0.0) -> PeakGain:
    """Peak gain of a system without poles on the imaginary axis, stable or not.

    On panels of the frequency axis G is a polynomial with a proven error, and no gain exceeds the largest of its
    control points; panels are halved until none exceeds the largest gain found by more than `tol`, relative. Beyond
    the last panel a norm bound does it. With a `floor`, gains are told apart down to it only.

    Raises
    ------
    InvalidParameterError
        If the tolerance is not in [1e-10, 1).
    UnstableSystemError
        If the system has a pole on the imaginary axis.
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    tol = real_number(tol, "The tolerance of a norm")
    if not 1e-10 <= tol < 1:
        raise InvalidParameterError(f"The tolerance of a norm must lie in [1e-10, 1), got {tol!r}.")
    it = frequency_domain(system)
    if it.poles.on_axis:
        raise UnstableSystemError(
            f"The system has a pole on the imaginary axis, at {it.poles.on_axis[0].frequency:.4g} rad/s: its gain "
            "there is infinite; close a loop around it first."
        )
    sure, possible = _gain_at_infinity(it)
    top = _first_end(it)
    pieces = it.panels(0.0, top, 1e-3 * floor)
    gains = np.linalg.norm(pieces.series[:, 0], 2, axis=(1, 2)) - pieces.error
    known = max(sure, float(gains.max()))
    level = max((1 + tol) * known - possible, 0.5 * tol * known, 0.5 * floor, 1e-300)
    if it.far.rest(top) > level:
        low, top = top, it.affordable_top(it.far.beyond(level))
        pieces = joined([pieces, it.panels(low, top, 1e-3 * floor)]) if top > low else pieces
    lower, upper, where = _search(it, pieces, known, tol)
    lower, where = (sure, np.inf) if sure >= lower else (lower, where)
    upper = max(upper, possible + it.far.rest(top), lower)
    status = "certified" if upper <= max((1 + tol) * lower, lower + floor) else _apart(possible > lower)
    return PeakGain(lower=lower, upper=upper, frequency=where, status=status)


def peak_between(system: Operand, low: float, high: float, tol: float = 1e-6, floor: float = 0.0) -> PeakGain:
    """Peak gain of a system without poles on the imaginary axis over the frequencies from low to high [rad/s].

    Raises
    ------
    InvalidParameterError
        If the range is empty.
    """
    if not 0 <= low < high < np.inf:
        raise InvalidParameterError(f"A frequency range needs 0 <= low < high < inf rad/s, got {low!r} and {high!r}.")
    it = frequency_domain(system)
    lower, upper, where = _search(it, it.panels(low, high, 1e-3 * floor), 0.0, tol)
    return PeakGain(lower=lower, upper=upper, frequency=where, status="certified")


def hinf_norm(system: Operand, tol: float = 1e-6) -> PeakGain:
    """H-infinity norm: the peak gain of a stable system.

    Raises
    ------
    UnstableSystemError
        If the system is unstable or on the boundary of stability.
    InvalidParameterError, NeutralSystemError
        As `linfnorm`.
    """
    require_stable(frequency_domain(system))
    return linfnorm(system, tol)


def require_stable(it: FrequencyDomain) -> None:
    """Refuse a system with poles in Re s >= 0.

    Raises
    ------
    UnstableSystemError
        With their number.
    """
    if it.poles.unstable:
        raise UnstableSystemError(
            f"The system has {it.poles.unstable} pole(s) with Re s > 0, and an unstable system has no norm: its "
            "outputs grow without bound. Stabilise it first; the peak gain on the imaginary axis alone is linfnorm."
        )
    if it.poles.on_axis:
        raise UnstableSystemError(
            f"The system has a pole on the imaginary axis, at {it.poles.on_axis[0].frequency:.4g} rad/s: it has no "
            "norm. Move the pole into the left half plane first."
        )


def _apart(at_infinity: bool) -> str:
    if at_infinity:
        return "bounded only: several delays of the direct path may or may not come into phase at high frequencies"
    return "bounded only: the last frequency that could be afforded leaves room above the largest gain found"


def _gain_at_infinity(it: FrequencyDomain) -> tuple[float, float]:
    """A gain that high frequencies come back to, and one that they do not exceed in the limit.

    With one delay its factor exp(-j w tau) comes to 1 and -1 again and again; so do those of several delays if they are
    rationally independent, which is not known here.
    """
    x = it.system
    direct = float(np.linalg.norm(x.D11, 2)) if x.D11.size else 0.0
    if not it.far.delayed.any():
        return direct, direct
    possible = direct + float(np.linalg.norm(it.far.delayed, 2))
    if len(np.unique(x.tau)) > 1 or x.n_delays > _MOST_CHANNELS:
        return 0.0, possible
    sure = 0.0
    for sign in (-1.0, 1.0):
        loop = np.eye(x.n_delays) - sign * x.D22
        sure = max(sure, float(np.linalg.norm(x.D11 + x.D12 @ np.linalg.solve(loop, sign * x.D21), 2)))
    return sure, possible


def _first_end(it: FrequencyDomain) -> float:
    """A frequency above every rate of the system [rad/s], from which on its bound falls."""
    return 4.0 * max([it.far.slowest, *(1.0 / it.system.tau), 1e-12])


def _search(it: FrequencyDomain, pieces: Panels, known: float, tol: float) -> tuple[float, float, float]:
    """The largest gain on the panels: attained, never exceeded, and its frequency [rad/s]."""
    bound, panel, u = (_vector_search if 1 in pieces.series.shape[2:] else _matrix_search)(pieces, known, 0.25 * tol)
    middle, reach = float((pieces.centre[panel] + pieces.half[panel] * u).imag), float(abs(pieces.half[panel])) / 8

    ends = (float((pieces.centre - pieces.half)[0].imag), float((pieces.centre + pieces.half)[-1].imag))

    def loss(offset: float) -> float:  # an offset is known more finely than a frequency
        return -float(np.linalg.norm(it.values(np.array([middle + offset]))[0], 2))

    between = max(ends[0] - middle, -reach), min(ends[1] - middle, reach)
    offset, least, *_ = fminbound(loss, *between, xtol=1e-9 * reach, full_output=True)
    if float(least) < loss(0.0) * (1 + 1e-14):  # both are negative: better by more than rounding
        return -float(least), max(bound, -float(least)), middle + float(offset)
    return -loss(0.0), max(bound, -loss(0.0)), middle


def _vector_search(pieces: Panels, known: float, slack: float) -> tuple[float, int, float]:
    """For one input or one output: the gain's square is a polynomial, which no rotation of G disturbs."""
    many, count, p, m = pieces.series.shape
    entries = np.moveaxis(pieces.series.reshape(many, count, p * m), 2, 0)
    square = sum((bernstein.squared(np.ascontiguousarray(entry)) for entry in entries), np.zeros((many, 2 * count - 1)))
    least, panel, u = bernstein.smallest(-square @ bernstein_matrix(2 * count - 2).T, slack)
    return float(np.sqrt(max(-least, known**2) * (1.0 + slack)) + pieces.error.max()), panel, u


def _matrix_search(pieces: Panels, known: float, slack: float) -> tuple[float, int, float]:
    points = pieces.control_points
    many, count, p, m = points.shape
    flat = np.ascontiguousarray(points.reshape(many, count, p * m))
    bound, _, panel, u = bernstein.largest_gain(flat, pieces.error, p, known, slack)
    if panel < 0:  # nothing exceeds by more than the slack what is known from the centre of a panel
        panel, u = int((np.linalg.norm(pieces.series[:, 0], 2, axis=(1, 2)) - pieces.error).argmax()), 0.0
    return bound, panel, u

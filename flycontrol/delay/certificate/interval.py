"""Certificates of stability for every delay of an interval, and for delays as long as can be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flycontrol.delay.certificate.certify import DelayCertificate, certify, refuse_unstable
from flycontrol.delay.certificate.history import delayed_signals
from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.real import real_number
from flycontrol.delay.system import DelayLTI, delay_lti
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

_Prover = Callable[[float, float], DelayCertificate]
_SMALLEST_PIECE = 1 / 64  # of the interval
_SHORTEST_TRIAL = 2.0**-30  # of the first


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class IntervalCertificate:
    """Stability for every constant delay of an interval: pieces that cover it, each with matrices of its own."""

    low: float  #: [s]
    high: float  #: [s]
    order: int
    proved: bool
    status: str  #: what is proved, or why nothing is, in a sentence
    pieces: tuple[
        DelayCertificate, ...
    ]  #: by rising delay; of a failure, those that were proved and the one that was not


def certify_interval(
    system: Operand, low: float, high: float, order: int = 3, *, full_history: bool = False, solver: str = "CLARABEL"
) -> IntervalCertificate:
    """Try to prove a loop stable for every constant delay in [low, high] in place of its own.

    One P, S and R must pass at both ends, which covers all delays between (see `certificate.functional`). An interval
    that fails is halved, down to 1/64 of the whole. The delay may not vary in time.

    Parameters
    ----------
    low, high
        Ends of the interval [s], 0 <= low < high.
    order, full_history, solver
        As in `stability_certificate`.

    Raises
    ------
    UnstableSystemError
        If the loop is unstable at an end by its exact spectrum.
    InvalidParameterError
        If the ends are not 0 <= low < high, or the system has several distinct delays.
    """
    low, high = real_number(low, "The low end of an interval [s]"), real_number(high, "The high end of an interval [s]")
    if not (0 <= low < high < np.inf):
        raise InvalidParameterError(
            f"An interval of delays needs 0 <= low < high in seconds, got low = {low!r} and high = {high!r}."
        )
    loop = as_delay_lti(system)
    prove = _prover(loop, order, full_history=full_history, solver=solver)
    for end in (low, high):
        refuse_unstable(at_delay(loop, end))
    pieces: list[DelayCertificate] = []
    waiting = [(float(low), float(high))]
    while waiting:
        left, right = waiting.pop()
        piece = prove(left, right)
        if not piece.proved and right - left > _SMALLEST_PIECE * (high - low):
            middle = (left + right) / 2
            waiting += [(middle, right), (left, middle)]
            continue
        pieces.append(piece)
        if not piece.proved:
            break
    return _interval(float(low), float(high), tuple(pieces))


def largest_certified_delay(  # noqa: PLR0913 (keywords of the certificate)
    system: Operand,
    order: int = 3,
    *,
    low: float = 0.0,
    up_to: float | None = None,
    tolerance: float = 1e-6,
    full_history: bool = False,
    solver: str = "CLARABEL",
) -> IntervalCertificate:
    """The longest interval [low, h] of constant delays that functionals of the given order prove stable.

    With one P, S and R a longer interval contains the proof of a shorter one, so bisection of h is safe. Where it
    ends, a new piece with its own matrices is tried from there on, until a piece gains less than the tolerance.

    Parameters
    ----------
    low
        Shortest delay [s]; the loop must be stable there.
    up_to
        Where the search ends for loops that any delay leaves stable [s]; 1000 times the loop's own delay if left out.
    tolerance
        Of h, relative.
    order, full_history, solver
        As in `stability_certificate`.

    Raises
    ------
    UnstableSystemError
        If the loop is unstable at the delay `low` by its exact spectrum.
    InvalidParameterError
        If low is not >= 0 and below up_to, the tolerance is not in (0, 1), or the system has several distinct delays.
    """
    low, tolerance = real_number(low, "low [s]"), real_number(tolerance, "The tolerance of the delay")
    loop = as_delay_lti(system)
    prove = _prover(loop, order, full_history=full_history, solver=solver)
    own = float(loop.tau[0])
    end = 1000.0 * max(own, low) if up_to is None else real_number(up_to, "up_to [s]")
    if not (0 <= low < end < np.inf):
        raise InvalidParameterError(
            f"The search needs 0 <= low < up_to in seconds, got low = {low!r}, up_to = {end!r}."
        )
    if not 0 < tolerance < 1:
        raise InvalidParameterError(f"The tolerance of the delay is relative, in (0, 1), got {tolerance!r}.")
    refuse_unstable(at_delay(loop, low))
    pieces: list[DelayCertificate] = []
    reached, trial = float(low), min(max(own, 2.0 * low), end)
    while reached < end:
        further, piece = _longest_piece(prove, _Search(reached, trial, end, tolerance))
        if not piece.proved:
            pieces = pieces or [piece]
            break
        pieces.append(piece)
        reached, trial = further, min(end, further * (1.0 + 4.0 * tolerance))
    found = _interval(float(low), reached, tuple(pieces))
    return replace(found, status=f"{found.status}; the search ended there") if reached >= end else found


class _Search(NamedTuple):
    """For the longest [low, h] with h <= end, from a first trial of h."""

    low: float
    trial: float
    end: float
    tolerance: float


class _Piece(NamedTuple):
    high: float
    certificate: DelayCertificate


def _longest_piece(prove: _Prover, search: _Search) -> _Piece:
    """The longest interval from `low` that one P, S and R prove; an unproved one if there is none."""
    low, h, end, tolerance = search
    shortest = max(2.0 * tolerance * low, _SHORTEST_TRIAL * h)
    best, failed = prove(low, h), np.inf
    while not best.proved and h - low > shortest:
        failed, h = h, (low + h) / 2
        best = prove(low, h)
    while best.proved and h < end and failed - h > tolerance * h:
        further = (h + failed) / 2 if failed < np.inf else min(end, low + 2 * (h - low))
        piece = prove(low, further)
        if piece.proved:
            best, h = piece, further
        else:
            failed = further
    return _Piece(h, best)


def _prover(system: DelayLTI, order: int, *, full_history: bool, solver: str) -> _Prover:
    """Certificates of one system in dependence on its delay."""
    signals = delayed_signals(system, full_history=full_history)
    distinct = np.unique(system.tau)
    if len(distinct) > 1:
        raise InvalidParameterError(
            f"An interval of delays needs a system with one delay, and this one has {distinct.tolist()!r} s; "
            "stability_certificate takes several delays as they are."
        )
    multiples = signals.delays / distinct[0]

    def prove(low: float, high: float) -> DelayCertificate:
        return certify(signals, low * multiples, high * multiples, order, solver)

    return prove


def at_delay(system: DelayLTI, delay: float) -> DelayLTI:
    """The system with another value of its one delay, which may be zero [s]."""
    if delay > 0:
        return replace(system, tau=np.full(system.n_delays, float(delay)))
    passing = np.linalg.solve(np.eye(system.n_delays) - system.D22, system.C2)
    return delay_lti(A=system.A + system.B2 @ passing, B1=system.B1, C1=system.C1)


def _interval(low: float, high: float, pieces: tuple[DelayCertificate, ...]) -> IntervalCertificate:
    last = pieces[-1]
    status = last.status
    if last.proved:
        status = (
            f"proved stable for every constant delay from {low!r} to {high!r} s by {len(pieces)} functional(s) of "
            f"order {last.order}"
        )
    return IntervalCertificate(low=low, high=high, order=last.order, proved=last.proved, status=status, pieces=pieces)

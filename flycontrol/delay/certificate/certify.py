"""A certificate of stability for given delays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flycontrol.delay.certificate.definite import Definiteness, definiteness
from flycontrol.delay.certificate.functional import (
    Readings,
    dissipation,
    dissipation_error,
    readings,
    storage,
    storage_error,
)
from flycontrol.delay.certificate.history import (
    DelayedSignals,
    balancing_units,
    delayed_signals,
    in_units,
)
from flycontrol.delay.certificate.solve import candidate
from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError, UnstableSystemError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DelayCertificate:
    """Matrices of a Lyapunov-Krasovskii functional, and whether they prove stability.

    V = X' P X + sum_i r_i int_0^1 (v' S v + (1 - theta) v_theta' R v_theta) dtheta with v(theta) = z(t - h_i theta),
    r_i = h_i / t0, X = (x, r int L_0 v, ..., r int L_(N-1) v) and t0 the longest of `high`; the same P, S and R for all
    delays between `low` and `high`. See `flycontrol.delay.certificate.functional`.
    """

    order: int  #: N, the number of Legendre projections
    signals: DelayedSignals  #: the loop x' = A x + B z(t - h), z = C x, of which the matrices speak
    low: FloatArray  #: lower delay of each group of signals [s]
    high: FloatArray  #: upper delay of each group [s]
    proved: bool  #: every matrix that must be positive definite is, with all roundings allowed for
    status: str  #: what is proved, or why nothing is, in a sentence
    P: FloatArray  #: (n + N q, n + N q), in the units of the states and signals
    S: FloatArray  #: (q, q), one block for each group
    R: FloatArray  #: (q, q), one block for each group
    checks: tuple[Definiteness, ...]  #: eigenvalues and margins in balanced units: V, S, R, and -V' at the ends
    solver: str
    statement: str  #: the solver's own word, which proves nothing


def stability_certificate(
    system: Operand, order: int = 3, *, full_history: bool = False, solver: str = "CLARABEL"
) -> DelayCertificate:
    """Try to prove that a loop is stable at its delays, one or several, by a functional of the given order.

    Parameters
    ----------
    order
        Number of Legendre projections of the past, >= 0. The bound on the delay rises to the exact one with it.
    full_history
        Let the functional see the past of all states, as in Seuret & Gouaisbaut 2015, instead of the past of the
        delayed signals only: a larger problem, which gains at order 0.
    solver
        A semidefinite solver of cvxpy.

    Raises
    ------
    UnstableSystemError
        If the exact spectrum has a root with Re s >= 0: no certificate exists.
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    InvalidParameterError
        If the order is not an integer >= 0, no delayed signal acts on a state, or the solver is not installed.
    """
    loop = as_delay_lti(system)
    signals = delayed_signals(loop, full_history=full_history)
    refuse_unstable(loop)
    return certify(signals, signals.delays, signals.delays, order, solver)


def refuse_unstable(system: DelayLTI) -> None:
    """Raise `UnstableSystemError` where a characteristic root rules a certificate out."""
    spectrum = rightmost_roots(system, 1, certify=False)
    if len(spectrum.roots) and spectrum.roots[0].real >= -spectrum.errors[0]:
        at = f" at a delay of {_seconds(system.tau)}" if system.n_delays else " without delay"
        where = "in the right half plane" if spectrum.roots[0].real > spectrum.errors[0] else "on the imaginary axis"
        raise UnstableSystemError(
            f"No certificate of stability can exist{at}: the characteristic root at {spectrum.roots[0]:.6g} 1/s is "
            f"{where}. Change the delay or the gains."
        )


def certify(signals: DelayedSignals, low: FloatArray, high: FloatArray, order: int, solver: str) -> DelayCertificate:
    """One P, S and R for all delays on the segment from low to high (one of each for each group of signals) [s]."""
    if not (isinstance(order, int | np.integer) and order >= 0):
        raise InvalidParameterError(f"The order of a certificate must be an integer >= 0, got {order!r}.")
    units = balancing_units(signals)
    ends = _ends(in_units(signals, units), low, high, int(order))
    ratio = signals.each(high / high.max())
    found = candidate(ends, ratio, signals.sizes, solver)
    checks = _checks(ends, ratio, found.P, found.S, found.R)
    proved = all(check.proved for check in checks)
    X, z = units.of_functional(int(order)), units.signals
    P, S, R = found.P / np.outer(X, X), found.S / np.outer(z, z), found.R / np.outer(z, z)
    for array in (P, S, R, low, high):
        array.setflags(write=False)
    return DelayCertificate(
        order=int(order), signals=signals, low=low, high=high, proved=proved,
        status=_status(low, high, checks, found.statement),
        P=P, S=S, R=R, checks=checks, solver=solver, statement=found.statement,
    )  # fmt: skip


def check_matrices(certificate: DelayCertificate) -> tuple[Definiteness, ...]:
    """The inequalities of a certificate evaluated anew from its matrices alone, whoever found them.

    Of P, S and R only the symmetric parts count, and of S and R only blocks of signals with the same delay.
    """
    c = certificate
    units = balancing_units(c.signals)
    ends = _ends(in_units(c.signals, units), c.low, c.high, c.order)
    X, z = units.of_functional(c.order), units.signals
    group = c.signals.each(c.signals.delays)
    block = np.equal.outer(group, group) * np.outer(z, z)
    P, S, R = ((M + M.T) / 2 for M in (c.P * np.outer(X, X), c.S * block, c.R * block))
    return _checks(ends, c.signals.each(c.high / c.high.max()), P, S, R)


def _ends(signals: DelayedSignals, low: FloatArray, high: FloatArray, order: int) -> tuple[Readings, ...]:
    """Readings at the lower and the upper delays, once where they are the same; time in the longest delay."""
    unit = float(high.max())
    delays = (high,) if np.array_equal(low, high) else (low, high)
    return tuple(readings(signals, of_group, unit, order) for of_group in delays)


def _checks(
    ends: tuple[Readings, ...], ratio: FloatArray, P: FloatArray, S: FloatArray, R: FloatArray
) -> tuple[Definiteness, ...]:
    exact = np.zeros_like(S)
    places = ("the delay",) if len(ends) == 1 else ("the lower delay", "the upper delay")
    return (
        definiteness("V", storage(ends[-1], ratio, P, S), storage_error(ends[-1], ratio, P, S)),
        definiteness("S", S, exact),
        definiteness("R", R, exact),
        *[
            definiteness(f"-V' at {place}", dissipation(end, P, S, R), dissipation_error(end, P, S, R))
            for place, end in zip(places, ends, strict=True)
        ],
    )


def _status(low: FloatArray, high: FloatArray, checks: tuple[Definiteness, ...], statement: str) -> str:
    where = f"{'a delay' if len(high) == 1 else 'delays'} of {_seconds(high)}"
    if not np.array_equal(low, high):
        where = f"all delays from {_seconds(low)} to {_seconds(high)}"
    smallest = min(check.smallest_eigenvalue for check in checks)
    if all(check.proved for check in checks):
        margin = max(check.margin for check in checks)
        return f"proved stable for {where}: smallest eigenvalue {smallest:.3g}, rounding at most {margin:.1g}"
    if np.isnan(smallest):
        return f"not proved for {where}: the solver gave no matrices ({statement})"
    failed = " and ".join(check.name for check in checks if not check.proved)
    return (
        f"not proved for {where}: no functional of this order was found that passes ({failed} not positive). "
        "That proves nothing about the loop; a higher order may succeed"
    )


def _seconds(delays: FloatArray) -> str:
    distinct = np.unique(delays)
    return " and ".join(repr(float(h)) for h in distinct) + " s"

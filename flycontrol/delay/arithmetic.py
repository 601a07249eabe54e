"""Sums, products and quotients of transfer matrices, as operators on delay systems."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flycontrol.delay.convert import as_delay_lti, static_gain
from flycontrol.delay.interconnect import append, parallel, series
from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand


def add(left: Operand, right: Operand) -> DelayLTI:
    """G + H; a number or a single-input single-output system is added to every entry of the other."""
    G, H = as_delay_lti(left), as_delay_lti(right)
    if _is_siso(G) != _is_siso(H):
        G, H = (_in_every_entry(G, H), H) if _is_siso(G) else (G, _in_every_entry(H, G))
    return parallel(G, H)


def subtract(left: Operand, right: Operand) -> DelayLTI:
    """G - H."""
    return add(left, multiply(-1.0, right))


def multiply(left: Operand, right: Operand) -> DelayLTI:
    """G H, y = G(H u); a number or a single-input single-output system multiplies every entry of the other."""
    G, H = as_delay_lti(left), as_delay_lti(right)
    if _is_siso(G) != _is_siso(H):
        scalar, matrix = (G, H) if _is_siso(G) else (H, G)
        # g I commutes with every matrix: put it where it needs fewer copies
        if matrix.n_inputs <= matrix.n_outputs:
            G, H = matrix, append(*[scalar] * matrix.n_inputs)
        else:
            G, H = append(*[scalar] * matrix.n_outputs), matrix
    return series(H, G)


def divide(left: Operand, right: Operand) -> DelayLTI:
    """G H^-1, y = G(H^-1 u).

    Raises
    ------
    InvalidParameterError
        If H is not square or its undelayed direct path D11 is singular.
    """
    return multiply(left, inverse(as_delay_lti(right)))


def inverse(system: DelayLTI) -> DelayLTI:
    """H^-1: u = D11^-1 (y - C1 x - D12 w), put into the system.

    Raises
    ------
    InvalidParameterError
        If H is not square or its undelayed direct path D11 is singular.
    """
    x = system
    if not (x.n_states or x.n_delays or x.D11.any()):
        raise InvalidParameterError("Division by zero: the divisor is a gain of 0.")
    if x.n_inputs != x.n_outputs or not _is_invertible(x.D11):
        raise InvalidParameterError(
            "Division needs a square system with an invertible undelayed direct path D11, got shape (outputs, inputs) "
            f"= {(x.n_outputs, x.n_inputs)} and D11 = {x.D11.tolist()!r}: the inverse would have to differentiate or "
            "to foresee. For G / (1 + G H) write feedback(G, H); for a derivative, let the plant give it as an output."
        )
    D = np.asarray(np.linalg.inv(x.D11), dtype=np.float64)
    return DelayLTI(
        x.A - x.B1 @ D @ x.C1, x.B1 @ D, x.B2 - x.B1 @ D @ x.D12, -D @ x.C1, x.C2 - x.D21 @ D @ x.C1,
        D, -D @ x.D12, x.D21 @ D, x.D22 - x.D21 @ D @ x.D12, x.tau,
    )  # fmt: skip


def _is_invertible(matrix: FloatArray) -> bool:
    """Whether the rows and columns, each in units of its largest entry, are independent to 12 digits."""
    rows = np.abs(matrix).max(axis=1, initial=0.0)
    if not rows.all():
        return False
    scaled = matrix / rows[:, None]
    columns = np.abs(scaled).max(axis=0, initial=0.0)
    return bool(columns.all()) and (matrix.size == 0 or bool(np.linalg.cond(scaled / columns) < 1e12))


def _is_siso(system: DelayLTI) -> bool:
    return system.n_inputs == system.n_outputs == 1


def _in_every_entry(scalar: DelayLTI, matrix: DelayLTI) -> DelayLTI:
    """1 g 1', one copy of g."""
    gather, spread = np.ones((1, matrix.n_inputs)), np.ones((matrix.n_outputs, 1))
    return series(series(static_gain(gather), scalar), static_gain(spread))

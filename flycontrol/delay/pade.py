"""Pade approximants of a delay as well-conditioned state space, and of whole delay systems."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flycontrol.delay.convert import as_delay_lti, delay_free, from_control, to_statespace
from flycontrol.delay.interconnect import append, connect
from flycontrol.delay.pade_ladder import damped_ladder
from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

__all__ = ["PadeMatrices", "from_control", "pade", "pade_matrices", "to_statespace"]


class PadeMatrices(NamedTuple):
    """State space of the [m/n] approximant of exp(-s), time in units of the delay: A (n, n), B (n,), C (n,), D."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: float


def pade_matrices(order: int, numdeg: int | None = None) -> PadeMatrices:
    """[m/n] Pade approximant of exp(-s), its states scaled to stored energy: A + A' = -B B', whatever the order.

    Conditioning stays harmless, while the companion form in seconds fails from about order 12. [n/n] is all-pass;
    [n/n], [n-1/n] (the Legendre delay network) and [n-2/n] are stable and never amplify; down to [n-4/n] they are
    stable.

    Parameters
    ----------
    order
        n, the degree of the denominator.
    numdeg
        m, the degree of the numerator, as in python-control: n when left out, n + numdeg when negative.

    Raises
    ------
    InvalidParameterError
        If order is not an integer >= 1, numdeg none from -n to n, or the approximant has unstable poles.
    """
    if not (isinstance(order, int | np.integer) and order >= 1):
        raise InvalidParameterError(f"A Pade order must be an integer >= 1, got {order!r}.")
    n = int(order)
    if numdeg is None or numdeg == n:
        return _all_pass_ladder(n)
    if not (isinstance(numdeg, int | np.integer) and -n <= numdeg <= n):
        raise InvalidParameterError(
            f"The numerator of a Pade approximant of order {n} has a degree from 0 to {n} (negative: counted from {n} "
            f"down), got {numdeg!r}."
        )
    A, B, C = damped_ladder(int(numdeg) % n if numdeg < 0 else int(numdeg), n)
    return PadeMatrices(A, B, C, 0.0)


def _all_pass_ladder(n: int) -> PadeMatrices:
    """[n/n] = (1 - tanh(s/2)) / (1 + tanh(s/2)), as an LC ladder seen by its waves; C = +-B'.

    The continued fraction 1 / tanh(s/2) = c1/s + 1 / (c2/s + 1 / (c3/s + ...)), c_k = 2 (2k - 1), cut after n terms,
    gives exactly the [n/n] approximant. Its elements are n lossless storages.
    """
    k = np.arange(1, n + 1)
    cap, coil = (k % 2 == 1).astype(np.float64), (k % 2 == 0).astype(np.float64)
    # v_1 and i_1 in terms of states and of the incoming wave a = v_1 + i_1
    if n % 2:
        v1, i1, v1_a, i1_a = cap, -cap, 0.0, 1.0
    else:
        v1, i1, v1_a, i1_a = -coil, coil, 1.0, 0.0
    A, B = np.zeros((n, n)), np.zeros(n)
    for row in range(n):
        is_cap = row % 2 == 0
        # a capacitor's current is i_1 less the coils before it; a coil's voltage is v_1 less the capacitors
        start, through = (i1, coil) if is_cap else (v1, cap)
        A[row] = start - through * (k <= row)
        B[row] = i1_a if is_cap else v1_a
    energy = np.sqrt(2.0 * (2.0 * k - 1.0))
    A, B, C = A * np.outer(energy, energy), B * energy, (v1 - i1) * energy
    return PadeMatrices(A, np.sqrt(2.0) * B, C / np.sqrt(2.0), v1_a - i1_a)


def pade(system: Operand, order: int, numdeg: int | None = None) -> DelayLTI:
    """The delay-free system in which every delay is replaced by its [m/n] Pade approximant, see `pade_matrices`.

    Raises
    ------
    InvalidParameterError
        If order or numdeg is no degree, or the approximant has unstable poles.
    AlgebraicLoopError
        If the approximants' direct paths close an algebraic loop (possible only with nonzero D22).
    """
    exact = as_delay_lti(system)
    return first_delays_approximated(exact, exact.n_delays, order, numdeg)


def first_delays_approximated(exact: DelayLTI, many: int, order: int, numdeg: int | None = None) -> DelayLTI:
    """`pade` of the first so many delay channels only; the others stay exact."""
    if many == 0:
        return exact
    unit = pade_matrices(order, numdeg)
    channels = append(*[
        delay_free(unit.A / tau, unit.B[:, None] / tau, unit.C[None, :], np.array([[unit.D]]))
        for tau in exact.tau[:many]
    ])  # fmt: skip
    both = append(_opened(exact, many), channels)
    m, p, q = exact.n_inputs, exact.n_outputs, many
    F = np.zeros((m + 2 * q, p + 2 * q))
    F[m : m + q, p + q :] = np.eye(q)  # w = channels' outputs
    F[m + q :, p : p + q] = np.eye(q)  # channels' inputs = z
    mixed = connect(both, F, np.eye(m + 2 * q)[:, :m], np.eye(p + 2 * q)[:p])
    return replace(mixed, input_names=exact.input_names, output_names=exact.output_names, name=exact.name)


def pade_state(system: DelayLTI, order: int, state: FloatArray) -> FloatArray:
    """State of `pade(system, order)` for a state (n,) that had been constant: its channels at rest, A xi + B z = 0."""
    if system.n_delays == 0:
        return state
    unit = pade_matrices(order)
    signals = np.linalg.solve(np.eye(system.n_delays) - system.D22, system.C2 @ state)
    rest: FloatArray = -np.linalg.solve(unit.A, unit.B).astype(np.float64)
    return np.concatenate([state, np.outer(signals, rest).ravel()])


def _opened(system: DelayLTI, many: int) -> DelayLTI:
    """Inputs (u, w) and outputs (y, z) of the system with its first delay channels cut open."""
    x, k = system, many
    return DelayLTI(
        x.A, np.hstack([x.B1, x.B2[:, :k]]), x.B2[:, k:],
        np.vstack([x.C1, x.C2[:k]]), x.C2[k:],
        np.block([[x.D11, x.D12[:, :k]], [x.D21[:k], x.D22[:k, :k]]]), np.vstack([x.D12[:, k:], x.D22[:k, k:]]),
        np.hstack([x.D21[k:], x.D22[k:, :k]]), x.D22[k:, k:], x.tau[k:],
    )  # fmt: skip

"""Series, parallel and feedback of delay systems: block-diagonal stacking, then one static, undelayed feedback."""

from __future__ import annotations

from functools import reduce
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.algebraic_loop import closed_directly
from flycontrol.delay.convert import as_delay_lti, static_gain
from flycontrol.delay.redundancy import merge_delays
from flycontrol.delay.system import DelayLTI, FloatArray, delay_lti
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand


def append(*systems: Operand) -> DelayLTI:
    """Stack systems side by side: inputs, outputs, states and delay channels of all, none of them connected."""
    parts = [as_delay_lti(system) for system in systems]

    def stacked(name: str) -> FloatArray:
        return _block_diagonal([getattr(part, name) for part in parts])

    return DelayLTI(
        stacked("A"), stacked("B1"), stacked("B2"), stacked("C1"), stacked("C2"), stacked("D11"), stacked("D12"),
        stacked("D21"), stacked("D22"), np.concatenate([np.zeros(0), *[part.tau for part in parts]]),
    )  # fmt: skip


def _block_diagonal(blocks: list[FloatArray]) -> FloatArray:
    """As scipy.linalg.block_diag, which takes most of the time of closing a small loop."""
    ends = np.cumsum([(0, 0), *[block.shape for block in blocks]], axis=0)
    diagonal = np.zeros(tuple(ends[-1]))
    for (row, column), (last_row, last_column), block in zip(ends[:-1], ends[1:], blocks, strict=True):
        diagonal[row:last_row, column:last_column] = block
    return diagonal


def connect(
    system: DelayLTI, feedback_matrix: FloatArray, input_matrix: FloatArray, output_matrix: FloatArray
) -> DelayLTI:
    """Close u = F y + G v around a system and read H y; delay channels that become redundant are merged.

    Parameters
    ----------
    feedback_matrix, input_matrix, output_matrix
        F (m, p), G (m, new inputs), H (new outputs, p).

    Raises
    ------
    InvalidParameterError
        If a matrix does not fit the system.
    AlgebraicLoopError
        If I - F D11 is singular: the undelayed direct path around the loop has no unique solution.
    """
    F, G, H = (np.asarray(matrix, dtype=np.float64) for matrix in (feedback_matrix, input_matrix, output_matrix))
    m, p = system.n_inputs, system.n_outputs
    if F.shape != (m, p) or G.ndim != 2 or len(G) != m or H.ndim != 2 or H.shape[1] != p:
        raise InvalidParameterError(
            f"Around a system of {p} outputs and {m} inputs, F must have shape {(m, p)}, G {m} rows and H {p} columns; "
            f"got {F.shape}, {G.shape} and {H.shape}."
        )
    closed = closed_directly(F @ system.D11)
    gain, entry = closed @ F, closed @ G
    s = system
    return merge_delays(
        DelayLTI(
            s.A + s.B1 @ gain @ s.C1, s.B1 @ entry, s.B2 + s.B1 @ gain @ s.D12,
            H @ (s.C1 + s.D11 @ gain @ s.C1), s.C2 + s.D21 @ gain @ s.C1,
            H @ (s.D11 @ entry), H @ (s.D12 + s.D11 @ gain @ s.D12), s.D21 @ entry, s.D22 + s.D21 @ gain @ s.D12, s.tau,
        )
    )  # fmt: skip


def series(*systems: Operand) -> DelayLTI:
    """One after the other: series(G, H) is y = H(G(u)).

    Raises
    ------
    InvalidParameterError
        If one has another number of outputs than the next has inputs.
    """
    _require_some(systems, "A series connection")
    return reduce(_in_series, [as_delay_lti(system) for system in systems])


def _in_series(first: DelayLTI, second: DelayLTI) -> DelayLTI:
    if first.n_outputs != second.n_inputs:
        raise InvalidParameterError(
            f"A series connection needs as many outputs of the first system ({first.n_outputs}) "
            f"as inputs of the second ({second.n_inputs}); their shapes (outputs, inputs) are {_shape(first)} and "
            f"{_shape(second)}."
        )
    both = append(first, second)
    m1, p1 = first.n_inputs, first.n_outputs
    F = np.zeros((both.n_inputs, both.n_outputs))
    F[m1:, :p1] = np.eye(p1)
    return connect(both, F, np.eye(both.n_inputs)[:, :m1], np.eye(both.n_outputs)[p1:])


def parallel(*systems: Operand) -> DelayLTI:
    """Side by side on the same inputs, outputs added.

    Raises
    ------
    InvalidParameterError
        If they differ in shape.
    """
    _require_some(systems, "A sum")
    parts = [as_delay_lti(system) for system in systems]
    m, p = parts[0].n_inputs, parts[0].n_outputs
    for other in parts[1:]:
        if _shape(other) != (p, m):
            raise InvalidParameterError(
                f"A sum needs systems of one shape (outputs, inputs), got {(p, m)} and {_shape(other)}."
            )
    all_of_them = append(*parts)
    F = np.zeros((all_of_them.n_inputs, all_of_them.n_outputs))
    return connect(all_of_them, F, np.vstack([np.eye(m)] * len(parts)), np.hstack([np.eye(p)] * len(parts)))


def _require_some(systems: tuple[Operand, ...], what: str) -> None:
    if not systems:
        raise InvalidParameterError(f"{what} needs at least one system, got none.")


def feedback(forward: Operand, back: Operand | None = None, sign: float = -1.0) -> DelayLTI:
    """The loop y = forward(v + sign * back(y)); back is the identity when left out, sign -1 as in python-control.

    A number as back stands for that many times the identity.

    Raises
    ------
    InvalidParameterError
        If the two do not fit into a loop.
    AlgebraicLoopError
        If the undelayed direct path has no unique solution.
    """
    ahead = as_delay_lti(forward)
    m, p = ahead.n_inputs, ahead.n_outputs
    if back is None or isinstance(back, int | float | np.number):
        if m != p:
            raise InvalidParameterError(f"Unit feedback needs a square system, got shape (outputs, inputs) = {(p, m)}.")
        back = static_gain((1.0 if back is None else back) * np.eye(m))
    returning = as_delay_lti(back)
    if _shape(returning) != (m, p):
        raise InvalidParameterError(
            f"Around a system of shape (outputs, inputs) = {_shape(ahead)} the feedback path must have shape {(m, p)}, "
            f"got {_shape(returning)}."
        )
    if sign not in (-1, 1):
        raise InvalidParameterError(f"The sign of a feedback must be -1 or 1, got {sign!r}; put a gain into a system.")
    both = append(ahead, returning)
    F = np.zeros((m + p, p + m))
    F[:m, p:] = sign * np.eye(m)
    F[m:, :p] = np.eye(p)
    return connect(both, F, np.eye(m + p)[:, :m], np.eye(p + m)[:p])


def delay(seconds: ArrayLike) -> DelayLTI:
    """Pure delay y(t) = u(t - seconds); zero seconds is the identity.

    Parameters
    ----------
    seconds
        One delay, or a vector of k delays for k inputs and k outputs, each delayed by its own [s].

    Raises
    ------
    InvalidParameterError
        If a delay is negative or not a finite number.
    """
    given = np.asarray(seconds)
    if given.dtype.kind not in "iuf" or given.ndim > 1 or not (np.isfinite(given) & (given >= 0)).all():
        raise InvalidParameterError(
            f"A delay must be >= 0 s and finite, one number or a vector of numbers, got {seconds!r}."
        )
    times = np.atleast_1d(given.astype(np.float64))
    late, identity = np.flatnonzero(times), np.eye(len(times))
    return delay_lti(
        A=np.zeros((0, 0)), B1=np.zeros((0, len(times))), C1=np.zeros((len(times), 0)), tau=times[late],
        D11=np.diag((times == 0).astype(np.float64)), D12=identity[:, late], D21=identity[late],
    )  # fmt: skip


def _shape(system: DelayLTI) -> tuple[int, int]:
    return system.n_outputs, system.n_inputs

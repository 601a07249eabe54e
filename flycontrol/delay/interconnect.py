"""Series, parallel and feedback of delay systems: block-diagonal stacking, then one static, undelayed feedback."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.errors import AlgebraicLoopError, InvalidParameterError


def append(*systems: DelayLTI) -> DelayLTI:
    """Stack systems side by side: inputs, outputs, states and delay channels of all, none of them connected."""

    def stacked(name: str) -> FloatArray:
        # block_diag keeps the rows of a block without columns, which empty delay blocks rely on
        return np.asarray(scipy.linalg.block_diag(*[getattr(system, name) for system in systems]), dtype=np.float64)

    return DelayLTI(
        stacked("A"), stacked("B1"), stacked("B2"), stacked("C1"), stacked("C2"),
        stacked("D11"), stacked("D12"), stacked("D21"), stacked("D22"), np.concatenate([s.tau for s in systems]),
    )  # fmt: skip


def connect(
    system: DelayLTI, feedback_matrix: FloatArray, input_matrix: FloatArray, output_matrix: FloatArray
) -> DelayLTI:
    """Close u = F y + G v around a system and read H y.

    Parameters
    ----------
    feedback_matrix, input_matrix, output_matrix
        F (m, p), G (m, new inputs), H (new outputs, p).

    Raises
    ------
    AlgebraicLoopError
        If I - F D11 is singular: the undelayed direct path around the loop has no unique solution.
    """
    loop = np.eye(system.n_inputs) - feedback_matrix @ system.D11
    if np.linalg.cond(loop) > 1e12:
        raise AlgebraicLoopError(
            "The undelayed direct path around the loop has gain 1, so it has no unique solution; "
            "put a delay or a lag into the loop, or feed back the plant's derivative output instead of differentiating."
        )
    gain = np.linalg.solve(loop, feedback_matrix)
    entry = np.linalg.solve(loop, input_matrix)
    s, H = system, output_matrix
    return DelayLTI(
        s.A + s.B1 @ gain @ s.C1, s.B1 @ entry, s.B2 + s.B1 @ gain @ s.D12,
        H @ (s.C1 + s.D11 @ gain @ s.C1), s.C2 + s.D21 @ gain @ s.C1,
        H @ s.D11 @ entry, H @ (s.D12 + s.D11 @ gain @ s.D12), s.D21 @ entry, s.D22 + s.D21 @ gain @ s.D12, s.tau,
    )  # fmt: skip


def series(first: DelayLTI, second: DelayLTI) -> DelayLTI:
    """Second after first: y = second(first(u)).

    Raises
    ------
    InvalidParameterError
        If the first has another number of outputs than the second has inputs.
    """
    if first.n_outputs != second.n_inputs:
        raise InvalidParameterError(
            f"A series connection needs as many outputs of the first system ({first.n_outputs}) "
            f"as inputs of the second ({second.n_inputs})."
        )
    both = append(first, second)
    m1, p1, p2 = first.n_inputs, first.n_outputs, second.n_outputs
    F = np.zeros((both.n_inputs, both.n_outputs))
    F[m1:, :p1] = np.eye(p1)
    G = np.eye(both.n_inputs)[:, :m1]
    H = np.eye(both.n_outputs)[p1 : p1 + p2]
    return connect(both, F, G, H)


def feedback(forward: DelayLTI, back: DelayLTI | None = None, sign: float = -1.0) -> DelayLTI:
    """The loop y = forward(v + sign * back(y)); back is the identity when left out, sign -1 as in python-control.

    Raises
    ------
    InvalidParameterError
        If the two do not fit into a loop.
    AlgebraicLoopError
        If the undelayed direct path has no unique solution.
    """
    m, p = forward.n_inputs, forward.n_outputs
    if back is None:
        if m != p:
            raise InvalidParameterError(f"Unit feedback needs a square system, got {p} outputs and {m} inputs.")
        return connect(forward, sign * np.eye(m), np.eye(m), np.eye(p))
    if (back.n_inputs, back.n_outputs) != (p, m):
        raise InvalidParameterError(
            f"The feedback path must have {p} inputs and {m} outputs, got {back.n_inputs} and {back.n_outputs}."
        )
    both = append(forward, back)
    F = np.zeros((m + p, p + m))
    F[:m, p:] = sign * np.eye(m)
    F[m:, :p] = np.eye(p)
    return connect(both, F, np.eye(m + p)[:, :m], np.eye(p + m)[:p])


def delay(seconds: float) -> DelayLTI:
    """Pure delay y(t) = u(t - seconds), one input and one output; zero seconds is the identity.

    Raises
    ------
    InvalidParameterError
        If seconds is negative or not a number.
    """
    if not (seconds >= 0 and np.isfinite(seconds)):
        raise InvalidParameterError(f"A delay must be >= 0 s and finite, got {seconds!r}.")
    empty = np.zeros
    if seconds == 0:
        return DelayLTI(
            empty((0, 0)), empty((0, 1)), empty((0, 0)), empty((1, 0)), empty((0, 0)),
            np.ones((1, 1)), empty((1, 0)), empty((0, 1)), empty((0, 0)), empty(0),
        )  # fmt: skip
    return DelayLTI(
        empty((0, 0)), empty((0, 1)), empty((0, 1)), empty((1, 0)), empty((1, 0)),
        empty((1, 1)), np.ones((1, 1)), np.ones((1, 1)), empty((1, 1)), np.array([float(seconds)]),
    )  # fmt: skip

"""What the roots of a delay system depend on, and the characteristic matrix with its derivatives."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray


class CharacteristicBlocks(NamedTuple):
    """The blocks of a `DelayLTI` that its roots depend on; shapes as there.

    A family of systems may return these instead of a `DelayLTI` where speed matters: nothing is checked but shapes.
    """

    A: FloatArray
    B2: FloatArray
    C2: FloatArray
    D22: FloatArray
    tau: FloatArray  #: delays [s]

    @property
    def shapes(self) -> tuple[tuple[int, ...], ...]:
        """Shapes of the five blocks."""
        return self.A.shape, self.B2.shape, self.C2.shape, self.D22.shape, self.tau.shape


def characteristic_blocks(system: DelayLTI) -> CharacteristicBlocks:
    """The blocks of a system, as copies."""
    x = system
    return CharacteristicBlocks(x.A.copy(), x.B2.copy(), x.C2.copy(), x.D22.copy(), x.tau.copy())


def without_ports(blocks: CharacteristicBlocks) -> DelayLTI:
    """A system with these blocks and neither input nor output.

    Raises
    ------
    InvalidParameterError
        If the blocks do not fit each other, are not finite, or a delay is not > 0.
    """
    A, B2, C2, D22, tau = (np.array(block, dtype=np.float64) for block in blocks)
    n, q, zero = len(A), len(tau), np.zeros
    return DelayLTI(A, zero((n, 0)), B2, zero((0, n)), C2, zero((0, 0)), zero((0, q)), zero((q, 0)), D22, tau)


def matrix(blocks: CharacteristicBlocks, s: complex) -> ComplexArray:
    """M(s) = [[s I - A, -B2], [-E C2, I - E D22]], E = diag exp(-s tau); shape (n + q, n + q)."""
    n, q = blocks.B2.shape
    M = np.empty((n + q, n + q), dtype=np.complex128)
    factor = np.exp(-s * blocks.tau)[:, None]
    M[:n, :n], M[:n, n:] = s * np.eye(n) - blocks.A, -blocks.B2
    M[n:, :n], M[n:, n:] = -factor * blocks.C2, np.eye(q) - factor * blocks.D22
    return M


def matrix_derivative(blocks: CharacteristicBlocks, s: complex, order: int = 1) -> ComplexArray:
    """The derivative of M(s) in s of the given order >= 1."""
    n, q = blocks.B2.shape
    M = np.zeros((n + q, n + q), dtype=np.complex128)
    factor = -((-blocks.tau) ** order * np.exp(-s * blocks.tau))[:, None]
    M[:n, :n] = np.eye(n) if order == 1 else 0.0
    M[n:, :n], M[n:, n:] = factor * blocks.C2, factor * blocks.D22
    return M

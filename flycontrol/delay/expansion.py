"""G(s) = D(s) + H1(s) / s + H2(s) / s^2 + ... at high frequencies, each coefficient a finite sum of delays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray, require_retarded


@dataclass(frozen=True, slots=True, eq=False)
class DelaySum:
    """M(s) = sum_k M_k exp(-s theta_k), every theta once."""

    theta: FloatArray  #: rising [s], shape (k,)
    matrices: FloatArray  #: shape (k, rows, columns)

    def __call__(self, s: ComplexArray) -> ComplexArray:
        """M at complex frequencies (l,) [1/s], shape (l, rows, columns)."""
        return np.einsum("lk,kab->lab", np.exp(-s[:, None] * self.theta), self.matrices)

    def __add__(self, other: DelaySum) -> DelaySum:
        return _collected(
            np.concatenate([self.theta, other.theta]), np.concatenate([self.matrices, other.matrices], axis=0)
        )

    def __matmul__(self, other: DelaySum) -> DelaySum:
        theta = (self.theta[:, None] + other.theta).ravel()
        products = np.einsum("kab,lbc->klac", self.matrices, other.matrices)
        return _collected(theta, products.reshape(len(theta), *products.shape[2:]))

    @property
    def is_zero(self) -> bool:
        """Whether M vanishes identically."""
        return len(self.theta) == 0


class Expansion(NamedTuple):
    """Coefficients of the first powers of 1 / s."""

    feedthrough: DelaySum  #: D(s), shape (p, m)
    first: DelaySum  #: H1(s)
    second: DelaySum  #: H2(s)


def expansion(system: DelayLTI) -> Expansion:
    """The expansion of a system of retarded type.

    With w = P(s) (C2 x + D21 u), P = E + E D22 E + ..., the system is s x = A(s) x + B(s) u, y = C(s) x + D(s) u, so
    that H1 = C B and H2 = C A B.

    Raises
    ------
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    require_retarded(system)
    x = system
    from_states, from_inputs = _delayed(x, x.C2), _delayed(x, x.D21)
    A = _constant(x.A) + _constant(x.B2) @ from_states
    B = _constant(x.B1) + _constant(x.B2) @ from_inputs
    C = _constant(x.C1) + _constant(x.D12) @ from_states
    return Expansion(_constant(x.D11) + _constant(x.D12) @ from_inputs, C @ B, C @ (A @ B))


def _constant(matrix: FloatArray) -> DelaySum:
    return _collected(np.zeros(1), matrix[None])


def _delayed(system: DelayLTI, source: FloatArray) -> DelaySum:
    """P(s) source: what leaves the delay channels, W = E (source + D22 W), which ends since D22 is nilpotent."""
    q = system.n_delays
    lags = DelaySum(system.tau, np.einsum("ia,ib->iab", np.eye(q), np.eye(q)))
    found = lags @ _constant(source)
    for _ in range(q if system.D22.any() else 0):
        found = lags @ (_constant(source) + _constant(system.D22) @ found)
    return found


def _collected(theta: FloatArray, matrices: FloatArray) -> DelaySum:
    """Equal delays, to rounding, merged; terms that cancel to rounding left out."""
    order = np.argsort(theta, kind="stable")
    theta, matrices = theta[order], matrices[order]
    first = np.append(True, np.diff(theta) > 1e-12 * theta[1:]) if len(theta) else np.zeros(0, dtype=bool)
    starts = np.flatnonzero(first)
    if len(starts) == 0:
        return DelaySum(theta, matrices)
    sums, sizes = np.add.reduceat(matrices, starts), np.add.reduceat(np.abs(matrices), starts)
    keep = (np.abs(sums) > 1e-14 * sizes).any(axis=(1, 2))
    return DelaySum(theta[starts][keep], sums[keep])

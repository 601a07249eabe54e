"""Rightmost characteristic roots: Chebyshev collocation of the delay channels, then Newton on the exact equation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from flycontrol.delay.kernels import newton
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray, is_retarded
from flycontrol.errors import NeutralSystemError

_MAX_NODES = 400


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Rightmost roots of a delay system."""

    roots: ComplexArray  #: [1/s], by falling real part, conjugates next to each other, upper one first
    errors: FloatArray  #: estimated error of each root: its last Newton step [1/s]
    nodes: int  #: collocation nodes a delay channel; 0 without delays
    status: str  #: what is known of completeness, in words

    @property
    def abscissa(self) -> float:
        """Real part of the rightmost root [1/s]; -inf for a system without roots."""
        return float(self.roots[0].real) if len(self.roots) else -np.inf


def rightmost_roots(system: DelayLTI, count: int = 10) -> Spectrum:
    """The `count` rightmost roots of det [[s I - A, -B2], [-E C2, I - E D22]] = 0 (one more if it would split a pair).

    Each delay channel is a transport line, collocated at Chebyshev points; the eigenvalues of states and lines start a
    Newton iteration with implicit deflation (Ehrlich-Aberth) on the exact equation. Lines get enough nodes to resolve every root
    as large as the norm bound allows in the half plane that is returned.

    Raises
    ------
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    if not is_retarded(system):
        raise NeutralSystemError(
            "This system is of neutral type (a delay feeds back into itself without passing a state): infinitely many "
            "roots can crowd a vertical line. Put a lag into that path."
        )
    if system.n_delays == 0:
        roots = _ordered(np.linalg.eigvals(system.A).astype(np.complex128))[: count + 1]
        roots = _whole_pairs(roots, count)
        return Spectrum(roots, np.zeros(len(roots)), 0, "all roots: the system has no delay")
    balanced = balance(system)
    nodes = _nodes_for(root_bound(balanced, 0.0) * balanced.tau.max())
    while True:
        roots, errors = _polish(balanced, _collocated_roots(balanced, nodes)[: count + 4])
        wanted = _whole_pairs(roots, count)
        line = float(wanted[-1].real) if len(wanted) else 0.0
        needed = _nodes_for(min(root_bound(balanced, line), 1.5 * float(np.abs(wanted).max(initial=0.0))) * balanced.tau.max())
        if needed <= nodes or nodes >= _MAX_NODES:
            break
        nodes = min(_MAX_NODES, max(needed, nodes + 8))
    enough = needed <= nodes
    status = "resolved to the norm bound of the roots" if enough else f"not resolved with {_MAX_NODES} nodes a delay"
    return Spectrum(wanted, errors[: len(wanted)], nodes, status)


def balance(system: DelayLTI) -> DelayLTI:
    """The same system with states scaled so that rows and columns of |A| + |B2| |C2| are of equal size."""
    if system.n_states == 0:
        return system
    weight = np.abs(system.A) + np.abs(system.B2) @ np.abs(system.C2)
    _, (scale, _) = scipy.linalg.matrix_balance(weight, permute=False, separate=True)
    s = np.asarray(scale, dtype=np.float64)
    x = system
    return DelayLTI(
        x.A * s / s[:, None], x.B1 / s[:, None], x.B2 / s[:, None], x.C1 * s, x.C2 * s,
        x.D11, x.D12, x.D21, x.D22, x.tau,
    )  # fmt: skip


def root_bound(system: DelayLTI, line: float) -> float:
    """A bound on |s| for every root with Re s >= line: ||A|| + ||B2|| ||E|| ||(I - D22 E)^-1|| ||C2|| [1/s]."""
    growth = np.exp(-line * system.tau)
    chain = np.linalg.inv(np.eye(system.n_delays) - growth[:, None] * np.abs(system.D22))
    delayed = np.abs(system.B2) @ chain @ (growth[:, None] * np.abs(system.C2))
    return float(np.linalg.norm(np.abs(system.A) + delayed, np.inf))


def _nodes_for(radius: float) -> int:
    """Chebyshev nodes that resolve exp(-s theta), 0 <= theta <= 1, for |s| <= radius to better than Newton needs."""
    return int(min(_MAX_NODES, np.ceil(10.0 + 0.75 * radius)))


@lru_cache(maxsize=64)
def _chebyshev_differentiation(n: int) -> FloatArray:
    """Differentiation matrix (n + 1, n + 1) at the Chebyshev points of [0, 1] from 0 up to 1 (Trefethen 2000)."""
    k = np.arange(n + 1)
    x = (1.0 - np.cos(np.pi * k / n)) / 2.0
    c = np.where((k == 0) | (k == n), 2.0, 1.0) * (-1.0) ** k
    difference = x[:, None] - x[None, :]
    D = np.outer(c, 1.0 / c) / (difference + np.eye(n + 1))
    D -= np.diag(D.sum(axis=1))
    return D


def _collocated_roots(system: DelayLTI, nodes: int) -> ComplexArray:
    """Eigenvalues of states and collocated transport lines v_t = -v_theta / tau, v(0) = z, w = v(1); rightmost first."""
    n, q = system.n_states, system.n_delays
    D = _chebyshev_differentiation(nodes)
    size = n + q * nodes
    M = np.zeros((size, size))
    ends = n + nodes * np.arange(1, q + 1) - 1
    M[:n, :n] = system.A
    M[:n, ends] = system.B2
    for i, tau in enumerate(system.tau):
        rows = slice(n + i * nodes, n + (i + 1) * nodes)
        M[rows, rows] = -D[1:, 1:] / tau
        M[rows, :n] += np.outer(-D[1:, 0] / tau, system.C2[i])
        M[rows, ends] += np.outer(-D[1:, 0] / tau, system.D22[i])
    return _ordered(np.linalg.eigvals(M).astype(np.complex128))


def _polish(system: DelayLTI, start: ComplexArray) -> tuple[ComplexArray, FloatArray]:
    """Newton with implicit deflation on the upper half of the roots; returns roots by falling real part and last steps."""
    x = system
    roots = start[start.imag >= 0].copy()
    paired = roots.imag > 0
    blocks = [np.array(block) for block in (x.A, x.B2, x.C2, x.D22, x.tau)]  # writeable copies: one compiled signature
    steps = newton.polish(*blocks, roots, paired, 40)
    roots.imag = np.abs(roots.imag)
    pairs = np.concatenate([roots, roots[paired].conj()])
    errors = np.concatenate([steps, steps[paired]])
    order = _order(pairs)
    return pairs[order], errors[order]


def _order(roots: ComplexArray) -> NDArray[np.intp]:
    """By falling real part (to rounding), then rising |imag|, upper half first."""
    scale = np.abs(roots).max(initial=0.0) * 1e-12 + 1e-300
    return np.lexsort((-roots.imag, np.abs(roots.imag), -np.round(roots.real / scale)))


def _ordered(roots: ComplexArray) -> ComplexArray:
    return roots[_order(roots)]


def _whole_pairs(roots: ComplexArray, count: int) -> ComplexArray:
    """The first `count` roots, one more if the last would leave its conjugate behind."""
    head = roots[:count]
    splits = len(head) < len(roots) and len(head) > 0 and head[-1].imag > 0
    return roots[: count + 1] if splits else head

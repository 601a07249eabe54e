"""Rightmost characteristic roots: Chebyshev collocation, Newton on the exact equation, and a count that certifies."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from flycontrol.delay.balance import balance, root_bound
from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.count import count_right_of
from flycontrol.delay.kernels import newton
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray, require_retarded
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

_MOST_NODES = 400
_FIRST_NODES = 60  # a count tells whether they were enough; the bound on the roots of a stiff plant asks for far more
_SWEPT_NODES = 130  # from here on the missing roots are sought around points higher up the imaginary axis
_WINDOW_NODES = 30  # of each such point: the cost of a stretch of the axis is least about there


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Rightmost roots of a delay system."""

    roots: ComplexArray  #: [1/s], by falling real part, conjugates next to each other, upper one first
    errors: FloatArray  #: estimated error of each root: its last Newton step [1/s]
    line: float  #: every root with Re s > line is listed, if `status` is "certified" [1/s]
    nodes: int  #: collocation nodes of the longest delay; 0 without delays
    #: "certified, with fewer roots than asked: ..." when the others lie beyond what collocation resolves
    status: str  #: "certified", "not certified", "a root too near the line", or "not counted" without `certify`

    @property
    def abscissa(self) -> float:
        """Real part of the rightmost root [1/s]; -inf for a system without roots."""
        return float(self.roots[0].real) if len(self.roots) else -np.inf


def rightmost_roots(system: Operand, count: int = 10, *, certify: bool = True) -> Spectrum:
    """The `count` rightmost roots of det [[s I - A, -B2], [-E C2, I - E D22]] = 0 (one more if it would split a pair).

    Each delay channel is a transport line, collocated at Chebyshev points; the eigenvalues of states and lines start a
    Newton iteration with implicit deflation (Ehrlich-Aberth) on the exact equation. The number of roots right of a line
    just left of the last one is then counted by the argument principle; nodes are added until both agree.

    Raises
    ------
    InvalidParameterError
        If the count is not an integer >= 1.
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    if not (isinstance(count, int | np.integer) and count >= 1):
        raise InvalidParameterError(f"The count of rightmost roots must be an integer >= 1, got {count!r}.")
    system = as_delay_lti(system)
    require_retarded(system)
    if system.n_delays == 0:
        roots = _ordered(np.linalg.eigvals(system.A).astype(np.complex128))
        eps = np.finfo(float).eps * np.abs(roots).max(initial=0.0)
        return Spectrum(roots[: _whole(roots, count)], np.full(_whole(roots, count), eps), -np.inf, 0, "certified")
    balanced = balance(system)
    nodes = max(8 + count, _nodes_for(root_bound(balanced, 0.0) * balanced.tau.max()))
    if certify:
        nodes = min(nodes, max(8 + count, _FIRST_NODES))
    while True:
        found = _spectrum_from(balanced, _collocated_roots(balanced, nodes), nodes, count, certify=certify)
        if certify and found.status == "not certified" and nodes >= _SWEPT_NODES:
            swept = _spectrum_from(balanced, _swept_roots(balanced, found.line), nodes, count, certify=True)
            found = swept if swept.status == "certified" else found
        enough = len(found.roots) >= min(count, _most_roots(system, count))
        if (found.status != "not certified" and enough) or nodes >= _MOST_NODES:
            return found
        if found.status == "certified" and nodes > 40 + 10 * count:
            return replace(found, status="certified, with fewer roots than asked: the rest lie far left, unresolved")
        nodes = min(_MOST_NODES, nodes + nodes // 2)


def _most_roots(system: DelayLTI, count: int) -> int:
    """As many roots as there can be: n where no delayed signal reaches a state."""
    return count if system.B2.any() and system.C2.any() else system.n_states


def _spectrum_from(balanced: DelayLTI, start: ComplexArray, nodes: int, count: int, *, certify: bool) -> Spectrum:
    """The rightmost roots that Newton finds from eigenvalues of `nodes` nodes, and whether the count agrees."""
    roots, errors = _polish(balanced, start[_is_possible(balanced, start)][: count + 6])
    many = _whole(roots, count)
    line = _line_left_of(roots, errors, many, 1e-5 / balanced.tau.max())
    while certify and line is None and many < len(roots):  # the next root shares the real part: take it along
        many = _whole(roots, many + 1)
        line = _line_left_of(roots, errors, many, 1e-5 / balanced.tau.max())
    kept, kept_errors = roots[:many], errors[:many]
    if line is None:
        return Spectrum(kept, kept_errors, float(kept[-1].real) if many else 0.0, nodes, "a root too near the line")
    if not certify:
        resolved = nodes >= _nodes_for(float(np.abs(kept).max(initial=0.0)) * balanced.tau.max())
        return Spectrum(kept, kept_errors, line, nodes, "not counted" if resolved else "not certified")
    counted = count_right_of(balanced, line)
    if counted.roots is None and many < len(roots) and _cluster_goes_on(roots, many):
        return _spectrum_from(balanced, start, nodes, many + 1, certify=True)
    agrees = counted.roots == many
    status = counted.status if counted.roots is None or agrees else "not certified"
    return Spectrum(kept, kept_errors, line, nodes, status)


def _line_left_of(roots: ComplexArray, errors: FloatArray, many: int, least: float) -> float | None:
    """A vertical line between root `many` and the next one on the left; None where the gap is too narrow.

    What is narrow is judged by these two roots: a fast root far right does not blur a chain of slow ones.
    """
    if many == 0:
        return None
    last = float(roots[many - 1].real)
    size = float(np.abs(roots[many - 1 : many + 1]).max())
    if many == len(roots):
        return last - max(0.02 * size, least)
    gap = last - float(roots[many].real)
    narrow = 1e-9 * size + 10.0 * float(errors[many - 1] + errors[many])
    return last - min(0.5 * gap, 0.05 * size) if gap > narrow else None


def _cluster_goes_on(roots: ComplexArray, many: int) -> bool:
    """Whether the next root is a near neighbour: a count between roots of a cluster takes steps without end."""
    distance = np.abs(roots[:many] - roots[many]).min()
    return bool(distance < 0.6 * np.abs(roots[many]))


def _is_possible(system: DelayLTI, roots: ComplexArray) -> NDArray[np.bool_]:
    """Whether |s| <= ||A|| + ||B2|| ||(I - E D22)^-1 E C2||, E = diag exp(-tau Re s), as for every root of the system.

    Weak feedback has its later roots far left, where collocation also puts eigenvalues that are roots of nothing.
    """
    growth = np.exp(np.minimum(-roots.real[:, None] * system.tau, 200.0))
    reading = np.abs(system.C2).sum(axis=1)
    chain = growth * reading
    for _ in range(system.n_delays if system.D22.any() else 0):  # exact: D22 is nilpotent
        chain = growth * (reading + chain @ np.abs(system.D22).T)
    bound = (np.abs(system.A).sum(axis=1) + chain @ np.abs(system.B2).T).max(axis=1, initial=0.0)
    return np.abs(roots) <= 1.5 * bound + 1e-3 / system.tau.max()


def _nodes_for(radius: float) -> int:
    """Chebyshev nodes that resolve exp(-s theta), 0 <= theta <= 1, for |s| <= radius to better than Newton needs."""
    return int(min(_MOST_NODES, np.ceil(10.0 + 0.75 * radius)))


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
    """Eigenvalues of states and transport lines v_t = -v_theta / tau, v(0) = z, w = v(1); rightmost first."""
    return _ordered(
        np.linalg.eigvals(_collocation(system.A, system.B2, system.D22, system, nodes)).astype(np.complex128)
    )


def _swept_roots(system: DelayLTI, line: float) -> ComplexArray:
    """Eigenvalues with imag >= 0 around points j w0 of the imaginary axis, up to where roots right of `line` can lie.

    With s = j w0 + sigma the loop is that of A - j w0 and exp(-j w0 tau) w: few nodes resolve each stretch of the axis,
    so the cost grows like the highest frequency, and not like its cube.
    """
    half = 0.6 * _WINDOW_NODES / system.tau.max()
    reach = min(root_bound(system, min(line, 0.0)), 1e3 * half)
    found = [_collocated_roots(system, 2 * _WINDOW_NODES)]
    found[0] = found[0][(found[0].imag >= 0) & (found[0].imag < half)]
    for w0 in np.arange(2 * half, reach + half, 2 * half):
        turned = np.exp(-1j * w0 * system.tau)
        A = system.A - 1j * w0 * np.eye(system.n_states)
        M = _collocation(A, system.B2 * turned, system.D22 * turned, system, _WINDOW_NODES)
        near = np.linalg.eigvals(M)
        found.append(near[(near.imag >= -half) & (near.imag < half)] + 1j * w0)
    return _ordered(np.concatenate(found))


def _collocation(
    A: NDArray[np.inexact], B2: NDArray[np.inexact], D22: NDArray[np.inexact], system: DelayLTI, nodes: int
) -> NDArray[np.inexact]:
    """Matrix of states and transport lines, with `nodes` nodes for the longest delay."""
    n = system.n_states
    counts = np.maximum(6, np.ceil(nodes * system.tau / system.tau.max())).astype(np.intp)
    ends = n + np.cumsum(counts) - 1
    size = n + int(counts.sum())
    M = np.zeros((size, size), dtype=A.dtype)
    M[:n, :n] = A
    M[:n, ends] = B2
    for i, tau in enumerate(system.tau):
        D = _chebyshev_differentiation(int(counts[i])) / tau
        rows = slice(int(ends[i] - counts[i]) + 1, int(ends[i]) + 1)
        M[rows, rows] = -D[1:, 1:]
        M[rows, :n] += np.outer(-D[1:, 0], system.C2[i])
        M[rows, ends] += np.outer(-D[1:, 0], D22[i])
    return M


def _polish(system: DelayLTI, start: ComplexArray) -> tuple[ComplexArray, FloatArray]:
    """Newton with implicit deflation on the upper half; returns roots by falling real part and their last steps.

    A start that Newton carries far away was no root of the exact system, and two starts apart that meet were one: both
    are dropped, for the count to notice if a root is missing.
    """
    x = system
    upper = start[start.imag >= 0]
    roots = upper.copy()
    paired = roots.imag > 0
    # copies are writeable, so that one compiled signature serves all
    blocks = (x.A.copy(), x.B2.copy(), x.C2.copy(), x.D22.copy(), x.tau.copy())
    steps = newton.polish(blocks, roots, paired, 40)
    roots.imag = np.abs(roots.imag)
    near = np.abs(roots - upper) <= 0.1 * np.abs(upper) + 1e-3 / x.tau.max()
    # three roots that meet are known to eps^(1/3); what still moves by more circles around a root that others hold
    keep = near & (steps <= 1e-4 * np.abs(roots) + 1e-12 / x.tau.max())
    for k in np.flatnonzero(keep):
        twins = keep[:k] & (np.abs(roots[:k] - roots[k]) <= 1e-7 * np.abs(roots[k]) + 1e-13 / x.tau.max())
        if (np.abs(upper[:k] - upper[k])[twins] > 1e-2 * np.abs(upper[k])).any():
            keep[k] = False
    roots, steps, paired = roots[keep], steps[keep], paired[keep]
    pairs = np.concatenate([roots, roots[paired].conj()])
    errors = np.maximum(np.concatenate([steps, steps[paired]]), _cluster_size(pairs))
    order = _order(pairs)
    return pairs[order], errors[order]


def _cluster_size(roots: ComplexArray) -> FloatArray:
    """Distance to the farthest root of the same tight cluster: none of them is known better than their spread."""
    gaps = np.abs(roots[:, None] - roots[None, :])
    return np.where(gaps < 1e-4 * np.abs(roots), gaps, 0.0).max(axis=0, initial=0.0)


def _order(roots: ComplexArray) -> NDArray[np.intp]:
    """By falling real part (to rounding), then rising |imag|, upper half first."""
    scale = np.abs(roots).max(initial=0.0) * 1e-12 + 1e-300
    return np.lexsort((-roots.imag, np.abs(roots.imag), -np.round(roots.real / scale)))


def _ordered(roots: ComplexArray) -> ComplexArray:
    return roots[_order(roots)]


def _whole(roots: ComplexArray, count: int) -> int:
    """How many of the roots make up the first `count`, one more if the last would leave its conjugate behind."""
    head = min(count, len(roots))
    splits = 0 < head < len(roots) and roots[head - 1].imag > 0
    return head + 1 if splits else head

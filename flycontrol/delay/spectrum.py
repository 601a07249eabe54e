"""Rightmost characteristic roots: Chebyshev collocation, Newton on the exact equation, and a count that certifies."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flycontrol.delay.characteristic import CharacteristicBlocks, characteristic_blocks
from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.count import MOST_STEPS, STATUS
from flycontrol.delay.kernels import rightmost, winding
from flycontrol.delay.system import ComplexArray, FloatArray, require_retarded
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flycontrol.delay.convert import Operand

_MOST_NODES = 400
_FIRST_NODES = 60  # a count tells whether they were enough; the bound on the roots of a stiff plant asks for far more
_SWEPT_NODES = 130  # from here on the missing roots are sought around points higher up the imaginary axis
_LARGEST_EXPONENT = 700.0  # exp of more overflows
_WINDOW_NODES = 30  # of each such point: the cost of a stretch of the axis is least about there


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """Rightmost roots of a delay system."""

    roots: ComplexArray  #: [1/s], by falling real part, conjugates next to each other, upper one first
    errors: FloatArray  #: estimated error of each root: its last Newton step [1/s]
    line: float  #: every root with Re s > line is listed, if `status` is "certified" [1/s]
    nodes: int  #: collocation nodes of the longest delay; 0 without delays
    #: "certified", "certified, with fewer roots than asked: ..." when the others lie beyond what collocation resolves,
    #: "not certified", "a root too near the line", or "not counted" without `certify`
    status: str

    @property
    def certified(self) -> bool:
        """Whether a count by the argument principle found no other root with Re s > line."""
        return self.status.startswith("certified")

    @property
    def abscissa(self) -> float:
        """Real part of the rightmost root [1/s]; -inf for a system without roots, NaN if none was found for certain."""
        if len(self.roots):
            return float(self.roots[0].real)
        return -np.inf if self.certified else np.nan

    def plot(self, **options: Any) -> Axes:
        """Draw it; options and return value as in `pole_plot`."""
        from flycontrol.delay.plots import pole_plot

        return pole_plot(self, **options)


def rightmost_roots(system: Operand, count: int = 10, *, certify: bool = True) -> Spectrum:
    """The `count` rightmost roots of det [[s I - A, -B2], [-E C2, I - E D22]] = 0 (one more if it would split a pair).

    Each delay channel is a transport line, collocated at Chebyshev points; the eigenvalues of states and lines start a
    Newton iteration with implicit deflation (Ehrlich-Aberth) on the exact equation. The number of roots right of a line
    just left of the last one is then counted by the argument principle; nodes are added until both agree. Without
    `certify` it is counted only where that costs less than the nodes that a bound on the roots asks for.

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
    if system.n_delays == 0 or system.n_states == 0:
        return _of_matrix(system.A, count)
    blocks = characteristic_blocks(system)
    winding.scale(blocks.A, blocks.B2, blocks.C2, blocks.D22)
    bound = winding.radius(blocks.A, blocks.B2, blocks.C2, blocks.D22, np.ones(len(blocks.tau)))
    fewest, resolving = max(8 + count, _FIRST_NODES), max(8 + count, _nodes_for(bound * blocks.tau.max()))
    return _sought(blocks, count, min(fewest, resolving), certify=certify or resolving > fewest)


def _of_matrix(A: FloatArray, count: int) -> Spectrum:
    """The first `count` eigenvalues, for a system without states or delays."""
    roots = np.linalg.eigvals(A).astype(np.complex128)
    size = np.abs(roots).max(initial=0.0)
    order = np.lexsort((-roots.imag, np.abs(roots.imag), -np.round(roots.real / (1e-12 * size + 1e-300))))
    roots = roots[order]
    many = min(count, len(roots))
    many += 0 < many < len(roots) and roots[many - 1].imag > 0
    return Spectrum(roots[:many], np.full(many, np.finfo(float).eps * size), -np.inf, 0, "certified")


def _sought(blocks: CharacteristicBlocks, count: int, nodes: int, *, certify: bool) -> Spectrum:
    """The spectrum of a scaled system, from `nodes` nodes or as many more as it takes."""
    while True:
        found = _spectrum_from(blocks, _collocated(blocks, nodes), nodes, count, certify=certify)
        if certify and found.status == "not certified" and nodes >= _SWEPT_NODES:
            swept = _spectrum_from(blocks, _swept(blocks, found.line), nodes, count, certify=True)
            found = swept if swept.status == "certified" else found
        enough = len(found.roots) >= count or len(found.roots) >= _most_roots(blocks, count)
        if (found.status != "not certified" and enough) or nodes >= _MOST_NODES:
            return _first(found, count) if certify and found.status == "not certified" else found
        if found.status == "certified" and nodes > 40 + 10 * count:
            return replace(found, status="certified, with fewer roots than asked: the rest lie far left, unresolved")
        nodes = min(_MOST_NODES, nodes + nodes // 2)


def _first(found: Spectrum, count: int) -> Spectrum:
    """No more roots than asked for, where the others were only there for a count that failed."""
    many = min(count, len(found.roots))
    many += 0 < many < len(found.roots) and found.roots[many - 1].imag > 0
    return replace(found, roots=found.roots[:many], errors=found.errors[:many])


def _most_roots(blocks: CharacteristicBlocks, count: int) -> int:
    """As many roots as there can be: n where no delayed signal reaches a state."""
    return count if blocks.B2.any() and blocks.C2.any() else len(blocks.A)


def _spectrum_from(
    blocks: CharacteristicBlocks, eigenvalues: ComplexArray, nodes: int, count: int, *, certify: bool
) -> Spectrum:
    """The rightmost roots that Newton finds from eigenvalues of `nodes` nodes, and whether the count agrees."""
    longest = blocks.tau.max()
    while True:
        roots, errors, line, cluster = rightmost.rightmost(*blocks, longest, eigenvalues, count, certify)
        if math.isnan(line):
            line = float(roots[-1].real) if len(roots) else 0.0
            return Spectrum(roots, errors, line, nodes, "a root too near the line")
        if not certify:
            resolved = nodes >= _nodes_for(np.abs(roots).max() * longest)
            return Spectrum(roots, errors, line, nodes, "not counted" if resolved else "not certified")
        counted, _ = winding.count_right_of(*blocks, line, MOST_STEPS)
        if counted >= 0 or not cluster:
            break
        count = len(roots) + 1
    agrees = counted == len(roots)
    status = STATUS[counted] if counted < 0 else "certified" if agrees else "not certified"
    return Spectrum(roots, errors, line, nodes, status)


def _nodes_for(radius: float) -> int:
    """Chebyshev nodes that resolve exp(-s theta), 0 <= theta <= 1, for |s| <= radius to better than Newton needs."""
    return min(_MOST_NODES, math.ceil(10.0 + 0.75 * min(radius, 1e9)))


def _collocated(blocks: CharacteristicBlocks, nodes: int) -> ComplexArray:
    """Eigenvalues of states and transport lines v_t = -v_theta / tau, v(0) = z, w = v(1)."""
    return np.linalg.eigvals(rightmost.collocation(*blocks, blocks.tau.max(), nodes)).astype(np.complex128)


def _swept(blocks: CharacteristicBlocks, line: float) -> ComplexArray:
    """Eigenvalues with imag >= 0 around points j w0 of the imaginary axis, up to where roots right of `line` can lie.

    With s = j w0 + sigma the loop is that of A - j w0 and exp(-j w0 tau) w: few nodes resolve each stretch of the axis,
    so the cost grows like the highest frequency, and not like its cube.
    """
    A, B2, C2, D22, tau = blocks
    longest = tau.max()
    half = 0.6 * _WINDOW_NODES / longest
    reach = min(
        winding.radius(A, B2, C2, D22, np.exp(np.minimum(-min(line, 0.0) * tau, _LARGEST_EXPONENT))), 1e3 * half
    )
    centre = _collocated(blocks, 2 * _WINDOW_NODES)
    found = [centre[(centre.imag >= 0) & (centre.imag < half)]]
    for w0 in np.arange(2 * half, reach + half, 2 * half):
        turned = np.exp(-1j * w0 * tau)
        shifted = A - 1j * w0 * np.eye(len(A))
        M = rightmost.collocation(shifted, B2 * turned, C2, D22 * turned, tau, longest, _WINDOW_NODES)
        near = np.linalg.eigvals(M)
        found.append(near[(near.imag >= -half) & (near.imag < half)] + 1j * w0)
    return np.concatenate(found)

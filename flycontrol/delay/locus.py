"""Root locus of a delay system in one parameter: exact roots, followed by continuation and counted at every value."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.bracket import bracketed_root
from flycontrol.delay.characteristic import matrix
from flycontrol.delay.continuation import Collision, Node, Walk, march
from flycontrol.delay.count import count_right_of
from flycontrol.delay.family import Family, Member
from flycontrol.delay.kernels import continuation
from flycontrol.delay.real import real_array, require_callable
from flycontrol.delay.spectrum import Spectrum, rightmost_roots
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["AxisCrossing", "Collision", "Entry", "RootLocus", "root_locus"]


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisCrossing:
    """Where a branch crosses the imaginary axis."""

    value: float  #: of the parameter
    frequency: float  #: imaginary part there [rad/s]
    rightward: bool  #: into the right half plane as the parameter rises
    branch: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A branch that came from the far left."""

    branch: int
    value: float  #: first of the values at which it is among the rightmost roots
    root: complex  #: [1/s]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RootLocus:
    """Branches of the rightmost roots over a parameter."""

    values: FloatArray  #: parameter values, shape (k,)
    branches: ComplexArray  #: roots with imag >= 0 [1/s], shape (branches, k); NaN where a branch is not
    crossings: tuple[AxisCrossing, ...] = ()  #: of the imaginary axis, by parameter value
    collisions: tuple[Collision, ...] = ()  #: double roots on the real axis, by parameter value
    entries: tuple[Entry, ...] = ()  #: branches that came from the far left
    status: str = "certified"  #: "certified", or what is not certain and where

    def __repr__(self) -> str:
        counts = f"{len(self.branches)} branches, {len(self.crossings)} crossings, {len(self.collisions)} collisions"
        return f"<RootLocus, {self.status}: {counts} over {self.values[0]:.4g}..{self.values[-1]:.4g}>"

    def plot(self, **options: Any) -> Axes:
        """Draw it; options and return value as in `root_locus_plot`."""
        from flycontrol.delay.plots import root_locus_plot

        return root_locus_plot(self, **options)


@dataclass(slots=True, eq=False)
class _Draft:
    """A locus in the making."""

    count: int
    walk: Walk
    next_branch: int = 0
    patience: int = 1  #: values to pass before roots too far left are sought again
    rest: int = 0  #: values still to pass
    entries: list[Entry] = field(default_factory=list[Entry])
    doubts: list[str] = field(default_factory=list[str])


def root_locus(system_at: Callable[[float], Member], values: ArrayLike, count: int = 8) -> RootLocus:
    """The branches that hold the `count` rightmost roots of system_at(v) at each value v, over the whole range.

    Branches are followed from value to value by their speed and Newton on the exact equation, with steps so short that
    no branch can jump (`flycontrol.delay.continuation`). At every value the argument principle counts the roots right
    of a line behind the `count`-th one; a root that is missing has entered from the left and is followed from there
    through the whole range. Where two real roots meet and become a pair, the right one goes on as the upper one of the
    pair and the left one ends; where a pair splits, its branch goes on to the right and a new one begins to the left.

    Parameters
    ----------
    system_at
        The system at a parameter value. Delays may depend on it; one that reaches zero at an end of the range must
        vanish there (`flycontrol.delay.interconnect.delay` does).
    values
        Strictly rising or falling parameter values, shape (k,), k >= 2.
    count
        Roots that are complete at every value, conjugates included (one more if a pair would be split; fewer where the
        others lie too far left to be resolved, as for a gain or a delay near zero).

    Raises
    ------
    InvalidParameterError
        If values do not rise or fall strictly, or the family refuses one of them.
    NeutralSystemError
        If a member is of neutral type.
    """
    require_callable(system_at, "The family of a root locus")
    grid = _checked(values)
    if not (isinstance(count, int | np.integer) and count >= 1):
        raise InvalidParameterError(f"A root locus needs an integer count >= 1, got {count!r}.")
    family = Family(system_at, np.array([grid.min()]), np.array([grid.max()]))
    draft = _Draft(count, Walk(family, float(grid[0])))
    for value in grid:
        draft.next_branch = march(draft.walk, float(value), draft.next_branch)
        _complete(draft, first=bool(value == grid[0]))
    _follow_back(draft, grid)
    return _finished(draft, grid)


def _checked(values: ArrayLike) -> FloatArray:
    grid = real_array(values, "Parameter values of a root locus")
    steps = np.diff(grid) if grid.ndim == 1 else np.zeros(0)
    if len(steps) == 0 or not ((steps > 0).all() or (steps < 0).all()):
        raise InvalidParameterError("A root locus needs at least two parameter values that rise or fall strictly.")
    if not np.isfinite(grid).all():
        raise InvalidParameterError("A root locus needs finite parameter values.")
    return grid


def _complete(draft: _Draft, *, first: bool) -> None:
    """Count the roots at the present value, and let branches begin where some are missing."""
    walk = draft.walk
    system = walk.family.system(np.array([walk.value]))
    draft.rest -= 1
    seen, missing = _missing(draft, system)
    for extra in (4, 8, 12, 16):
        if missing == 0 and (seen >= draft.count or draft.rest > 0):
            break
        # behind a root that went far left many may be missing, but not many of the rightmost
        wanted = max(draft.count, min(seen + missing, draft.count + extra))
        found = _certified_roots(system, wanted)
        known = walk.roots
        for root in _upper(found.roots):
            if np.abs(known - root).min(initial=np.inf) > 1e-7 * abs(root):
                _begin(draft, complex(root), first=first)
        # roots too far left to be found will come: ask less and less often
        draft.patience = 2 * draft.patience if len(found.roots) < wanted else 1
        draft.rest = draft.patience
        seen, missing = _missing(draft, system)
    walk.lost.clear()
    if missing != 0:
        draft.doubts.append(f"the count at {walk.value:g} differs from the roots followed")


def _certified_roots(system: DelayLTI, count: int) -> Spectrum:
    """The `count` rightmost roots, or more where that helps to certify them."""
    found = rightmost_roots(system, count)
    for more in (4, count):
        if not found.status.startswith("certified"):
            found = rightmost_roots(system, count + more)
    return found


def _upper(roots: ComplexArray) -> ComplexArray:
    """The roots with imag >= 0; a pair closer than a double root can be computed counts as two real roots."""
    double = (roots.imag != 0) & (np.abs(roots.imag) < 1e-7 * np.abs(roots))
    return np.where(double, roots.real + 0j, roots)[(roots.imag >= 0) | double]


def _missing(draft: _Draft, system: DelayLTI) -> tuple[int, int]:
    """How many roots of the walk were held against the count, and how many of those counted are on no branch."""
    roots = draft.walk.roots
    falling = -np.sort(-np.concatenate([roots, roots[roots.imag > 0]]).real)
    if len(falling) == 0:
        return 0, 0
    size = max(float(np.abs(roots).max()), 1e-3 * draft.walk.family.rate)
    for last in range(min(draft.count, len(falling)), len(falling) + 1):
        # where the next root on the left is not known, the line stays close to the last one
        gap = falling[last - 1] - falling[last] if last < len(falling) else 2e-3 * size
        if gap > 1e-5 * size:
            counted = count_right_of(system, float(falling[last - 1] - min(0.5 * gap, 0.05 * size))).roots
            if counted is not None:
                return last, counted - last
    draft.doubts.append(f"the roots at {draft.walk.value:g} could not be counted")
    return len(falling), 0


def _begin(draft: _Draft, root: complex, *, first: bool) -> None:
    """A new branch at the present value, or one that was lost on the way here, joined by the least jump."""
    walk = draft.walk
    lost = sorted(walk.lost, key=lambda gone: abs(gone[1].root - root))
    if lost and abs(lost[0][1].root - root) < 0.1 * abs(root) + abs(root.real):
        branch, node = lost[0]
        walk.lost.remove(lost[0])
        walk.start(branch, root)
        draft.doubts.append(f"roots between {node.value:.9g} and {walk.value:.9g} are joined by the least jump")
        return
    walk.start(draft.next_branch, root)
    if not first:
        draft.entries.append(Entry(branch=draft.next_branch, value=walk.value, root=root))
    draft.next_branch += 1


def _follow_back(draft: _Draft, grid: FloatArray) -> None:
    """Follow the branches that entered back to the first value, or to the far left."""
    known = _table(draft.walk.paths, draft.next_branch, grid)
    back = Walk(draft.walk.family, float(grid[-1]))
    for k in range(len(grid) - 1, 0, -1):
        back.value = float(grid[k])
        for entry in draft.entries:
            if entry.value == grid[k]:
                back.start(entry.branch, entry.root)
        draft.next_branch = march(back, float(grid[k - 1]), draft.next_branch)
        others = np.array([known[:, k - 1]])
        twice = np.abs(back.roots[:, None] - others).min(axis=1, where=np.isfinite(others), initial=np.inf)
        back.leave(twice <= 1e-9 * np.abs(back.roots))
    for branch, path in back.paths.items():
        draft.walk.paths[branch] = path[::-1] + draft.walk.paths.get(branch, [])[1:]
    for collision in back.collisions:
        draft.walk.meet(collision)


def _table(paths: dict[int, list[Node]], many: int, grid: FloatArray) -> ComplexArray:
    """The branches at the wanted values, shape (many, k); NaN where a branch is not."""
    column = {float(value): k for k, value in enumerate(grid)}
    table = np.full((many, len(grid)), np.nan + 0j)
    for branch, path in paths.items():
        for node in path:
            if node.value in column:
                table[branch, column[node.value]] = node.root
    return table


def _finished(draft: _Draft, grid: FloatArray) -> RootLocus:
    walk = draft.walk
    crossings = [
        crossing
        for branch, path in walk.paths.items()
        for crossing in _crossings(walk.family, branch, sorted(path, key=lambda node: node.value))
    ]
    doubts = [*dict.fromkeys(draft.doubts)]
    more = f" (and {len(doubts) - 1} more)" if len(doubts) > 1 else ""
    return RootLocus(
        values=grid,
        branches=_table(walk.paths, draft.next_branch, grid),
        crossings=tuple(sorted(crossings, key=lambda crossing: crossing.value)),
        collisions=tuple(sorted(walk.collisions, key=lambda collision: collision.value)),
        entries=tuple(draft.entries),
        status=f"not certified: {doubts[0]}{more}" if doubts else "certified",
    )


def _crossings(family: Family, branch: int, path: list[Node]) -> list[AxisCrossing]:
    """Sign changes of the real part along a path of rising values, each solved for."""
    size = max(abs(node.root) for node in path)
    away = [node for node in path if abs(node.root.real) > 1e-12 * size]
    found: list[AxisCrossing] = []
    for a, b in pairwise(away):
        if a.root.real * b.root.real < 0:
            value, frequency = _crossing(family, a, b)
            found.append(AxisCrossing(value=value, frequency=frequency, rightward=b.root.real > 0, branch=branch))
    return found


def _crossing(family: Family, a: Node, b: Node) -> tuple[float, float]:
    """Parameter and frequency at which a branch crosses the axis between two nodes."""
    at_rest = _through_the_origin(family, a, b) if a.root.imag == 0.0 and b.root.imag == 0.0 else None
    if at_rest is not None:
        return at_rest, 0.0
    value = bracketed_root(lambda v: _root_between(family, a, b, v).real, a.value, b.value)
    return value, _root_between(family, a, b, value).imag


def _through_the_origin(family: Family, a: Node, b: Node) -> float | None:
    """Where det M(0) = 0 between two nodes of a real branch: as smooth in the parameter as the family itself.

    The root is not, where another one is near: what is left of it after Newton hides where it crosses. None if M(0) is
    singular an even number of times or not at all between the nodes, or where the family changes its structure.
    """

    def determinant(value: float) -> float:
        return float(np.linalg.det(matrix(family.blocks(np.array([value])), 0.0).real))

    if not determinant(a.value) * determinant(b.value) < 0:
        return None
    return bracketed_root(determinant, a.value, b.value)


def _root_between(family: Family, a: Node, b: Node, value: float) -> complex:
    """The root at a value between two neighbouring nodes of a branch, by Newton from the cubic through both."""
    width = b.value - a.value
    x = (value - a.value) / width
    bend_a, bend_b = a.speed * width, b.speed * width
    start = a.root + x * (
        bend_a + x * ((3 * (b.root - a.root) - 2 * bend_a - bend_b) + x * (bend_a + bend_b - 2 * (b.root - a.root)))
    )
    if a.root.imag == 0.0 and b.root.imag == 0.0:
        start = complex(start.real)
    roots, _ = continuation.correct(*family.blocks(np.array([value])), np.array([start]), family.rate)
    return complex(roots[0])

"""Root locus of a delay system in one parameter: exact roots at each value, joined into branches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class RootLocus:
    """Branches of the rightmost roots over a parameter."""

    values: FloatArray  #: parameter values, shape (k,)
    branches: ComplexArray  #: roots with imag >= 0 [1/s], shape (branches, k); NaN where a branch has left the window


def root_locus(system_at: Callable[[float], DelayLTI], values: ArrayLike, count: int = 8) -> RootLocus:
    """Roots in the upper half plane among the `count` rightmost of system_at(v) for each v, joined by least total jump.

    A pair that meets on the real axis becomes two real branches; the one that has no partner starts anew there.
    """
    grid = np.asarray(values, dtype=np.float64)
    branches: list[dict[int, complex]] = []
    open_ends: list[int] = []
    for k, value in enumerate(grid):
        roots = rightmost_roots(system_at(float(value)), count).roots
        upper = roots[roots.imag >= 0]
        open_ends = _extend(branches, open_ends, k, upper)
    table = np.full((len(branches), len(grid)), np.nan + 0j)
    for row, branch in enumerate(branches):
        table[row, list(branch)] = list(branch.values())
    return RootLocus(grid, table)


def _extend(branches: list[dict[int, complex]], open_ends: list[int], k: int, roots: ComplexArray) -> list[int]:
    """Join the roots at step k to the branches that reach step k - 1; the rest start new branches."""
    ends = np.array([branches[b][k - 1] for b in open_ends], dtype=np.complex128)
    cost = np.abs(ends[:, None] - roots[None, :])
    rows, columns = linear_sum_assignment(cost)
    far = 0.5 * (np.abs(roots).max(initial=0.0) + 1.0)
    joined = {int(c): open_ends[int(r)] for r, c in zip(rows, columns, strict=True) if cost[r, c] < far}
    now: list[int] = []
    for c, root in enumerate(roots):
        if c not in joined:
            joined[c] = len(branches)
            branches.append({})
        branches[joined[c]][k] = complex(root)
        now.append(joined[c])
    return now

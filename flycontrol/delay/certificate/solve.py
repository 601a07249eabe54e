"""Matrices of a functional, as far inside their inequalities as a solver can find them. The only user of cvxpy here."""

from __future__ import annotations

import warnings
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flycontrol.delay.certificate.functional import Readings, dissipation, storage
from flycontrol.delay.system import FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    import cvxpy as cp

# tighter than the solver's habit: near the largest delay all that is left to find is small
_CLARABEL = {"tol_gap_abs": 1e-11, "tol_gap_rel": 1e-11, "tol_feas": 1e-11}


class Candidate(NamedTuple):
    """What a solver proposes; NaN where it gave up. Nothing is proved yet."""

    P: FloatArray
    S: FloatArray
    R: FloatArray
    statement: str  #: the solver's word; "optimal_inaccurate" is usual with these tolerances


def candidate(ends: tuple[Readings, ...], ratio: FloatArray, sizes: tuple[int, ...], solver: str) -> Candidate:
    """Maximise t subject to Theta, S, R, Q at both ends >= t I and tr Theta + tr S + tr R = 1.

    The problem is feasible and bounded whatever the loop is, so that t itself tells and not a solver's verdict
    on feasibility. `ratio` are the longest delays over t0, shape (q,); `sizes` as in `DelayedSignals`.

    Raises
    ------
    InvalidParameterError
        If the solver is not installed.
    """
    import cvxpy as cp

    if solver not in cp.installed_solvers():
        raise InvalidParameterError(f"The solver {solver!r} is not installed; cvxpy finds {cp.installed_solvers()!r}.")
    P, S, R = _directions(len(ends[0].state), sizes)
    theta = storage(ends[-1], ratio, P, S)
    entries, slack = cp.Variable(len(P)), cp.Variable()
    inside: list[cp.Constraint] = []
    for stack in (theta, S, R, *[dissipation(end, P, S, R) for end in ends]):
        rows = stack.shape[1]
        matrix = cp.reshape(stack.reshape(len(stack), -1).T @ entries, (rows, rows), order="F")
        inside.append(cp.PSD(matrix - slack * np.eye(rows)))
    trace = sum(np.trace(stack, axis1=1, axis2=2) for stack in (theta, S, R))
    statement = _solve(cp.Problem(cp.Maximize(slack), [*inside, cp.Zero(trace @ entries - 1)]), solver)
    value = np.full(len(P), np.nan) if entries.value is None else np.asarray(entries.value)
    return Candidate(
        P=np.tensordot(value, P, 1), S=np.tensordot(value, S, 1), R=np.tensordot(value, R, 1), statement=statement
    )


def _directions(rows: int, sizes: tuple[int, ...]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A basis of all symmetric P, block-diagonal S and R: stacks of equal length, one matrix nonzero at a time."""
    q = sum(sizes)
    whole = _symmetric_units(0, rows, rows)
    starts = np.cumsum((0, *sizes))
    blocks = np.concatenate([_symmetric_units(int(a), int(b), q) for a, b in pairwise(starts)])
    none = np.zeros_like(blocks)
    return (
        np.concatenate([whole, np.zeros((2 * len(blocks), rows, rows))]),
        np.concatenate([np.zeros((len(whole), q, q)), blocks, none]),
        np.concatenate([np.zeros((len(whole), q, q)), none, blocks]),
    )


def _symmetric_units(start: int, stop: int, size: int) -> FloatArray:
    """Matrices (size, size) that span the symmetric ones in rows and columns start to stop."""
    i, j = (start + k for k in np.tril_indices(stop - start))
    stack = np.zeros((len(i), size, size))
    each = np.arange(len(i))
    stack[each, i, j] = stack[each, j, i] = 1.0
    return stack


def _solve(problem: cp.Problem, solver: str) -> str:
    """The solver's statement in its own words."""
    import cvxpy as cp

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # "may be inaccurate" is in the statement, and the check decides
        try:
            problem.solve(solver=solver, **(_CLARABEL if solver == "CLARABEL" else {}))
        except cp.SolverError as failure:
            return f"no solution ({failure})"
    return str(problem.status)

"""Positive definiteness of a symmetric matrix that is known to within rounding."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.delay.system import FloatArray

_UNIT_ROUNDOFF = float(np.finfo(np.float64).eps) / 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Definiteness:
    """Whether a matrix is positive definite, every rounding allowed for."""

    name: str  #: what the matrix is
    smallest_eigenvalue: float  #: as computed; NaN if the solver gave no numbers
    margin: float  #: what all roundings together can take from it
    proved: bool


def rounding(operations: int) -> float:
    """gamma_k = k u / (1 - k u), the relative error of k roundings in any order (Higham 2002, Lemma 3.1)."""
    return operations * _UNIT_ROUNDOFF / (1.0 - operations * _UNIT_ROUNDOFF)


def definiteness(name: str, matrix: FloatArray, error: FloatArray) -> Definiteness:
    """M > 0 for every symmetric M with |M - matrix| <= error, entry by entry.

    If the Cholesky factorisation of a matrix G of n rows runs to its end in floating point, then
    lambda_min(G) >= -gamma_(n+1) / (1 - gamma_(n+1)) tr G (Rump 2006, "Verification of positive definiteness", BIT 46).
    G is `matrix` less the margin: ||error||_inf >= ||error||_2, and that bound twice for its own rounding.
    """
    if not (np.isfinite(matrix).all() and np.isfinite(error).all()):
        return Definiteness(name=name, smallest_eigenvalue=np.nan, margin=np.nan, proved=False)
    symmetric = (matrix + matrix.T) / 2
    n = len(symmetric)
    size = float(np.abs(np.diag(symmetric)).sum())
    margin = 1.01 * float(error.sum(axis=1).max()) + 2.0 * rounding(n + 4) * size
    smallest = float(np.linalg.eigvalsh(symmetric)[0])
    try:
        np.linalg.cholesky(symmetric - margin * np.eye(n))
    except np.linalg.LinAlgError:
        return Definiteness(name=name, smallest_eigenvalue=smallest, margin=margin, proved=False)
    return Definiteness(name=name, smallest_eigenvalue=smallest, margin=margin, proved=True)

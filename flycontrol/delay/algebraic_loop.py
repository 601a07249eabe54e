"""Direct paths around a loop: the signals that they determine at once, or the reason why they do not."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from flycontrol.delay.system import FloatArray
from flycontrol.errors import AlgebraicLoopError

_NEARLY_SINGULAR = 1e-12


def closed_directly(direct: FloatArray) -> FloatArray:
    """(I - M)^-1 of direct gains M (m, m) among signals u = M u + v, with exact zeros where no path leads.

    Substitution along the paths, with a linear solve only for signals that feed each other: gains of any size in a
    chain are no reason to suspect a loop, and rounding invents no path (a false one can make a retarded system look
    neutral).

    Raises
    ------
    AlgebraicLoopError
        If some signals that feed each other have no unique solution, to 12 digits after balancing their units.
    """
    m = len(direct)
    inverse = np.zeros((m, m))
    leads = _paths(direct != 0)
    mutual = leads & leads.T
    solved = np.zeros(m, dtype=bool)
    for signal in np.argsort(leads.sum(axis=1), kind="stable"):  # upstream first
        if not solved[signal]:
            group = np.flatnonzero(mutual[signal])
            inverse[group] = _solve(direct[group][:, group], np.eye(m)[group] + direct[group] @ inverse)
            solved[group] = True
    return inverse


def _paths(direct: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Entry i, j: whether a path leads from signal j to signal i; every signal reaches itself."""
    leads = direct | np.eye(len(direct), dtype=bool)
    for _ in range(len(direct).bit_length()):
        leads = leads @ leads
    return leads


def _solve(direct: FloatArray, right: FloatArray) -> FloatArray:
    """(I - M)^-1 R for signals that all feed each other."""
    if not direct.any():
        return right
    _, (units, _) = scipy.linalg.matrix_balance(direct, permute=False, separate=True)
    balanced = direct * units / units[:, None]
    loop = np.eye(len(direct)) - balanced
    singular_values = np.linalg.svd(loop, compute_uv=False)
    if singular_values[-1] <= _NEARLY_SINGULAR * (1.0 + np.linalg.norm(balanced, 2)):
        raise AlgebraicLoopError(
            "The undelayed direct path around the loop has gain 1, so it has no unique solution; "
            "put a delay or a lag into the loop, or feed back the plant's derivative output instead of differentiating."
        )
    return np.asarray(units[:, None] * np.linalg.solve(loop, right / units[:, None]), dtype=np.float64)

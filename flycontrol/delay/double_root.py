"""Where two roots meet on the real axis: f(s, p) = f_s(s, p) = 0."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flycontrol.delay.characteristic import matrix, matrix_derivative
from flycontrol.delay.family import Family
from flycontrol.delay.system import FloatArray

_MOST_STEPS = 25
_FAR_LEFT = 300.0  # -s tau beyond which exp(-s tau) squared overflows


class DoubleRoot(NamedTuple):
    """A real double root; near it the two roots are root +- sqrt(curvature (p - value))."""

    value: float  #: of the parameter
    root: float  #: [1/s]
    curvature: float  #: d (s - root)^2 / dp


def double_root_near(family: Family, value: float, root: float) -> DoubleRoot | None:
    """Newton on (f, f_s) = 0 in the real unknowns s and p; None if it does not converge inside the family's range.

    f is the bordered determinant g = -u' M v with u, v the singular vectors of M's smallest singular value, which
    vanishes where det M does and stays smooth and well scaled there (Govaerts 2000, section 4.1).
    """
    s, p, last = root, value, np.inf
    span = float(family.high[0] - family.low[0])
    for _ in range(_MOST_STEPS):
        terms = _bordered(family, s, p)
        if terms is None:
            return None
        g, g_s, g_ss, g_p, g_sp = terms
        determinant = g_s * g_sp - g_p * g_ss
        if determinant == 0.0:
            return None
        ds = (g_p * g_s - g_sp * g) / determinant
        dp = (g_ss * g - g_s * g_s) / determinant
        inside = min(max(p + dp, float(family.low[0])), float(family.high[0]))
        change = abs(ds) / (abs(s) + 1e-6 * family.rate) + abs(dp) / span
        s, p = s + ds, inside
        if not np.isfinite(change):
            return None
        if change < 1e-14 or (change < 1e-9 and change >= 0.5 * last):
            return DoubleRoot(p, s, -2.0 * g_p / g_ss) if g_ss != 0.0 and g_p != 0.0 else None
        last = change
    return None


def _bordered(family: Family, s: float, p: float) -> tuple[float, float, float, float, float] | None:
    """g, g_s, g_ss, g_p and g_sp at (s, p); None where the family changes its structure."""
    point = np.array([p])
    blocks, beside = family.blocks(point), family.neighbours(point, 0)
    if beside is None or not -s * blocks.tau.max(initial=0.0) < _FAR_LEFT:
        return None
    U, sigma, Vh = np.linalg.svd(matrix(blocks, s).real)
    u, v = U[:, -1], Vh[-1]
    M_s, M_ss = (matrix_derivative(blocks, s, order).real for order in (1, 2))
    M_p = (matrix(beside.after, s) - matrix(beside.before, s)).real / beside.width
    M_sp = (matrix_derivative(beside.after, s) - matrix_derivative(beside.before, s)).real / beside.width

    def moved(M_x: FloatArray) -> FloatArray:  # derivative of v
        return -Vh[:-1].T @ ((U[:, :-1].T @ (M_x @ v)) / sigma[:-1])

    v_s, v_p = moved(M_s), moved(M_p)
    g_ss = -u @ (M_ss @ v + 2.0 * M_s @ v_s)
    g_sp = -u @ (M_sp @ v + M_s @ v_p + M_p @ v_s)
    return float(-sigma[-1]), float(-u @ M_s @ v), float(g_ss), float(-u @ M_p @ v), float(g_sp)

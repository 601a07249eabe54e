"""A wing as a few blade elements: Gauss nodes for the chord's own distribution along the span.

n nodes integrate c(r) f(r) dr exactly for polynomials f of degree 2n - 1, so six are better than twenty even blades.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh_tridiagonal
from scipy.special import roots_jacobi

from flycontrol.errors import InvalidParameterError
from flycontrol.model.planform import Planform, beta_exponents

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class BladeElements:
    """Blades of one wing: the sum of area * f(radius) is the integral of c(r) f(r) dr."""

    radius: FloatArray  #: (m,) from the hinge [m]
    area: FloatArray  #: (m,) chord times width of each blade [m^2]


def beta_blades(length: float, mean_chord: float, second_moment_radius: float, nodes: int = 6) -> BladeElements:
    """c(r) ~ r^(p-1) (1-r)^(q-1): Gauss-Jacobi nodes for Ellington's beta distribution.

    Parameters
    ----------
    length : R [m]
    mean_chord : area / R [m]
    second_moment_radius : r2 / R
    """
    p, q = beta_exponents(second_moment_radius)
    x, weight = roots_jacobi(nodes, q - 1.0, p - 1.0)
    return BladeElements(radius=length * (1 + x) / 2, area=length * mean_chord * weight / weight.sum())


def table_blades(span: FloatArray, chord: FloatArray, length: float, area: float, nodes: int = 6) -> BladeElements:
    """Gauss nodes for a chord table, linear between its rows (Golub & Welsch, on a discretised measure).

    Parameters
    ----------
    span : (k,) position as a fraction of the wing length, rising from 0 to 1
    chord : (k,) chord, any scale: the wing's area sets it
    length : R [m]
    area : of one wing [m^2]
    """
    if not (np.all(np.diff(span) > 0) and np.all(chord >= 0) and np.any(chord > 0)):
        raise InvalidParameterError("A chord table needs rising span positions and chords >= 0, some of them > 0.")
    x, w = _panels(span)
    measure = w * np.interp(x, span, chord)
    node, weight = _gauss(x, measure / measure.sum(), nodes)
    return BladeElements(radius=length * node, area=area * weight)


def planform_blades(planform: Planform, nodes: int = 6) -> BladeElements:
    """Gauss nodes for a wing's own chords: a table where it has one, the beta distribution otherwise."""
    table = planform.table
    if table is None:
        return beta_blades(planform.length, planform.mean_chord, planform.second_moment_radius, nodes)
    area = planform.length * planform.mean_chord
    return table_blades(np.array(table.span), np.array(table.chord), planform.length, area, nodes)


def _panels(span: FloatArray, order: int = 8) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre points and weights, panel by panel of the table."""
    x, w = np.polynomial.legendre.leggauss(order)
    half = np.diff(span) / 2
    middle = (span[1:] + span[:-1]) / 2
    return (middle[:, None] + half[:, None] * x).ravel(), (half[:, None] * w).ravel()


def _gauss(x: FloatArray, measure: FloatArray, nodes: int) -> tuple[FloatArray, FloatArray]:
    """Stieltjes' three-term recurrence, then the eigenvalues of its Jacobi matrix."""
    before, now = np.zeros_like(x), np.ones_like(x)
    diagonal, norms = np.empty(nodes), np.empty(nodes)
    for j in range(nodes):
        norms[j] = np.sum(measure * now**2)
        diagonal[j] = np.sum(measure * x * now**2) / norms[j]
        ratio = norms[j] / norms[j - 1] if j else 0.0
        before, now = now, (x - diagonal[j]) * now - ratio * before
    values, vectors = eigh_tridiagonal(diagonal, np.sqrt(norms[1:] / norms[:-1]))
    return values, vectors[0] ** 2

"""Coefficients as P(z^2) + z Q(z^2), z = sin(a - 45 deg): what the compiled blades evaluate.

A function that is smooth in the attack angle is smooth in z; the nearest singularities of arcsin lie at z^2 = 1, three
half-widths from the middle of 0 <= z^2 <= 1/2, so the error shrinks by 3 + sqrt(8) = 5.8 a term.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial
from numpy.typing import NDArray

from flycontrol.flight.coefficients import COEFFICIENTS, CoefficientName
from flycontrol.flight.kernels.air import TERMS

FloatArray = NDArray[np.float64]


@cache
def coefficient_series(name: CoefficientName) -> FloatArray:
    """(5, TERMS) polynomials in z^2, lowest power first: C_L even, odd, C_D even, odd, and arcsin(z) / z."""
    square, z = _chebyshev_points()
    ahead, behind = COEFFICIENTS[name](np.pi / 4 + np.arcsin(z)), COEFFICIENTS[name](np.pi / 4 - np.arcsin(z))
    values = [
        (ahead.lift + behind.lift) / 2,
        (ahead.lift - behind.lift) / (2 * z),
        (ahead.drag + behind.drag) / 2,
        (ahead.drag - behind.drag) / (2 * z),
        np.arcsin(z) / z,
    ]
    return np.ascontiguousarray([_power_series(square, value) for value in values])


def _chebyshev_points() -> tuple[FloatArray, FloatArray]:
    x = np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
    square = (1 + x) / 4
    return square, np.sqrt(square)


def _power_series(square: FloatArray, value: FloatArray) -> FloatArray:
    fitted = Chebyshev.fit(square, value, TERMS - 1, domain=[0.0, 0.5]).convert(kind=Polynomial)
    return np.pad(np.asarray(fitted.coef, dtype=np.float64), (0, TERMS - len(fitted.coef)))

"""Chord over the span of a wing: Ellington's beta distribution, or a table.

Its moments are integrals of c(r)^m r^n dr, m = 1: area; m = 2, 3, 4: rotation, added mass, dissipation.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import beta

from flycontrol.errors import InvalidParameterError

FloatArray = NDArray[np.float64]

_POINTS = 4000  # in an angle that clusters them at root and tip: errors below 1e-9 where c ~ sqrt(r)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChordTable:
    """Chord at positions along the span, linear in between; any scale, the wing's area sets it."""

    span: tuple[float, ...]  #: fractions of the wing length, rising from 0 to 1
    chord: tuple[float, ...]

    def __post_init__(self) -> None:
        span, chord = np.array(self.span), np.array(self.chord)
        if not (len(span) == len(chord) >= 2 and np.all(np.diff(span) > 0) and span[0] == 0.0 and span[-1] == 1.0):
            raise InvalidParameterError(
                "A chord table needs as many chords as span positions, and positions that rise from 0 at the hinge to "
                "1 at the tip, in fractions of the wing length."
            )
        if not (np.all(chord >= 0) and np.any(chord > 0) and np.all(np.isfinite(chord))):
            raise InvalidParameterError("The chords of a chord table must be finite and >= 0, some of them > 0.")

    def moment_radius(self, degree: int) -> float:
        """r_k / R, r_k^k = (integral of c r^k dr) / (integral of c dr)."""
        x, width = _between_rows(self)
        weight = _table_chord(x, self) * width
        return float((np.sum(weight * x**degree) / np.sum(weight)) ** (1 / degree))


@dataclass(frozen=True, slots=True, kw_only=True)
class Planform:
    """Outline of one wing."""

    length: float  #: hinge to tip, R [m]
    mean_chord: float  #: area over R [m]
    second_moment_radius: float  #: r2 / R, of the beta distribution; a table has its own
    table: ChordTable | None = None
    _radius: FloatArray = field(init=False, repr=False, compare=False)
    _chord: FloatArray = field(init=False, repr=False, compare=False)
    _width: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        x, width = _clustered() if self.table is None else _between_rows(self.table)
        shape = beta_chord(x, self.second_moment_radius) if self.table is None else _table_chord(x, self.table)
        object.__setattr__(self, "_radius", self.length * x)
        object.__setattr__(self, "_width", self.length * width)
        object.__setattr__(self, "_chord", shape * (self.mean_chord / np.sum(shape * width)))

    @property
    def largest_chord(self) -> float:
        """[m]; of a beta distribution without bound, that of the nodes."""
        return float(np.max(self._chord))

    def chord(self, fraction: FloatArray) -> FloatArray:
        """Chord at fractions (N,) of the wing length, between 0 and 1 [m]."""
        if self.table is None:
            return self.mean_chord * beta_chord(fraction, self.second_moment_radius)
        x, width = _between_rows(self.table)
        return _table_chord(fraction, self.table) * (self.mean_chord / np.sum(_table_chord(x, self.table) * width))

    # kept, since the flies of an ensemble share few outlines
    @lru_cache(maxsize=1024)  # noqa: B019 (bounded, and an outline is a small value)
    def moment(self, chord_power: int, radius_power: int = 0) -> float:
        """Integral of c^m r^n dr over the span [m^(m + n + 1)]."""
        return float(np.sum(self._chord**chord_power * self._radius**radius_power * self._width))

    @lru_cache(maxsize=1024)  # noqa: B019
    def legendre_moment(self, chord_power: int, degree: int) -> float:
        """Integral of c^m P_k(2 r / R - 1) dr, P_k Legendre's polynomial [m^(m + 1)]."""
        shape = np.polynomial.Legendre.basis(degree)(2 * self._radius / self.length - 1)
        return float(np.sum(self._chord**chord_power * shape * self._width))


def beta_exponents(second_moment_radius: float) -> tuple[float, float]:
    """p = r1 k, q = (1 - r1) k, k = r1 (1 - r1) / (r2^2 - r1^2) - 1, r2 = 0.929 r1^0.732.  Ellington 1984, part II."""
    r1 = (second_moment_radius / 0.929) ** (1 / 0.732)
    k = r1 * (1 - r1) / (second_moment_radius**2 - r1**2) - 1.0
    return r1 * k, (1 - r1) * k


def beta_chord(x: FloatArray, second_moment_radius: float) -> FloatArray:
    """c / mean chord = x^(p-1) (1-x)^(q-1) / B(p, q) at fractions x of the wing length."""
    p, q = beta_exponents(second_moment_radius)
    return x ** (p - 1) * (1 - x) ** (q - 1) / beta(p, q)


def _clustered() -> tuple[FloatArray, FloatArray]:
    """Midpoints in theta of x = (1 - cos theta) / 2, and their widths."""
    theta = (np.arange(_POINTS) + 0.5) * np.pi / _POINTS
    return (1 - np.cos(theta)) / 2, np.sin(theta) * np.pi / (2 * _POINTS)


def _between_rows(table: ChordTable, order: int = 8) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre points and weights, panel by panel of the table."""
    x, w = np.polynomial.legendre.leggauss(order)
    span = np.array(table.span)
    half, middle = np.diff(span) / 2, (span[1:] + span[:-1]) / 2
    return (middle[:, None] + half[:, None] * x).ravel(), (half[:, None] * w).ravel()


def _table_chord(x: FloatArray, table: ChordTable) -> FloatArray:
    return np.interp(x, table.span, table.chord)

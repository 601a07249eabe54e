"""Where a loop's frequency response has gain 1, where it is real and negative, and where it comes nearest to -1."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from flycontrol.delay.kernels import bernstein
from flycontrol.delay.panels import Blocks, Panels, bernstein_matrix, transfer
from flycontrol.delay.system import ComplexArray, FloatArray
from flycontrol.errors import InvalidParameterError

_BRACKET = 2.0**-25  # of a panel: where an isolated root is sure to lie


def gain_crossovers(blocks: Blocks, pieces: Panels) -> FloatArray:
    """Every frequency with |L| = 1 [rad/s], rising: roots of |L|^2 - 1.

    Raises
    ------
    InvalidParameterError
        If |L| = 1 on a whole panel.
    """
    excess = bernstein.squared(pieces.entry)
    excess[:, 0] -= 1.0
    points = excess @ bernstein_matrix(excess.shape[1] - 1).T
    noise = 4.0 * pieces.error  # of |L|^2 where |L| is about 1
    if (np.abs(points).max(axis=1) <= noise).any():
        raise InvalidParameterError(
            "|L| = 1 on a whole band of frequencies, so gain crossovers are no separate points; change the gain a "
            "little to see on which side the loop falls."
        )
    panel, u = bernstein.roots(points, noise)
    return _solved(blocks, pieces, panel, u, lambda L, slope: np.log(np.abs(L)) / (1j * slope / L).real)


def phase_crossovers(blocks: Blocks, pieces: Panels, floor: float) -> FloatArray:
    """Every frequency with L real and negative and |L| above the floor [rad/s], rising: roots of Im L."""
    series = pieces.entry
    points = np.ascontiguousarray((series @ bernstein_matrix(series.shape[1] - 1).T).imag)
    at_rest = pieces.centre == pieces.half  # panels from s = 0, where Im L has a root whatever the loop
    points[at_rest] = _divided_by_frequency(points[at_rest])
    at_zero = (series[at_rest] * (-1.0) ** np.arange(series.shape[1])).sum(axis=1).real
    panel, u = bernstein.roots(points, pieces.error)
    value = (series[panel] * u[:, None] ** np.arange(series.shape[1])).sum(axis=1)
    behind = (value.real < 0) & (np.abs(value) > 0.5 * floor)
    omega = _solved(blocks, pieces, panel[behind], u[behind], lambda L, slope: L.imag / slope.real)
    size = np.abs(transfer(blocks, 1j * omega)[0][:, 0, 0])
    return np.concatenate([np.zeros(np.count_nonzero(at_zero < -floor)), omega[size > floor]])


def nearest_to_minus_one(blocks: Blocks, pieces: Panels) -> tuple[float, float]:
    """The smallest |1 + L| and its frequency [rad/s]: the least value of |1 + L|^2, a root of its derivative."""
    series = pieces.entry.copy()
    series[:, 0] += 1.0
    square = bernstein.squared(series)
    _, panel, u = bernstein.smallest(square @ bernstein_matrix(square.shape[1] - 1).T, 1e-9)
    slope = np.polynomial.Polynomial(square[panel]).deriv()
    for _ in range(6):
        curvature = slope.deriv()(u)
        step = slope(u) / curvature if curvature > 0 else 0.0
        u = min(1.0, max(-1.0, u - step if abs(step) < 0.1 else u))
    if pieces.centre[panel] == pieces.half[panel] and u < -1 + 1e-6:  # |1 + L| is even in w: a minimum at w = 0 itself
        u = -1.0
    omega = (pieces.centre[panel] + pieces.half[panel] * u).imag
    return float(np.abs(1.0 + transfer(blocks, np.array([1j * omega]))[0][0, 0, 0])), float(omega)


def _solved(
    blocks: Blocks,
    pieces: Panels,
    panel: NDArray[np.intp],
    u: FloatArray,
    newton_step: Callable[[ComplexArray, ComplexArray], FloatArray],
) -> FloatArray:
    """Frequencies of isolated roots, by Newton's method on L itself within their brackets; sorted [rad/s]."""
    start, reach = pieces.points(panel, u).imag, _BRACKET * np.abs(pieces.half[panel])
    omega = start
    for _ in range(3):
        L, slope = (value[:, 0, 0] for value in transfer(blocks, 1j * omega))
        with np.errstate(divide="ignore", invalid="ignore"):  # a touch has no slope
            step = newton_step(L, slope)
        omega = np.clip(omega - np.where(np.isfinite(step), step, 0.0), start - reach, start + reach)
    return np.sort(omega)


def _divided_by_frequency(points: FloatArray) -> FloatArray:
    """Control points (k, n + 1) of p / x from those of p, which vanishes at x = (u + 1) / 2 = 0; of the same degree."""
    n = points.shape[1] - 1
    i = np.arange(1, n + 1)
    lower = points[:, 1:] * n / i  # x r(x) has control points (i / n) r_(i - 1)
    raised = np.empty_like(points)
    raised[:, 0], raised[:, -1] = lower[:, 0], lower[:, -1]
    raised[:, 1:-1] = (i[:-1] * lower[:, :-1] + (n - i[:-1]) * lower[:, 1:]) / n
    return raised

"""How far a fit can be trusted near its minimum: covariance, degrees of freedom, bias of the second order.

Covariance is (J^T V^-1 J)^-1, V from the restricted likelihood. Since V is estimated, an interval uses Student's t with
Satterthwaite's degrees of freedom, 2 C_ii^2 / var(C_ii), the variance from the likelihood's curvature in the noise's
parameters. Curvature of the model biases the estimates by -C J^T V^-1 m / 2 with m_t = trace(H_t C), H_t the second
derivatives of sample t (Box 1971); m is a sum of second differences along the columns of a root of C.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.identify.gains.least_squares import Minimum, WeightedProblem
from flycontrol.identify.gains.noise import Noise, whitened
from flycontrol.identify.gains.problem import Channel, TrialPart, reciprocal_step

FloatArray = NDArray[np.float64]
_SINGULAR = 1e-11  #: of scaled singular values: below it a combination of unknowns leaves no trace in the data
_STEP = 0.5  #: of the second differences, in standard errors
_SHORTEST = 0.01  #: at a bound there is no room for a difference
_NUDGE = 1e-3  #: of the noise's parameters


@dataclass(frozen=True, slots=True, eq=False)
class LocalUncertainty:
    """Covariance of the unknowns and what corrects it."""

    covariance: FloatArray  #: (k, k); an unknown that is held at a bound, or not identifiable, has infinite variance
    freedom: FloatArray  #: (k,) degrees of freedom of each interval
    bias: FloatArray  #: (k,) expected estimate less truth
    unidentifiable: FloatArray  #: (d, k) unit combinations of scaled unknowns that leave no trace in the data
    scale: (
        FloatArray  #: (k,) by which unknowns are scaled there: a change of 1 / scale moves the prediction by one unit
    )


def local_uncertainty(weighted: WeightedProblem, minimum: Minimum, bias: bool = True) -> LocalUncertainty:
    """Linearise at a minimum.

    Parameters
    ----------
    bias
        Compute the bias too, two responses for each unknown and trial; otherwise zeros. At a kink there is no second
        derivative to take it from, away from a minimum or along a combination without trace there is no point that it
        belongs to: zeros too.
    """
    free = ~minimum.held
    matrix = minimum.at.matrix
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    values, vectors = np.linalg.eigh((matrix / scale / scale[:, None])[free][:, free])
    seen = values > _SINGULAR * max(values.max(initial=0.0), 1e-300)
    k = len(minimum.x)
    inverse, blind = np.zeros((k, k)), np.zeros((int((~seen).sum()), k))
    rows = np.flatnonzero(free)
    inverse[rows[:, None], rows] = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T
    inverse /= scale * scale[:, None]
    blind[:, free] = vectors[:, ~seen].T
    freedom = _freedom(weighted, minimum.x, inverse)
    asked = bias and minimum.converged and not minimum.at_kink and not len(blind)
    offset = _bias(weighted, minimum.x, inverse) if asked else np.zeros(k)
    covariance = inverse.copy()
    lost = minimum.held | (np.abs(blind) > 1e-3).any(axis=0)
    covariance[lost, lost] = np.inf
    return LocalUncertainty(covariance, freedom, offset, blind, scale)


def _freedom(weighted: WeightedProblem, x: FloatArray, C: FloatArray) -> FloatArray:
    """Satterthwaite's degrees of freedom of each diagonal entry of C."""
    variance = np.zeros(len(x))
    noises = weighted.noise
    if len(noises) == 1 and len(noises[0]) == 1 and noises[0][0].order == 0:  # C is one variance times a known matrix
        return np.full(len(x), 2.0 / noises[0][0].uncertainty[0, 0])
    for part, noises in zip(weighted.problem.parts, weighted.noise, strict=True):
        predicted = part.predicted(x)
        for rows, channel, noise in zip(predicted, part.channels, noises, strict=True):
            slopes = np.array([_slope(C[:, part.places], H) for H in _information_slopes(rows[1:], channel, noise)])
            variance += np.einsum("ai,ab,bi->i", slopes, noise.uncertainty, slopes)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        found = 2.0 * np.diag(C) ** 2 / variance
    seen = np.isfinite(found)  # what is held has no variance here: it is judged as the least certain of the others
    return np.clip(np.where(seen, found, found[seen].min(initial=1e6)), 1.0, 1e6)


def _slope(C: FloatArray, H: FloatArray) -> FloatArray:
    """d diag(C) = -diag(C dH C), C given by the columns of the trial's unknowns (k, m)."""
    return -np.einsum("ia,ab,ib->i", C, H, C)


def _information_slopes(rows: FloatArray, channel: Channel, noise: Noise) -> list[FloatArray]:
    """Derivatives of J^T V^-1 J with respect to the logarithm of the variance and each z."""

    def information(pacf: FloatArray) -> FloatArray:
        W = whitened(rows, channel.firsts, Noise(noise.deviation, pacf, noise.uncertainty))
        return W @ W.T

    z = np.arctanh(noise.pacf)
    nudges = _NUDGE * np.eye(noise.order)
    moved = [(information(np.tanh(z + h)) - information(np.tanh(z - h))) / (2 * _NUDGE) for h in nudges]
    return [-information(noise.pacf), *moved]


def _bias(weighted: WeightedProblem, x: FloatArray, C: FloatArray) -> FloatArray:
    pull, around = np.zeros(len(x)), _around(weighted, x, C)
    for part, noises, rows in zip(weighted.problem.parts, weighted.noise, weighted.rows(x), strict=True):
        bent = _bent(part, noises, around, _steps(C, part, around))
        for row, m in zip(rows, bent, strict=True):
            pull[part.places] += row[1:] @ m
    offset, loose = -0.5 * C @ pull, around.loose
    offset[loose] += C[loose, loose] / x[loose]  # half of d^2 x / d(1/x)^2 times the variance of 1 / x
    return offset


@dataclass(frozen=True, slots=True, eq=False)
class _Around:
    """Points about a minimum. What the prediction is divided by moves by its reciprocal, if it has no certain sign.

    Differences in it would reach over its pole at zero, and its variance drown all others.
    """

    x: FloatArray
    loose: Sequence[int]
    size: FloatArray  #: (k,) units in which unknowns are comparable
    room: FloatArray  #: (k,) to the nearer bound

    def __call__(self, move: FloatArray) -> FloatArray:
        moved = self.x + move
        for i in self.loose:
            moved[i] = reciprocal_step(self.x[i], move[i])
        return moved


def _around(weighted: WeightedProblem, x: FloatArray, C: FloatArray) -> _Around:
    problem, size = weighted.problem, np.ones(len(x))
    loose = [i for i in problem.divisors if C[i, i] > x[i] ** 2]
    room = np.minimum(x - problem.low, problem.high - x)
    size[loose], room[loose] = np.abs(x[loose]), np.inf
    return _Around(x, loose, size, room)


def _steps(C: FloatArray, part: TrialPart, around: _Around) -> list[tuple[float, FloatArray]]:
    """Columns (k,) of a root of the trial's covariance, each with the fraction of it that keeps inside the bounds."""
    size = around.size
    values, vectors = np.linalg.eigh((C / size / size[:, None])[part.grid])
    steps: list[tuple[float, FloatArray]] = []
    for value, vector in zip(values, vectors.T, strict=True):
        column = np.zeros(len(size))
        column[part.places] = np.sqrt(max(value, 0.0)) * vector * size[part.places]
        with np.errstate(over="ignore"):  # much room, no step
            fits = 0.9 * around.room / np.maximum(np.abs(column), 1e-300)
        fraction = min(_STEP, float(fits.min()))
        if value > 0 and fraction > _SHORTEST:
            steps.append((fraction, column))
    return steps


def _bent(
    part: TrialPart, noises: Sequence[Noise], around: _Around, steps: Sequence[tuple[float, FloatArray]]
) -> list[FloatArray]:
    """trace(H_t C) of each channel's whitened samples."""
    centre = part.predicted(around.x, False)
    total = [np.zeros_like(rows) for rows in centre]
    for h, v in steps:
        ahead, behind = part.predicted(around(h * v), False), part.predicted(around(-h * v), False)
        total = [t + (a + b - 2 * c) / h**2 for t, a, c, b in zip(total, ahead, centre, behind, strict=True)]
    return [whitened(t, c.firsts, n)[0] for t, c, n in zip(total, part.channels, noises, strict=True)]

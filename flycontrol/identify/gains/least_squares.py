"""Weighted least squares of a fit problem by Levenberg and Marquardt's method, inside bounds, with exact derivatives.

    minimise  sum over channels of |rho(V^(-1/2) (model(x) - measured))| + sum of ((x - mean) / deviation)^2 of priors,

V the noise's covariance. Steps solve (H + lambda diag H) d = -g with H = J^T J (Marquardt 1963); an unknown at a bound
that the gradient pushes outwards is held there. The cost has a kink at every delay that puts an edge of a pulse on a
sample of the paddling angle, and its minimum may lie at one: a delay with the gradient towards it on both sides is held
there while the others are sought. Where the prediction is divided by an unknown, the step is one of its reciprocal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dposv  # type: ignore[attr-defined]

from flycontrol.identify.gains.noise import Noise, whitened
from flycontrol.identify.gains.problem import FitProblem, TrialPart, reciprocal_step

FloatArray = NDArray[np.float64]
Loss = Literal["linear", "huber"]
_HUBER = 1.345  #: 95 % efficient for normal noise (Huber 1981)
_CLOSE = 1e-9  #: Newton decrement in units of the noise's variance: 3e-5 standard errors from the minimum
_SLOW = 1e-6  #: the same of a search out of steps, which J^T J slows where the signal is as weak as the noise
_BESIDE = 1e-5  #: of a standard error, below what _CLOSE asks: where both sides of a kink are looked at
_STEEP, _STUCK = 1e5, 1e12  #: damping that makes one look for a kink, and with which steps cannot be told from none
_SHORT = 0.5  #: |move / x| up to which a step of a divisor is taken as it is
_REGULAR = 1e-10  #: of the scaled matrix: where K_D = 0 it and the delay have one derivative, and J^T J is singular


@dataclass(frozen=True, slots=True, eq=False)
class NormalEquations:
    """Cost, gradient and Gauss-Newton matrix at one point."""

    cost: float  #: whitened
    gradient: FloatArray  #: J^T r (k,)
    matrix: FloatArray  #: J^T J (k, k)

    @property
    def finite(self) -> bool:
        """Whether a step can be taken from here: far astray products overflow."""
        return bool(np.isfinite(self.cost) and np.isfinite(self.matrix).all())


@dataclass(frozen=True, slots=True, eq=False)
class Minimum:
    """Where a search ended."""

    x: FloatArray  #: (k,)
    at: NormalEquations
    converged: bool
    held: NDArray[np.bool_]  #: (k,) unknowns at a bound, and torque limits that are never reached
    steps: int
    at_kink: bool = False  #: of the cost, in a delay


@dataclass(frozen=True, slots=True, eq=False)
class WeightedProblem:
    """A problem with the noise of each channel of each trial."""

    problem: FitProblem
    noise: Sequence[Sequence[Noise]]  #: by trial, by channel
    loss: Loss = "linear"

    def rows(self, x: FloatArray, derivatives: bool = True) -> list[list[FloatArray]]:
        """Whitened residuals and, below, derivatives of each channel: by trial, by channel (1 + m, n)."""
        return [
            self._whitened(part, noises, x, derivatives)
            for part, noises in zip(self.problem.parts, self.noise, strict=True)
        ]

    def _whitened(self, part: TrialPart, noises: Sequence[Noise], x: FloatArray, derivatives: bool) -> list[FloatArray]:
        mine = part.predicted(x, derivatives)
        for rows, channel in zip(mine, part.channels, strict=True):
            rows[0] -= channel.values
        return [whitened(r, c.firsts, noise) for r, c, noise in zip(mine, part.channels, noises, strict=True)]

    def cost(self, x: FloatArray) -> float:
        """Cost at x (k,), without derivatives."""
        losses = [self._robust(rows)[0] for channels in self.rows(x, derivatives=False) for rows in channels]
        pulls = [((x[i] - prior.mean) / prior.deviation) ** 2 for i, prior in self.problem.priors]
        return float(sum(losses) + sum(pulls))

    def normal_equations(self, x: FloatArray) -> NormalEquations:
        """Cost, gradient and matrix at x (k,)."""
        k = len(x)
        cost, gradient, matrix = 0.0, np.zeros(k), np.zeros((k, k))
        for part, noises in zip(self.problem.parts, self.noise, strict=True):
            loss, square = self._products(part, noises, x)
            cost += loss
            gradient[part.places] += square[0, 1:]
            matrix[part.grid] += square[1:, 1:]
        for i, prior in self.problem.priors:
            pull = (x[i] - prior.mean) / prior.deviation
            cost += pull**2
            gradient[i] += pull / prior.deviation
            matrix[i, i] += prior.deviation**-2
        return NormalEquations(cost, gradient, matrix)

    def _products(self, part: TrialPart, noises: Sequence[Noise], x: FloatArray) -> tuple[float, FloatArray]:
        """Cost of one trial and the products of its weighted rows (1 + m, 1 + m)."""
        if self.loss == "linear" and len(part.channels) == 1:
            square = part.products(x, noises[0])
            return float(square[0, 0]), square
        cost, square = 0.0, np.zeros((1 + len(part.active),) * 2)
        for rows in self._whitened(part, noises, x, derivatives=True):
            loss, weighted = self._robust(rows)
            square += weighted @ weighted.T
            cost += loss
        return cost, square

    def _robust(self, rows: FloatArray) -> tuple[float, FloatArray]:
        """Cost, and rows weighted so that their products are gradient and matrix of it."""
        if self.loss == "linear":
            return float(rows[0] @ rows[0]), rows
        size = np.abs(rows[0])
        weights = np.minimum(1.0, _HUBER / np.maximum(size, 1e-300))
        loss = np.where(size <= _HUBER, size**2, 2 * _HUBER * size - _HUBER**2)
        return float(loss.sum()), rows * np.sqrt(weights)


def minimise(
    weighted: WeightedProblem,
    x: FloatArray,
    most_steps: int = 60,
    scale: float | None = None,
    close: float = _CLOSE,
    fixed: Sequence[int] = (),
) -> Minimum:
    """Search from x (k,).

    Parameters
    ----------
    scale
        Variance of a whitened residual that convergence is judged by; None: that of the residuals found.
    close
        Newton decrement, in units of that variance, at which the search ends.
    fixed
        Indices of unknowns that stay where they are.
    """
    problem = weighted.problem
    low, high = problem.low, problem.high
    x = np.clip(x, low, high)
    at = weighted.normal_equations(x)
    if not at.finite:
        return Minimum(x, at, False, np.zeros(len(x), dtype=np.bool_), 0)
    damping, freedom, kinks = 1e-3, max(problem.samples - len(x), 1), []
    for step in range(most_steps):
        free = _free(problem, x, at.gradient, [*fixed, *kinks])
        decrement = _decrement(at, free)
        if decrement <= close * (scale or at.cost / freedom):
            if all(_at_kink(weighted, x, at, i) for i in kinks):
                return Minimum(x, at, True, ~_free(problem, x, at.gradient, fixed), step, bool(kinks))
            kinks = []
            continue
        taken = _step(weighted, x, at, free, damping, _STEEP)
        if taken is None:
            found = [i for i in _delays(problem, free) if _at_kink(weighted, x, at, i)]
            if found:
                kinks, damping = [*kinks, *found], 1e-3
                continue
            taken = _step(weighted, x, at, free, _STEEP, _STUCK)
        if taken is None:
            near = decrement <= 1e-4 * (scale or at.cost / freedom)
            return Minimum(x, at, near, ~_free(problem, x, at.gradient, fixed), step)
        x, at, damping = taken
    free = _free(problem, x, at.gradient, fixed)
    near = not kinks and _decrement(at, free) <= _SLOW * (scale or at.cost / freedom)
    return Minimum(x, at, near, ~free if near else (x <= low) | (x >= high), most_steps)


def _decrement(at: NormalEquations, free: NDArray[np.bool_]) -> float:
    """g^T H^-1 g over the free unknowns."""
    H, g, _ = _scaled(at, free)
    return float(g @ _solved(H, g, _REGULAR))


def _scaled(at: NormalEquations, free: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Matrix with a unit diagonal, gradient, and the sizes that make them so, of the free unknowns."""
    size = np.sqrt(np.maximum(np.diag(at.matrix), 1e-300))[free]
    return at.matrix[free][:, free] / (size * size[:, None]), at.gradient[free] / size, size


def _step(
    weighted: WeightedProblem, x: FloatArray, at: NormalEquations, free: NDArray[np.bool_], damping: float, most: float
) -> tuple[FloatArray, NormalEquations, float] | None:
    """A step that does not go up, and the damping of the next; None if there is none up to the most damping."""
    H, g, size = _scaled(at, free)
    while True:
        move = np.zeros(len(x))
        move[free] = -_solved(H, g, damping) / size
        trial = _moved(weighted.problem, x, move)
        there = weighted.normal_equations(trial)
        if there.cost <= at.cost and there.finite:
            break
        damping = max(damping * 10, 1e-7)
        if damping > most:
            return None
    expected = -(2 * at.gradient @ move + move @ at.matrix @ move)
    gained = at.cost - there.cost
    return trial, there, _next_damping(damping, float(gained / expected) if expected > 1e-9 * at.cost else 1.0)


def _moved(problem: FitProblem, x: FloatArray, move: FloatArray) -> FloatArray:
    """x + move inside the bounds; what the prediction is divided by takes a long step in its reciprocal.

    So it goes through infinity to the other sign if the data want it, where x + move would run away from a reciprocal
    of the other sign for ever. Of short steps both are the same to the second order.
    """
    moved = x + move
    for i in problem.divisors:
        if abs(move[i]) > _SHORT * abs(x[i]):
            shut = problem.low[i] >= 0 if x[i] > 0 else problem.high[i] <= 0
            moved[i] = reciprocal_step(x[i], move[i], shut=bool(shut))
    return np.clip(moved, problem.low, problem.high)


def _delays(problem: FitProblem, free: NDArray[np.bool_]) -> list[int]:
    """Free unknowns that move the edges of a pulse's answer over the samples."""
    return [i for i, kind in enumerate(problem.kinds) if free[i] and kind in ("delay", "onset_shift")]


def _at_kink(weighted: WeightedProblem, x: FloatArray, at: NormalEquations, i: int) -> bool:
    """Whether the cost rises from unknown i to either side."""
    beside = np.zeros(len(x))
    beside[i] = _BESIDE / np.sqrt(max(at.matrix[i, i], 1e-300))
    low, high = weighted.problem.low, weighted.problem.high  # a delay that nothing shows has a boundless error
    sides = [weighted.normal_equations(np.clip(x + sign * beside, low, high)) for sign in (-1, 1)]
    return bool(sides[0].gradient[i] < 0 < sides[1].gradient[i])


def _free(problem: FitProblem, x: FloatArray, gradient: FloatArray, fixed: Sequence[int]) -> NDArray[np.bool_]:
    """Unknowns (k,) that a step may change: not fixed, not pushed outwards at a bound."""
    free = ~(((x <= problem.low) & (gradient > 0)) | ((x >= problem.high) & (gradient < 0)))
    free[list(fixed)] = False
    return free


def _next_damping(damping: float, ratio: float) -> float:
    """Less where the step gained what was expected, more where it overshot: J^T J misses curvature along a ridge."""
    if ratio > 0.75:
        return 0.05 * damping
    return max(0.5 * damping, 1e-12) if ratio > 0.25 else max(4 * damping, 1e-6)


def variance_of(found: Minimum, i: int) -> float:
    """Variance of one unknown at a minimum, in units of a whitened residual's; infinite if nothing determines it."""
    size = np.sqrt(np.maximum(np.diag(found.at.matrix), 1e-300))
    unit = np.zeros(len(size))
    unit[i] = 1.0
    variance = float(_solved(found.at.matrix / (size * size[:, None]), unit, 0.0)[i]) / size[i] ** 2
    return variance if variance > 0 else np.inf


def _solved(H: FloatArray, g: FloatArray, damping: float) -> FloatArray:
    """(H + damping diag H)^-1 g for a matrix with a unit diagonal."""
    if not len(g):  # nothing is free
        return g
    damped = H + damping * np.eye(len(g))
    _, solution, failed = dposv(damped, g)
    if failed:  # singular to rounding: the shortest of the steps that fit best
        solution = np.linalg.lstsq(damped, g, rcond=None)[0]
    return np.asarray(solution, dtype=np.float64)

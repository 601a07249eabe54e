"""The parametric fly fitted to all silhouettes of an instant, with covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from flycontrol.units import deg
from flycontrol.vision.fit_shape import FitShape
from flycontrol.vision.kernels.cover import BAND, COLUMNS, compare
from flycontrol.vision.soft_silhouette import BorderDistance
from flycontrol.vision.stance import BASE_MOVE, STEPS, TURN, WING_TURN, Stance, step_between, stepped

FloatArray = NDArray[np.float64]

#: Variance of a border per pixel of its length, neighbours' correlation included [px^3] (C)
_BORDER_VARIANCE = 0.75
#: Weight of what silhouettes have and the fly has not, as legs, over that of what it has too much; below 1 legs pull
#: less, but a wing half lost in the body is found again less often (C)
_LENIENCE = 1.0
_ROUNDS, _LARGEST_STEP = 25, 0.35  #: of Levenberg and Marquardt; in wing lengths and radians
_EVERYWHERE = [-np.inf, np.inf, -np.inf, np.inf]
_TURNS = slice(TURN.start, WING_TURN[1].stop)


@dataclass(frozen=True, slots=True, kw_only=True)
class Leash:
    """How far the fitted fly may be from what is expected of it, as standard deviations."""

    base: float = 0.02  #: of a wing's base from where the shape has it, in wing lengths, along each body axis (C)
    body: float = 1 * deg  #: of the body's turn from the expected one, about each axis (C)
    wing: float = 20 * deg  #: of a wing's turn from the expected one, about each axis (C)


#: For fits that expect nothing but the bases.
_LEASH = Leash()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Agreement:
    """How far a fly covers silhouettes and they it."""

    cost: float  #: weighted sum of squared differences of soft silhouettes, over all pixels [px]
    overlap: FloatArray  #: (C,) intersection over union of fly and silhouette
    precision: FloatArray  #: (C,) share of the fly's pixels that lie on the silhouette


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SilhouetteFit:
    """A stance that fits, and how well."""

    stance: Stance
    covariance: FloatArray  #: (18, 18) of steps from the stance, `flycontrol.vision.stance` [m, rad]
    agreement: Agreement
    converged: bool
    iterations: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Quadratic:
    """Cost and its model about a stance: cost + 2 g x + x H x."""

    cost: float
    H: FloatArray
    g: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Problem:
    """What is to be fitted, at one softness."""

    border: BorderDistance
    shape: FitShape
    softness: float
    target: FloatArray
    expected: Stance | None = None
    leash: Leash = _LEASH
    windows: FloatArray | None = None  #: (C, 4) least and largest u, v of the pixels that are compared; all if None

    def compared(self, stance: Stance, *, gradient: bool = True) -> tuple[_Quadratic, FloatArray]:
        """The silhouettes' share of the cost, and the tally of pixels (C, 3)."""
        H = np.zeros((COLUMNS, COLUMNS)) if gradient else np.empty((0, 0))
        g, tally = np.zeros(COLUMNS), np.zeros((len(self.border.cameras), 3))
        stride = max(int(self.softness), 1)  # a soft border is smooth enough to be looked at less often
        windows = np.array([_EVERYWHERE] * len(self.border.cameras)) if self.windows is None else self.windows
        cost = compare(
            np.stack([camera.matrix for camera in self.border.cameras]), self.target,
            self.border.corner, self.border.extent, self.border.image,
            windows, self.softness, stride, _LENIENCE,
            stance.position_W, np.ascontiguousarray(stance.body_axes_W), np.ascontiguousarray(stance.wings_B),
            np.ascontiguousarray(stance.bases_B), self.shape.spheres, self.shape.outline, self.shape.half_thickness,
            H, g, tally,
        )  # fmt: skip
        return _Quadratic(cost=float(cost), H=H, g=g), tally

    def held(self, stance: Stance) -> _Quadratic:
        """The share of what is expected, in the silhouettes' unit."""
        weight, away = np.zeros(STEPS), np.zeros(STEPS)
        bases = slice(BASE_MOVE[0].start, BASE_MOVE[1].stop)
        weight[bases] = (self.leash.base * self.shape.wing_length) ** -2
        away[bases] = (stance.bases_B - self.shape.bases_B).ravel()
        if self.expected is not None:
            weight[TURN] = self.leash.body**-2
            weight[WING_TURN[0].start : WING_TURN[1].stop] = self.leash.wing**-2
            away[_TURNS] = step_between(self.expected, stance)[_TURNS]
        weight *= _residual_variance(self.softness)
        return _Quadratic(cost=float(np.sum(weight * away**2)), H=np.diag(weight), g=weight * away)

    def at(self, stance: Stance) -> _Quadratic:
        """Both shares, of steps in wing lengths and radians."""
        seen, held, scale = self.compared(stance)[0], self.held(stance), _scale(self.shape.wing_length)
        H = (seen.H[:STEPS, :STEPS] + held.H) * np.outer(scale, scale)
        return _Quadratic(cost=seen.cost + held.cost, H=H, g=(seen.g[:STEPS] + held.g) * scale)


def silhouette_cost(border: BorderDistance, shape: FitShape, stance: Stance, softness: float) -> float:
    """Weighted sum of squared differences of soft silhouettes, over all pixels [px]."""
    return _problem(border, shape, softness).compared(stance, gradient=False)[0].cost


def best_wing(
    border: BorderDistance, shape: FitShape, stances: Sequence[Stance], side: int, *, softness: float = 2.0
) -> int:
    """Which of some stances costs least that differ in the left (0) or right (1) wing only.

    Pixels farther from all places of that wing than its soft border reaches cost the same with each, and are left out.
    """
    sheet = np.column_stack([shape.outline, np.full(len(shape.outline), shape.half_thickness)])
    sheet = np.vstack([sheet, sheet * [1.0, 1.0, -1.0]])
    points = np.concatenate([stance.base_W(side) + sheet @ stance.wing_axes_W(side).T for stance in stances])
    windows = [_window(camera.project(points), BAND * softness) for camera in border.cameras]
    problem = replace(_problem(border, shape, softness), windows=np.array(windows))
    return int(np.argmin([problem.compared(stance, gradient=False)[0].cost for stance in stances]))


def agreement(border: BorderDistance, shape: FitShape, stance: Stance, softness: float = 1.0) -> Agreement:
    """How well a stance agrees with silhouettes."""
    found, tally = _problem(border, shape, softness).compared(stance, gradient=False)
    model, silhouette, both = tally.T
    return Agreement(
        cost=found.cost,
        overlap=both / np.maximum(model + silhouette - both, 1),
        precision=both / np.maximum(model, 1),
    )


def normal_equations(
    border: BorderDistance, shape: FitShape, stance: Stance, softness: float
) -> tuple[FloatArray, FloatArray]:
    """J^T J (22, 22) and J^T r (22,) of the cost, with what is expected, in wing lengths and radians.

    The first 18 columns are those of a step, the last four factors on body length, body radius, wing length and chord.
    """
    problem = _problem(border, shape, softness)
    found, held = problem.compared(stance)[0], problem.held(stance)
    found.H[:STEPS, :STEPS] += held.H
    found.g[:STEPS] += held.g
    scale = np.concatenate([_scale(shape.wing_length), np.ones(COLUMNS - STEPS)])
    return found.H * np.outer(scale, scale), found.g * scale


def fit_silhouettes(
    border: BorderDistance,
    shape: FitShape,
    start: Stance,
    *,
    expected: Stance | None = None,
    softness: Sequence[float] = (2.5, 1.0),
    leash: Leash = _LEASH,
) -> SilhouetteFit:
    """min over the stance of sum (c(d / s) - c(D / s))^2: Levenberg and Marquardt, from soft borders to sharp ones.

    d and D are signed distances to the borders of the projected fly and of the silhouettes. Legs, which the fly does
    not have, cost what they cost wherever the fly is, and pull little. The wings' bases, which set the roll of a body
    of revolution, are held near the places where the shape has them; with `expected`, body and wings near that stance.

    Parameters
    ----------
    border : of the silhouettes
    shape : of the fly
    start : where to begin
    expected : where the fly must be by its motion so far
    softness : s, one after the other [px]
    leash : standard deviations of what is expected
    """
    stance, iterations, done = start, 0, False
    for s in softness:
        stance, rounds, done = _descended(_problem(border, shape, s, expected, leash), stance)
        iterations += rounds
    s = softness[-1]
    # what was expected came from the frames before: counted again in each, it would make a drift look certain
    at, scale = _problem(border, shape, s, None, leash).at(stance), _scale(shape.wing_length)
    H = at.H + 1e-9 * np.max(np.diag(at.H)) * np.eye(STEPS)
    covariance = cast(FloatArray, cho_solve(cho_factor(H), np.eye(STEPS))) * np.outer(scale, scale)
    return SilhouetteFit(
        stance=stance,
        covariance=covariance * _residual_variance(s),
        agreement=agreement(border, shape, stance, s),
        converged=done,
        iterations=iterations,
    )


def _problem(
    border: BorderDistance, shape: FitShape, softness: float, expected: Stance | None = None, leash: Leash = _LEASH
) -> _Problem:
    return _Problem(
        border=border, shape=shape, softness=softness, target=border.softened(softness), expected=expected, leash=leash
    )


def _descended(problem: _Problem, stance: Stance) -> tuple[Stance, int, bool]:
    """Stance, rounds, and whether they came to rest."""
    damping, scale = 1e-3, _scale(problem.shape.wing_length)
    at = problem.at(stance)
    for k in range(_ROUNDS):
        diagonal = np.diag(at.H)
        move = -np.linalg.solve(at.H + np.diag(damping * (diagonal + 1e-6 * np.max(diagonal))), at.g)
        longest = float(np.max(np.abs(move)))
        move *= min(1.0, _LARGEST_STEP / longest) if longest > 0 else 1.0
        ahead = stepped(stance, move * scale)
        tried = problem.at(ahead)
        gain = at.cost - tried.cost
        if gain > 0:
            stance, at, damping = ahead, tried, max(damping / 5, 1e-6)
        else:
            damping = max(damping * 8, 1e-4)
        if longest < 3e-4 or damping > 1e4 or 0 <= gain < 1e-5 * at.cost:
            return stance, k + 1, True
    return stance, _ROUNDS, False


def _window(pixels: FloatArray, margin: float) -> list[float]:
    """Least and largest u, least and largest v of pixels (N, 2) with a margin; all where some are behind the camera."""
    if not np.all(np.isfinite(pixels)):
        return _EVERYWHERE
    (u0, v0), (u1, v1) = np.min(pixels, axis=0) - margin, np.max(pixels, axis=0) + margin
    return [float(u0), float(u1), float(v0), float(v1)]


def _residual_variance(s: float) -> float:
    """Variance of a border over the integral of c'(x / s)^2 dx, which is 1 / (6 s): that of a pixel's residual."""
    return _BORDER_VARIANCE / (6 * s)


def _scale(length: float) -> FloatArray:
    scale = np.full(STEPS, length)
    scale[_TURNS] = 1.0
    return scale

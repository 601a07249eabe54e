"""How large a fly is: sizes of the parametric fly fitted to silhouettes of some instants together with its poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.silhouette_fit import fit_silhouettes, normal_equations
from flycontrol.vision.soft_silhouette import BorderDistance
from flycontrol.vision.stance import STEPS, Stance

FloatArray = NDArray[np.float64]

_FACTORS = slice(STEPS, STEPS + 4)
_ROUNDS = 6
_SOFTNESS = 1.5  #: [px]
_TRUST = 0.15  #: standard deviation of a factor: what flies differ by (C)
_LARGEST_STEP, _AT_REST = 0.1, 2e-3  #: relative


@dataclass(frozen=True, slots=True, kw_only=True)
class Sizes:
    """Factors on a fly's sizes."""

    body_length: float = 1.0
    body_radius: float = 1.0
    wing_length: float = 1.0
    wing_chord: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SizedFly:
    """A fly as large as its silhouettes say."""

    shape: FlyShape
    sizes: Sizes  #: over those of the shape at the start
    stances: tuple[Stance, ...]


def fitted_sizes(shape: FlyShape, seen: Sequence[tuple[BorderDistance, Stance]]) -> SizedFly:
    """Gauss and Newton in turns: poses given the sizes, then sizes with the poses free to follow.

    The wings' bases keep their place in the body, stretched with it: a wing may slide into the body unseen, so that
    silhouettes tell where its tip is far better than where it begins.

    Parameters
    ----------
    shape : a fly of about that size
    seen : silhouettes of some instants, with a stance that fits them roughly; six instants of one wingbeat are enough
    """
    factors, stances, sized = np.ones(4), [stance for _, stance in seen], shape
    borders = [border for border, _ in seen]
    for k in range(_ROUNDS):
        sized = resized(shape, _sizes(factors))
        fitted = fit_shape(sized)
        stances = [fit_silhouettes(at, fitted, stance).stance for at, stance in zip(borders, stances, strict=True)]
        step = _step(list(zip(borders, stances, strict=True)), sized, factors)
        if k == _ROUNDS - 1 or np.max(np.abs(step)) < _AT_REST:
            break
        factors = factors * (1 + np.clip(step, -_LARGEST_STEP, _LARGEST_STEP))
    return SizedFly(shape=sized, sizes=_sizes(factors), stances=tuple(stances))


def _sizes(factors: FloatArray) -> Sizes:
    length, radius, wing, chord = (float(factor) for factor in factors)
    return Sizes(body_length=length, body_radius=radius, wing_length=wing, wing_chord=chord)


def resized(shape: FlyShape, sizes: Sizes) -> FlyShape:
    """A shape with its body and wings stretched; the bases go with the body."""
    body = np.array([sizes.body_length, sizes.body_radius])
    wing = np.array([sizes.wing_length, sizes.wing_chord, sizes.wing_chord])
    along = np.array([sizes.body_length, sizes.body_radius, sizes.body_radius])
    return replace(shape, profile=shape.profile * body, wing=shape.wing * wing, right_base_B=shape.right_base_B * along)


def _step(seen: Sequence[tuple[BorderDistance, Stance]], shape: FlyShape, factors: FloatArray) -> FloatArray:
    """Relative change (4,) of the sizes: S s = -r with the poses eliminated, S = sum of H_ss - H_sp H_pp^-1 H_ps."""
    S, r = np.zeros((4, 4)), np.zeros(4)
    for border, stance in seen:
        H, g = normal_equations(border, fit_shape(shape), stance, _SOFTNESS)
        across = np.linalg.solve(H[:STEPS, :STEPS], H[:STEPS, _FACTORS])
        S += H[_FACTORS, _FACTORS] - H[_FACTORS, :STEPS] @ across
        r += g[_FACTORS] - across.T @ g[:STEPS]
    weight = 1.0 / _TRUST**2  # the residuals' variance is about an eighth, a border being known to half a pixel
    step = np.linalg.solve(S + weight / 8 * np.eye(4), r + weight / 8 * (factors - 1))
    return -np.asarray(step, dtype=np.float64)

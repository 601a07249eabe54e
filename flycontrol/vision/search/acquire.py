"""The first instant: a fly found in its silhouettes without knowing where it was before."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.pose import Pose
from flycontrol.units import deg
from flycontrol.vision.fit_shape import FitShape
from flycontrol.vision.hull import VisualHull
from flycontrol.vision.search.belief import Judged, judged
from flycontrol.vision.search.body_in_hull import body_lines
from flycontrol.vision.search.rival import with_rivals
from flycontrol.vision.search.second_look import SecondLook
from flycontrol.vision.search.wing_grid import wing_grid
from flycontrol.vision.silhouette_fit import Leash, fit_silhouettes, silhouette_cost
from flycontrol.vision.soft_silhouette import BorderDistance
from flycontrol.vision.stance import Stance, stances_of, step_between

FloatArray = NDArray[np.float64]

_COARSE = 4.0  #: softness of the search [px]
_KEPT = 12  #: of the guesses, fitted
_APART = 25 * deg  #: guesses nearer than that in all turns are one
#: The search looks for a fly upright to this extent, whose wings are about mirror images of one another.
_ROLLS = np.arange(-60, 61, 20) * deg
#: Seen at the first instant, nothing is expected yet.
_FREE = Leash(body=180 * deg, wing=180 * deg)


def acquire(hull: VisualHull, border: BorderDistance, shape: FitShape, stroke_plane_angle: float) -> Judged:
    """The best of the fits that start from the most likely of a grid of poses about where a hull has room for a body.

    The world's z points up, and the fly's back does too, within some 60 deg of roll.

    Parameters
    ----------
    hull : at a few pixels to the voxel
    border : of the silhouettes
    shape : of the fly
    stroke_plane_angle : v_S = Ry(angle) v_B [rad]

    Raises
    ------
    InvalidInputError
        If the hull is empty.
    """
    if len(hull) < 8:
        raise InvalidInputError("The silhouettes contradict one another: their hull is empty; check the cameras.")
    bodies = list(_bodies(hull, shape))
    guesses = list(_with_wings(bodies, shape, stroke_plane_angle))
    order = np.argsort([silhouette_cost(border, shape, guess, _COARSE) for guess in guesses])
    fits = [
        fit_silhouettes(border, shape, guess, softness=(_COARSE, 2.0), leash=_FREE)
        for guess in _different([guesses[k] for k in order])
    ]
    best = min((judged(fit, border, shape, None) for fit in fits), key=lambda each: each.rank)
    best = judged(fit_silhouettes(border, shape, best.fit.stance, leash=_FREE), border, shape, None)
    look = SecondLook(
        border=border, shape=shape, stroke_plane_angle=stroke_plane_angle, expected=best.fit.stance
    )  # fmt: skip
    for side in (0, 1):
        if best.doubts[side + 1]:
            others = [judged(fit, border, shape, None) for fit in look.elsewhere(best.fit.stance, side)]
            best = min([best, *others], key=lambda each: each.rank)
    fit = with_rivals(best.fit, look, np.inf, expecting=False)
    return best if fit is best.fit else judged(fit, border, shape, None)


def _bodies(hull: VisualHull, shape: FitShape) -> Iterator[Stance]:
    """Stances with the body where the hull has room for it, rolled this way and that."""
    for line, roll in product(body_lines(hull, shape), _ROLLS):
        forward = line.forward
        pitch, yaw = np.arcsin(np.clip(forward[2], -1, 1)), np.arctan2(-forward[1], forward[0])
        X = np.concatenate([line.middle, [yaw, pitch, roll], np.zeros(6), shape.bases_B.ravel()])
        yield stances_of(Pose(coordinates=X[None], stroke_plane_angle=0.0))[0]


def _with_wings(bodies: Sequence[Stance], shape: FitShape, stroke_plane_angle: float) -> Iterator[Stance]:
    for body, wings in product(bodies, list(wing_grid(shape, stroke_plane_angle))):
        yield replace(body, wings_B=wings)


def _different(guesses: Sequence[Stance]) -> list[Stance]:
    """The first guesses of an order that are no near repetitions of one before them."""
    kept: list[Stance] = []
    for guess in guesses:
        if all(np.max(np.abs(step_between(other, guess)[3:12])) > _APART for other in kept):
            kept.append(guess)
        if len(kept) == _KEPT:
            break
    return kept

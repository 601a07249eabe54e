"""Other stances than the one found first, for a frame in which it is strange or doubted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from flycontrol.units import deg
from flycontrol.vision.fit_shape import FitShape
from flycontrol.vision.search.wing_grid import wing_grid
from flycontrol.vision.silhouette_fit import Leash, SilhouetteFit, fit_silhouettes, silhouette_cost
from flycontrol.vision.soft_silhouette import BorderDistance
from flycontrol.vision.stance import WING_TURN, Stance, step_between

_TWIST = 55 * deg  #: by which a wing is turned about its span
_COARSE, _BLURRED = 4.0, 2.0  #: softness of the search, and of choices between what a hull allows [px]
_KEPT, _KEPT_PAIRS, _APART = (
    3,
    5,
    30 * deg,
)  #: places of a wing, and of both, that are fitted, so far apart in one turn at least
_WINGS = slice(WING_TURN[0].start, WING_TURN[1].stop)
#: A wing that was lost may be anywhere.
_LOOSE = Leash(wing=180 * deg)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SecondLook:
    """Where to look again."""

    border: BorderDistance
    shape: FitShape
    stroke_plane_angle: float  #: [rad]
    expected: Stance

    def twisted(self, stance: Stance) -> Iterator[SilhouetteFit]:
        """Fits from the stance with one wing turned about its span, one way and the other."""
        for side in (0, 1):
            for sign in (1.0, -1.0):
                turn = Rotation.from_rotvec(sign * _TWIST * stance.wings_B[side][:, 0]).as_matrix()
                yield self.near(with_wing(stance, side, turn @ stance.wings_B[side]))

    def elsewhere(self, stance: Stance, side: int) -> Iterator[SilhouetteFit]:
        """Fits with the left (0) or right (1) wing looked for everywhere, body and other wing as they are."""
        for guess in _different(self._guesses(stance, side), side):
            yield fit_silhouettes(
                self.border, self.shape, guess, expected=self.expected, leash=_LOOSE, softness=(_COARSE, 2.0, 1.0)
            )

    def anywhere(self, stance: Stance, body: float) -> Iterator[SilhouetteFit]:
        """Fits with both wings looked for everywhere, mirror images at first; the body within `body` [rad]."""
        leash = Leash(body=body, wing=180 * deg)
        grid = wing_grid(self.shape, self.stroke_plane_angle)
        for guess in self._likeliest(stance, [replace(stance, wings_B=wings) for wings in grid]):
            yield fit_silhouettes(
                self.border, self.shape, guess, expected=self.expected, leash=leash, softness=(_COARSE, 2.0, 1.0)
            )

    def _likeliest(self, stance: Stance, others: Sequence[Stance]) -> list[Stance]:
        """Some that differ, the stance itself among them if it is likely."""
        guesses = [stance, *others]
        order = np.argsort([silhouette_cost(self.border, self.shape, guess, _COARSE) for guess in guesses])
        kept: list[Stance] = []
        for guess in (guesses[k] for k in order):
            if all(np.max(np.abs(step_between(other, guess)[_WINGS])) > _APART for other in kept):
                kept.append(guess)
            if len(kept) == _KEPT_PAIRS:
                break
        return kept

    def guessed(self, stance: Stance, side: int) -> Stance:
        """The stance with one wing where it fits best, by a glance at every place."""
        return self._guesses(stance, side)[0]

    def _guesses(self, stance: Stance, side: int) -> list[Stance]:
        """The likeliest first."""
        grid = wing_grid(self.shape, self.stroke_plane_angle)
        guesses = [stance, *(with_wing(stance, side, wings[side]) for wings in grid)]
        order = np.argsort([silhouette_cost(self.border, self.shape, guess, _COARSE) for guess in guesses])
        return [guesses[k] for k in order]

    def cost(self, stance: Stance) -> float:
        """How badly a stance fits the silhouettes, roughly."""
        return silhouette_cost(self.border, self.shape, stance, _BLURRED)

    def near(self, start: Stance) -> SilhouetteFit:
        """The fit from another start."""
        return fit_silhouettes(self.border, self.shape, start, expected=self.expected)


def with_wing(stance: Stance, side: int, axes: np.ndarray) -> Stance:
    """The stance with other axes (3, 3) of one wing, in body axes."""
    wings = stance.wings_B.copy()
    wings[side] = axes
    return replace(stance, wings_B=wings)


def _different(guesses: Sequence[Stance], side: int) -> list[Stance]:
    kept: list[Stance] = []
    for guess in guesses:
        if all(np.max(np.abs(step_between(other, guess)[WING_TURN[side]])) > _APART for other in kept):
            kept.append(guess)
        if len(kept) == _KEPT:
            break
    return kept

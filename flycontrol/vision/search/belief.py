"""Whether a fitted fly's body and wings are where the silhouettes have them, part by part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.vision.fit_shape import FitShape
from flycontrol.vision.search.part_claims import PartClaims, part_claims
from flycontrol.vision.silhouette_fit import SilhouetteFit
from flycontrol.vision.soft_silhouette import BorderDistance
from flycontrol.vision.stance import Stance

FloatArray = NDArray[np.float64]

PARTS = ("the body", "the left wing", "the right wing")
#: Why body, left and right wing are not believed; empty where they are.
Doubts = tuple[str, str, str]
NO_DOUBTS: Doubts = ("", "", "")

SLACK = 2.0  #: what is nearer to a border than this may be on either side of it [px]
#: Of the pixels that a part alone claims, the share that a silhouette may deny. Right fits stay below 0.2 in 95 of 100
#: frames of simulated flies whose sizes are wrong by 10 % (C)
_DENIED = 0.3
_HIDDEN = 0.1  #: of a part's pixels in a view: with fewer of its own it is hidden there, in other parts
_FEWEST = 0.02  #: of a wing's area: with fewer pixels of its own in a view a part cannot be denied there
_MISSED = 0.2  #: of a wing's area: silhouettes that hold so much more outside the fly than they use to hold a lost part
_ASTRAY = 0.3  #: wing lengths by which a base may leave its place: a wing turned end to end leaves it by one (C)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Judged:
    """A fit, and what is to be thought of it."""

    fit: SilhouetteFit
    doubts: Doubts
    missed: FloatArray  #: (C,) pixels of the silhouettes off the fly

    @property
    def rank(self) -> tuple[int, float]:
        """The less the better: parts in doubt, then cost."""
        return sum(map(bool, self.doubts)), self.fit.agreement.cost


def judged(fit: SilhouetteFit, border: BorderDistance, shape: FitShape, usually_missed: FloatArray | None) -> Judged:
    """A fit with the doubts about its parts; see `doubts`."""
    claims = part_claims(border, shape, fit.stance, SLACK)
    return Judged(
        fit=fit, doubts=doubts(claims, border, shape, fit.stance, usually_missed), missed=claims.missed
    )  # fmt: skip


def doubts(
    claims: PartClaims, border: BorderDistance, shape: FitShape, stance: Stance, usually_missed: FloatArray | None
) -> Doubts:
    """Why each part is not believed: denied by a silhouette, hidden in all views but one, astray, or left over.

    Parameters
    ----------
    claims : of the parts at the stance
    border : of the silhouettes
    shape : of the fly
    stance : as fitted
    usually_missed : (C,) pixels of the silhouettes that were off the fly in frames before, legs and the like
    """
    area = face_area(shape) * np.square(scales(border, stance))
    share = np.where(claims.alone > _FEWEST * area[:, None], claims.denied / np.maximum(claims.alone, 1), 0.0)
    names = [camera.name for camera in border.cameras]
    found = [_denied(PARTS[k], share[:, k], names) for k in range(3)]
    hidden = np.count_nonzero(claims.alone <= _HIDDEN * claims.whole, axis=0)
    for k in (1, 2):
        if not found[k] and len(names) - hidden[k] < min(2, len(names)):
            found[k] = f"{PARTS[k]} is hidden in other parts in {hidden[k]} of {len(names)} views"
    astray = np.linalg.norm(stance.bases_B - shape.bases_B, axis=1) > _ASTRAY * shape.wing_length
    for k in (0, 1):
        if astray[k] and not found[k + 1]:
            found[k + 1] = f"{PARTS[k + 1]} fits only with its base {_ASTRAY:g} wing lengths and more from its place"
    if usually_missed is not None and not any(found):
        lost = claims.missed - usually_missed > _MISSED * area
        if np.any(lost):
            k = _least_supported(claims)
            where = ", ".join(f"'{name}'" for name, gone in zip(names, lost, strict=True) if gone)
            found[k] = f"{PARTS[k]} may be the part of the silhouette of {where} that is left over"
    return found[0], found[1], found[2]


def _denied(part: str, share: FloatArray, names: Sequence[str]) -> str:
    worst = int(np.argmax(share))
    if share[worst] <= _DENIED:
        return ""
    return f"{share[worst]:.0%} of {part} would be off the silhouette of '{names[worst]}'"


def _least_supported(claims: PartClaims) -> int:
    """1 or 2: the wing of which the silhouettes show less."""
    shown = (claims.alone - claims.denied).sum(axis=0)
    return 1 if shown[1] < shown[2] else 2


def face_area(shape: FitShape) -> float:
    """Of a wing seen face on [m^2]."""
    s, c = shape.outline.T
    return float(abs(np.sum(s * np.roll(c, -1) - c * np.roll(s, -1))) / 2)


def scales(border: BorderDistance, stance: Stance) -> FloatArray:
    """(C,) pixels to the metre at the fly."""
    return np.array([camera.pixels_per_metre(stance.position_W[None])[0] for camera in border.cameras])

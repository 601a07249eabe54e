"""One fly, one frame on: expected, fitted or read off its hull, believed or bridged."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera import Camera
from flycontrol.units import deg
from flycontrol.vision.first_pose import MARGIN, Masks, fine_hull
from flycontrol.vision.fit_shape import FitShape, fit_shape
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.hull import VisualHull
from flycontrol.vision.reading.hull_stance import stance_of_hull
from flycontrol.vision.search.acquire import acquire
from flycontrol.vision.search.belief import NO_DOUBTS, Judged, judged
from flycontrol.vision.search.prediction import drifted, expectations, unseen_wing
from flycontrol.vision.search.rival import WORTH, with_rivals
from flycontrol.vision.search.second_look import SecondLook, with_wing
from flycontrol.vision.silhouette_fit import Agreement, SilhouetteFit, agreement, best_wing, silhouette_cost
from flycontrol.vision.soft_silhouette import BorderDistance, border_distance
from flycontrol.vision.stance import MOVE, Stance
from flycontrol.vision.tracked_frame import TrackedFrame
from flycontrol.vision.views import BoolArray, views_of

FloatArray = NDArray[np.float64]

_MEMORY = 40  #: frames whose costs tell what is usual: about a wingbeat at 8,000 frames a second
#: Times the usual cost: wings may have settled turned about their spans; look again; do not believe (C)
_NOTABLE, _STRANGE, _WRONG = 1.1, 1.5, 2.5
_LEAST_PRECISION = 0.7  #: of the fly's pixels on each silhouette (C)
_LEAST_OVERLAP = 0.7  #: mean over views: right fits of a fly of about that size stay above, turned ones do not (C)
_ENOUGH = 3  #: views that tell one way in which a fly may be turned from all others
_LONGEST_BRIDGE = 40  #: frames
_BLIND = 2  #: frames after which the wings may be anywhere
_TURNED = 2 * deg  #: of the body, in a frame without sight (C)
_PATIENCE = 10  #: frames without sight from one search everywhere to the next
_BIAS = 0.2  #: of positions, by legs and the like [px] (C)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fly:
    """What must be known of a fly to follow it."""

    shape: FlyShape
    stroke_plane_angle: float  #: v_S = Ry(angle) v_B [rad]


@dataclass(slots=True, kw_only=True)
class Follower:
    """The stances behind, and what fits used to cost: all that is remembered, however long the flight."""

    cameras: Sequence[Camera]
    fly: Fly
    refine: bool
    start: SilhouetteFit | None
    past: deque[Stance] = field(default_factory=lambda: deque(maxlen=3))
    costs: deque[float] = field(default_factory=lambda: deque(maxlen=_MEMORY))
    missed_before: deque[FloatArray] = field(default_factory=lambda: deque(maxlen=_MEMORY))
    covariance: FloatArray = field(default_factory=lambda: np.zeros((18, 18)))
    unseen: int = 0  #: frames since the fly was last seen
    blind: int = 0  #: frames without sight, until the fly has been seen so often again that its motion is known

    def follow(self, masks: Masks) -> TrackedFrame:
        """The fly in one more frame; InvalidInputError if the images do not fit the cameras."""
        shape = fit_shape(self.fly.shape)
        try:
            border = border_distance(views_of(masks, self.cameras), MARGIN)
        except InvalidInputError as empty:
            return self._bridged(str(empty), None)
        if self.unseen and self.unseen % _PATIENCE == 0:
            self._look_afresh(masks, border, shape)
        if not self.past:
            if self.start is None:
                return self._bridged("the fly was lost before, and is not found again here", None)
            self.past.append(self.start.stance)
        found = self._refined(masks, border, shape) if self.refine else self._read(masks, border, shape)
        if found is None:
            return self._bridged("the silhouettes contradict one another: their hull is not a whole fly", None)
        seen = found.fit.agreement
        wrong = (_WRONG if self.refine and not self.blind else _STRANGE) * self._usual(seen.cost)
        doubt = next(filter(None, found.doubts), "") if self.blind else found.doubts[0]
        if doubt or seen.cost > wrong or np.min(seen.precision) < _LEAST_PRECISION:
            return self._bridged(doubt or "no stance near the expected one fits these silhouettes", seen)
        return self._believed(found, masks)

    def missed(self, reason: str) -> TrackedFrame:
        """One more frame that shows nothing."""
        return self._bridged(reason, None)

    def _usual(self, otherwise: float) -> float:
        return float(np.median(self.costs)) if self.costs else otherwise

    def _usually_missed(self) -> FloatArray | None:
        return np.median(np.array(self.missed_before), axis=0) if self.missed_before else None

    def _refined(self, masks: Masks, border: BorderDistance, shape: FitShape) -> Judged:
        expected = _likeliest(expectations(list(self.past), shape.bases_B), border, shape)
        look = SecondLook(border=border, shape=shape, stroke_plane_angle=self.fly.stroke_plane_angle, expected=expected)
        best = self._best([look.near(expected)], border, shape)
        if self._strange(best):
            others = [*look.twisted(best.fit.stance)]
            hull = fine_hull(masks, self.cameras, shape)
            if len(hull):
                choice = partial(best_wing, border, shape)
                read = stance_of_hull(hull, expected, self.fly.shape, self.fly.stroke_plane_angle, choice)
                others.append(look.near(read.stance))
            best = self._best([best.fit, *others], border, shape)
        if self.blind:
            again = look.anywhere(expected, min(1 * deg + self.blind * _TURNED, 180 * deg))
            best = self._best([best.fit, *again], border, shape)
        for side in (0, 1):
            if best.doubts[side + 1]:
                best = self._best([best.fit, *look.elsewhere(best.fit.stance, side)], border, shape)
        moving = not self.blind and len(self.past) == self.past.maxlen  # and it is known how
        worth = WORTH if moving and not self._notable(best.fit) else np.inf
        fit = with_rivals(best.fit, look, worth, expecting=moving)
        if fit.stance is best.fit.stance:
            return replace(best, fit=fit)
        return judged(fit, border, shape, self._usually_missed())

    def _best(self, fits: Sequence[SilhouetteFit], border: BorderDistance, shape: FitShape) -> Judged:
        usual = self._usually_missed()
        return min((judged(fit, border, shape, usual) for fit in fits), key=lambda each: each.rank)

    def _strange(self, found: Judged) -> bool:
        cost = found.fit.agreement.cost
        return bool(found.doubts[0]) or cost >= _STRANGE * self._usual(np.inf if not self.costs else cost)

    def _notable(self, fit: SilhouetteFit) -> bool:
        return fit.agreement.cost > _NOTABLE * self._usual(fit.agreement.cost)

    def _read(self, masks: Masks, border: BorderDistance, shape: FitShape) -> Judged | None:
        hull, look = fine_hull(masks, self.cameras, shape), self._look(border, shape, self._expected(shape))
        found = self._read_from(look.expected, hull, look)
        if len(hull) and (found is None or found.agreement.cost > _STRANGE * self._usual(found.agreement.cost)):
            lost = look.guessed(look.guessed(look.expected, 0), 1)
            again = [found, *(self._read_from(seed, hull, look) for seed in (self.past[-1], lost))]
            found = min((each for each in again if each), key=lambda each: each.agreement.cost, default=None)
        if found is None:
            return None
        return Judged(fit=found, doubts=NO_DOUBTS, missed=np.zeros(len(self.cameras)))

    def _read_from(self, seed: Stance, hull: VisualHull, look: SecondLook) -> SilhouetteFit | None:
        if not len(hull):
            return None
        choice = partial(best_wing, look.border, look.shape)
        read = stance_of_hull(hull, seed, self.fly.shape, self.fly.stroke_plane_angle, choice)
        if not read.dissection.complete:
            return None
        seen = agreement(look.border, look.shape, read.stance)
        return SilhouetteFit(
            stance=read.stance, covariance=read.covariance, agreement=seen, converged=True, iterations=0
        )

    def _look(self, border: BorderDistance, shape: FitShape, expected: Stance) -> SecondLook:
        return SecondLook(border=border, shape=shape, stroke_plane_angle=self.fly.stroke_plane_angle, expected=expected)

    def _believed(self, found: Judged, masks: Masks) -> TrackedFrame:
        shape = fit_shape(self.fly.shape)
        fit = self._without_doubted(found, shape)
        if self.blind and self.unseen:
            self.past.clear()  # how the fly moves is not known from stances that were not seen
        self.past.append(fit.stance)
        if not any(found.doubts):
            self.costs.append(fit.agreement.cost)
            self.missed_before.append(found.missed)
        self.unseen, self.covariance = 0, self._with_bias(fit)
        if len(self.past) == self.past.maxlen:
            self.blind = 0
        cut = [camera.name for camera, mask in zip(self.cameras, masks, strict=True) if _touches_edge(mask)]
        reasons = [doubt for doubt in found.doubts if doubt]
        reasons += self._reserves(fit.agreement)
        if cut:
            reasons.append(f"the silhouette reaches the border of the image of {', '.join(cut)}")
        return TrackedFrame(
            stance=fit.stance,
            covariance=self.covariance,
            status="partial" if reasons else "tracked",
            reason="; ".join(reasons),
            agreement=fit.agreement,
            doubts=found.doubts,
        )

    def _reserves(self, seen: Agreement) -> Iterator[str]:
        """What stands against the whole frame."""
        if len(self.cameras) < _ENOUGH:
            yield "two views leave it open how the fly is turned"
        if np.mean(seen.overlap) < _LEAST_OVERLAP:
            yield f"fly and silhouettes share only {100 * np.mean(seen.overlap):.0f} % of the area"

    def _without_doubted(self, found: Judged, shape: FitShape) -> SilhouetteFit:
        """The fit with doubted wings where they are expected."""
        fit = found.fit
        for side in (0, 1):
            if found.doubts[side + 1]:
                expected, bases = self._expected(shape, unseen=True), fit.stance.bases_B.copy()
                bases[side] = shape.bases_B[side]
                fit = replace(
                    fit,
                    stance=replace(with_wing(fit.stance, side, expected.wings_B[side]), bases_B=bases),
                    covariance=unseen_wing(fit.covariance, self.covariance, side),
                )
        return fit

    def _with_bias(self, found: SilhouetteFit) -> FloatArray:
        covariance = found.covariance.copy()
        scale = np.mean([camera.pixels_per_metre(found.stance.position_W[None])[0] for camera in self.cameras])
        covariance[MOVE, MOVE] += np.eye(3) * (_BIAS / scale) ** 2
        return covariance

    def _expected(self, shape: FitShape, *, unseen: bool = False) -> Stance:
        return expectations(list(self.past)[-2:], shape.bases_B, rolling=self.refine, unseen=unseen)[0]

    def _bridged(self, reason: str, seen: Agreement | None) -> TrackedFrame:
        self.unseen += 1
        if self.unseen >= _BLIND:
            self.blind += 1
        if self.start is not None and not self.past:
            self.past.append(self.start.stance)
        if not self.past or self.unseen > _LONGEST_BRIDGE:
            self.past.clear()
            self.start, nothing = None, np.full((18, 18), np.nan)
            return TrackedFrame(stance=None, covariance=nothing, status="lost", reason=reason, agreement=seen)
        expected = self._expected(fit_shape(self.fly.shape), unseen=self.unseen >= _BLIND)
        self.past.append(expected)
        self.covariance = drifted(self.covariance)
        return TrackedFrame(
            stance=expected, covariance=self.covariance, status="bridged", reason=reason, agreement=seen
        )

    def _look_afresh(self, masks: Masks, border: BorderDistance, shape: FitShape) -> None:
        """Start anew from wherever the fly is, if it can be told."""
        hull = fine_hull(masks, self.cameras, shape)
        found = acquire(hull, border, shape, self.fly.stroke_plane_angle) if len(hull) else None
        if found is None or any(found.doubts) or found.rank[1] > _STRANGE * self._usual(np.inf):
            return
        self.start = found.fit
        self.past.clear()


def _likeliest(stances: list[Stance], border: BorderDistance, shape: FitShape) -> Stance:
    if len(stances) == 1:
        return stances[0]
    return min(stances, key=lambda stance: silhouette_cost(border, shape, stance, 2.5))


def _touches_edge(mask: BoolArray) -> bool:
    return bool(mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any())

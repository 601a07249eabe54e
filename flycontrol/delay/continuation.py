"""Roots of a delay system followed along one parameter: predicted by their speed, corrected by Newton, never mixed up.

A step p -> p + h predicts each root by the exact derivative ds/dp = -f_p / f_s and corrects it by Newton on the exact
equation at p + h. Newton contracts by e / d, where e is the distance of the prediction to its root and d that to the
next root, known or unknown; a step that contracts worse than `_CONTRACTION` is halved, so no root is taken for another.
Where two roots meet on the real axis they are not smooth in p. The meeting point is solved for, and the pair crosses it
as root +- sqrt(curvature (p - value)).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flycontrol.delay.double_root import DoubleRoot, double_root_near
from flycontrol.delay.family import Family
from flycontrol.delay.kernels import continuation
from flycontrol.delay.system import ComplexArray, FloatArray

BoolArray = NDArray[np.bool_]

_CONTRACTION = 0.1
_SHORTEST = 1e-9  # of the way to the next wanted value
_MOST_ATTEMPTS = 500  # on that way
_FAR_LEFT = -150.0  # Re s times the longest delay: what is delayed is e^150 times as large as what is not


class Node(NamedTuple):
    """A point of a branch."""

    value: float  #: of the parameter
    root: complex  #: [1/s]
    speed: complex  #: ds/dp


@dataclass(frozen=True, slots=True, kw_only=True)
class Collision:
    """A double root on the real axis, where a conjugate pair becomes two real roots or two real roots a pair."""

    value: float  #: of the parameter
    root: float  #: [1/s]
    splits: bool  #: with rising parameter the pair becomes two real roots; False: two real roots become a pair
    branches: tuple[int, int]  #: the one that goes through, and the one that begins (splits) or ends here


@dataclass(slots=True, eq=False)
class Walk:
    """Roots with imag >= 0 on their way along a parameter, and the path behind them."""

    family: Family
    value: float
    ids: list[int] = field(default_factory=list[int])
    roots: ComplexArray = field(default_factory=lambda: np.zeros(0, dtype=np.complex128))
    speeds: ComplexArray = field(default_factory=lambda: np.zeros(0, dtype=np.complex128))
    paths: dict[int, list[Node]] = field(default_factory=dict[int, list[Node]])
    collisions: list[Collision] = field(default_factory=list[Collision])
    lost: list[tuple[int, Node]] = field(default_factory=list[tuple[int, Node]])  #: branches that no step could follow

    def start(self, branch: int, root: complex) -> None:
        """Let a branch begin, or join, at the present value."""
        self.ids.append(branch)
        roots = np.append(self.roots, root)
        self.arrive(self.value, roots, roots_speeds(self.family, self.value, roots))

    def arrive(self, value: float, roots: ComplexArray, speeds: ComplexArray) -> None:
        """Take the roots at a value for the next points of the branches."""
        self.value, self.roots, self.speeds = value, roots, speeds
        for branch, root, speed in zip(self.ids, roots, self.speeds, strict=True):
            path = self.paths.setdefault(branch, [])
            if path and path[-1].value == value:
                path.pop()
            path.append(Node(value, complex(root), complex(speed)))

    def meet(self, collision: Collision) -> None:
        """Note a collision, once: a wanted value may lie at it."""
        span = float(self.family.high[0] - self.family.low[0])
        if not any(
            abs(c.value - collision.value) < 1e-9 * span and c.branches == collision.branches for c in self.collisions
        ):
            self.collisions.append(collision)

    def lose(self, gone: BoolArray) -> None:
        """Leave branches behind that no step can follow, and remember where."""
        self.lost += [(self.ids[k], self.paths[self.ids[k]][-1]) for k in np.flatnonzero(gone)]
        self.leave(gone)

    def leave(self, gone: BoolArray) -> None:
        """Follow the branches marked in `gone` no longer."""
        self.ids = [branch for branch, left in zip(self.ids, gone, strict=True) if not left]
        self.roots, self.speeds = self.roots[~gone], self.speeds[~gone]


def march(walk: Walk, target: float, new_branch: int) -> int:
    """Follow the walk's roots to a wanted value; returns the next free branch number.

    A branch that no step can follow is left behind in `walk.lost`; one that reaches the far left just ends.
    """
    whole = target - walk.value
    step = whole
    attempts = refused = 0
    while walk.value != target and walk.ids:
        ahead = target if abs(step) >= 0.999 * abs(target - walk.value) else walk.value + step
        trial = _attempt(walk, ahead)
        attempts += 1
        if not trial.doubtful.any():
            walk.arrive(ahead, trial.roots, trial.speeds)
            _leave_far_left(walk)
            step *= 2.0 if trial.contraction.max(initial=0.0) < 0.25 * _CONTRACTION else 1.0
            continue
        step = 0.5 * (ahead - walk.value)
        refused += 1
        worst = int(np.argmax(np.where(trial.doubtful, trial.contraction, -1.0)))
        meeting = _meeting_ahead(walk, worst, step, target) if refused % 3 == 0 else None
        hopeless = refused % 3 == 0 and meeting is None and _coincides(walk, worst)
        if meeting is not None and _cross_collision(walk, meeting, new_branch):
            new_branch = max(new_branch, 1 + max(walk.ids))
            step = target - walk.value
        elif hopeless or abs(step) < _SHORTEST * abs(whole) or attempts > _MOST_ATTEMPTS:
            walk.lose(trial.doubtful)
            step = target - walk.value
    walk.value = target
    return new_branch


class _Trial(NamedTuple):
    """Where a step leads."""

    roots: ComplexArray
    speeds: ComplexArray
    contraction: FloatArray
    doubtful: BoolArray  #: which roots may not be those that the step began with


def _attempt(walk: Walk, value: float) -> _Trial:
    """Roots at a value by prediction and Newton.

    A root is doubtful if Newton contracts slowly, if it left the real axis or the upper half, or if its way is not what
    the speeds at both ends say, as after a prediction that lands near a distant root.
    """
    way = value - walk.value
    predicted = walk.roots + walk.speeds * way
    roots, contraction = _corrected(walk.family, value, predicted, walk.roots.imag == 0.0)
    speeds = roots_speeds(walk.family, value, roots)
    strayed = _strayed(way, (walk.roots, walk.speeds), (roots, speeds))
    return _Trial(roots, speeds, contraction, strayed | ~(contraction <= _CONTRACTION))


def _strayed(way: float, begin: tuple[ComplexArray, ComplexArray], end: tuple[ComplexArray, ComplexArray]) -> BoolArray:
    """Which roots (with their speeds at both ends) did not go where the mean of the two speeds leads."""
    (from_root, from_speed), (to_root, to_speed) = begin, end
    moved = to_root - from_root
    off = np.abs(moved - 0.5 * way * (from_speed + to_speed))
    length = np.abs(moved) + abs(way) * np.maximum(np.abs(from_speed), np.abs(to_speed))
    known = (from_speed != 0) & (to_speed != 0)
    return known & (off > 0.15 * length + 1e-9 * np.abs(to_root))


def _corrected(
    family: Family, value: float, predicted: ComplexArray, real: BoolArray
) -> tuple[ComplexArray, FloatArray]:
    roots, contraction = continuation.correct(*family.blocks(np.array([value])), predicted, family.rate)
    crossed = (roots.imag < 0.0) | ((roots.imag == 0.0) != real)
    return roots, np.where(crossed, np.inf, contraction)


def roots_speeds(family: Family, value: float, roots: ComplexArray) -> ComplexArray:
    """ds/dp of each root; zero where the family's structure changes or two roots coincide."""
    point = np.array([value])
    beside = family.neighbours(point, 0)
    if beside is None:
        return np.zeros_like(roots)
    found = continuation.speeds(*family.blocks(point), tuple(beside.before), tuple(beside.after), beside.width, roots)
    return np.where(np.isfinite(found), found, 0.0)


def _coincides(walk: Walk, place: int) -> bool:
    """Whether a root is a double one that no collision explains: two equal parts of a system, side by side."""
    apart = np.abs(walk.roots - walk.roots[place])
    return int((apart <= 1e-6 * abs(walk.roots[place])).sum()) > 1


def _leave_far_left(walk: Walk) -> None:
    longest = walk.family.blocks(np.array([walk.value])).tau.max(initial=0.0)
    far = (walk.roots.real * longest < _FAR_LEFT) | (walk.roots.real < -1e3 * walk.family.rate)
    if far.any():
        walk.leave(far)


class _Meeting(NamedTuple):
    """A collision ahead and the step across it."""

    at: DoubleRoot
    members: list[int]  #: places in the walk of the roots that meet, the right one first; one for a pair
    landing: float  #: value behind the collision, or at it where the way ends there


def _cross_collision(walk: Walk, meeting: _Meeting, new_branch: int) -> bool:
    """Carry a pair across a collision, if that can be done without doubt.

    Convention: the right one of two real roots and the upper one of a pair are the same branch; the left one ends or
    begins at the collision. At the collision itself, if it is a wanted value, both are there.
    """
    at, members, landing = meeting
    offset = np.sqrt(complex(at.curvature * (landing - at.value)))
    through, other = walk.ids[members[0]], walk.ids[members[1]] if len(members) > 1 else new_branch
    stay = np.array([k not in members for k in range(len(walk.ids))], dtype=np.bool_)
    pair = at.root + offset * np.array([1.0, -1.0])[: 2 if offset.imag == 0.0 else 1]
    ids = [walk.ids[k] for k in np.flatnonzero(stay)] + [through, other][: len(pair)]
    predicted = np.append((walk.roots + walk.speeds * (landing - walk.value))[stay], pair)
    real = np.append(walk.roots.imag[stay] == 0.0, pair.imag == 0.0)
    roots, contraction = _corrected(walk.family, landing, predicted, real)
    if landing == at.value:  # a double root, where Newton loses half of its digits
        roots[-len(pair) :], contraction[-len(pair) :] = pair, 0.0
    # a root that crossed the imaginary axis on the way would not be noticed
    near_origin = abs(at.root) < 1e-9 * walk.family.rate
    sides = np.append(roots.real[-len(pair) :], walk.roots.real[members]) * at.root
    speeds = roots_speeds(walk.family, landing, roots)
    others = roots[: stay.sum()], speeds[: stay.sum()]
    strayed = _strayed(landing - walk.value, (walk.roots[stay], walk.speeds[stay]), others)
    safe = (contraction <= _CONTRACTION).all() and not strayed.any() and (near_origin or (sides > 0).all())
    if not safe:
        return False
    walk.ids = ids
    walk.arrive(landing, roots, speeds)
    walk.meet(Collision(value=at.value, root=at.root, splits=at.curvature > 0, branches=(through, other)))
    return True


def _meeting_ahead(walk: Walk, place: int, step: float, target: float) -> _Meeting | None:
    at = double_root_near(walk.family, walk.value, float(walk.roots[place].real))
    if at is None:
        return None
    way = target - walk.value
    ahead = (at.value - walk.value) / way
    if not -_SHORTEST < ahead < 1.0 + _SHORTEST:
        return None
    if abs(ahead - 1.0) <= _SHORTEST:
        at = at._replace(value=target)
    half_gap = np.sqrt(complex(at.curvature * (walk.value - at.value)))
    near = 0.3 * abs(half_gap) + 1e-7 * (float(np.abs(walk.roots).max()) + 1e-3 * walk.family.rate)
    distance = np.minimum(np.abs(walk.roots - at.root - half_gap), np.abs(walk.roots - at.root + half_gap))
    members = [int(k) for k in np.argsort(-walk.roots.real, kind="stable") if distance[k] < near]
    if place not in members or len(members) > 2:
        return None
    beyond = way * ahead if abs(ahead) > _SHORTEST else step
    landing = target if abs(beyond) >= abs(target - at.value) else at.value + beyond
    return _Meeting(at, members, landing)

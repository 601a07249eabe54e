"""Body and wings from a dissected hull by its principal axes: what Hull Reconstruction Motion Tracking reads off it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.morphology import pitch_rotation
from flycontrol.units import deg
from flycontrol.vision.dissection import BODY, LEFT, RIGHT, Dissection, dissect
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.hull import VisualHull
from flycontrol.vision.stance import BASE_MOVE, MOVE, STEPS, TURN, WING_TURN, Stance
from flycontrol.vision.wing_chord import diagonals

FloatArray = NDArray[np.float64]

_ROUNDS = 4  #: of parting voxels and reading axes, which come to rest in two or three
_TOO_FAR = np.cos(np.radians(60.0))  #: of a span from the expected one
_SAME_CHORD = np.cos(np.radians(15.0))  #: of a diagonal from the expected chord
_SECTION = 0.12  #: half width of the section from which the chord is read, in wing lengths
_OUTER = 0.3  #: of the wing length from the base: nearer voxels belong to body and wing alike
#: Span lines miss the bases by so much, in wing lengths; roll changes by so much from frame to frame, lag included (C)
_OFF_LINE, _ROLL_BETWEEN, _ROLLS = 0.03, 2.5 * deg, 60
#: Of hull coordinates, by comparison with simulated flights (C): lengths in voxels, turns in radians.
_SPREAD_MOVE, _SPREAD_TURN, _SPREAD_ROLL = 1.5, 3 * deg, 7 * deg
_SPREAD_SPAN, _SPREAD_PITCH, _SPREAD_BASE = 7 * deg, 18 * deg, 4.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HullStance:
    """What a hull says of a fly."""

    stance: Stance
    covariance: FloatArray  #: (18, 18) of steps from the stance [m, rad]; as large as a turn for parts not found
    dissection: Dissection


def stance_of_hull(
    hull: VisualHull, seed: Stance, shape: FlyShape, stroke_plane_angle: float, cost: Callable[[Stance], float]
) -> HullStance:
    """Long axes are principal axes, chords diagonals of sections; roll puts the wings' bases on the lines of the spans.

    Parts that were not found stay where the seed has them. A leading edge is above its trailing edge, over the stroke
    plane: wings pitch between 0 and 180 deg. Where a section has two diagonals, the silhouettes choose.

    Parameters
    ----------
    hull : its voxels
    seed : the stance expected; it tells left from right and head from tail
    shape : sizes of the fly
    stroke_plane_angle : v_S = Ry(angle) v_B [rad]
    cost : how badly a stance fits the silhouettes
    """
    stance, parts = seed, dissect(hull, seed, shape)
    up_B = pitch_rotation(stroke_plane_angle).T @ np.array([0.0, 0.0, -1.0])
    for _ in range(_ROUNDS):
        if not parts.found[0]:
            break
        stance = _read(parts, stance, shape, up_B, cost)
        again = dissect(hull, stance, shape)
        settled = np.array_equal(again.labels, parts.labels)
        parts = again
        if settled:
            break
    return HullStance(stance=stance, covariance=_covariance(parts, stance), dissection=parts)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Wing:
    """Where a wing may be, in the world."""

    axes: FloatArray  #: (3, 3) span, chord, normal
    base: FloatArray  #: (3,) [m]


def _read(
    parts: Dissection, seed: Stance, shape: FlyShape, up_B: FloatArray, cost: Callable[[Stance], float]
) -> Stance:
    body = parts.part(BODY)
    centre, forward = body.mean(axis=0), _long_axis(body)
    forward = forward if forward @ seed.body_axes_W[:, 0] >= 0 else -forward
    kept = [_Wing(axes=seed.wing_axes_W(k), base=centre + seed.body_axes_W @ seed.bases_B[k]) for k in (0, 1)]
    upright = _upright(forward, seed.body_axes_W[:, 1])
    found = (parts.found[1], parts.found[2])

    def stance(wings: Sequence[_Wing]) -> Stance:
        spans, bases = (np.stack(rows) for rows in ([w.axes[:, 0] for w in wings], [w.base - centre for w in wings]))
        R = upright @ _roll(spans @ upright, bases @ upright, shape, found)
        wings_B = np.stack([R.T @ wing.axes for wing in wings])
        return replace(seed, position_W=centre, body_axes_W=R, wings_B=wings_B, bases_B=bases @ R)

    for k, label in enumerate((LEFT, RIGHT)):
        if parts.found[label - 1]:
            ways = _wings(parts.part(label), kept[k], shape, seed.body_axes_W @ up_B, 2 * k - 1)
            tried = [[way, kept[1]] if k == 0 else [kept[0], way] for way in ways]
            kept = min(tried, key=lambda wings: cost(stance(wings))) if len(tried) > 1 else tried[0]
    return stance(kept)


def _wings(points: FloatArray, seed: _Wing, shape: FlyShape, up: FloatArray, hand: int) -> list[_Wing]:
    """The wings that voxels (N, 3) may be, by what was expected: one for each way in which the chord may lie."""
    length = float(shape.wing[-1, 0])
    outer = points[(points - seed.base) @ seed.axes[:, 0] > _OUTER * length]
    points = outer if len(outer) > 10 else points
    middle, span = points.mean(axis=0), _long_axis(points)
    span = span if span @ seed.axes[:, 0] >= 0 else -span
    if span @ seed.axes[:, 0] < _TOO_FAR:
        span = seed.axes[:, 0]  # the voxels of a wing half hidden may be wider than long
    chords = _chords(points - middle, span, seed.axes[:, 1], length)
    return [_wing(points, middle, span, chord if chord @ up >= 0 else -chord, (shape, hand)) for chord in chords]


def _wing(
    points: FloatArray, middle: FloatArray, span: FloatArray, chord: FloatArray, whose: tuple[FlyShape, int]
) -> _Wing:
    """A wing of voxels (N, 3) about their middle, by its long axis and its chord."""
    shape, hand = whose
    length, plate = float(shape.wing[-1, 0]), _plate(shape)
    turned = np.cos(plate.tilt) * span - np.sin(plate.tilt) * chord
    chord = np.cos(plate.tilt) * chord + np.sin(plate.tilt) * span
    reach = np.percentile((points - middle) @ turned, 99.0)
    axes = np.stack([turned, chord, hand * np.cross(turned, chord)], axis=1)
    return _Wing(axes=axes, base=middle + (reach - length) * turned - plate.chordwise * chord)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Plate:
    """How the outer part of a flat wing lies about its span's axis."""

    chordwise: float  #: of its centre [m]
    tilt: float  #: of its long axis, from the span towards the leading edge [rad]


@lru_cache(maxsize=16)
def _plate(shape: FlyShape) -> _Plate:
    length = shape.wing[-1, 0]
    s = np.linspace(_OUTER * length, length, 400)
    trailing, leading = (np.interp(s, shape.wing[:, 0], shape.wing[:, k]) for k in (2, 1))
    weight = (leading - trailing) / np.sum(leading - trailing)
    middle = (leading + trailing) / 2
    s0, c0 = float(weight @ s), float(weight @ middle)
    across = float(weight @ ((middle - c0) ** 2 + (leading - trailing) ** 2 / 12))
    mixed, along = float(weight @ ((s - s0) * (middle - c0))), float(weight @ (s - s0) ** 2)
    return _Plate(chordwise=c0, tilt=0.5 * float(np.arctan2(2 * mixed, along - across)))


def _chords(from_middle: FloatArray, span: FloatArray, seed: FloatArray, length: float) -> list[FloatArray]:
    """(3,) across the span: the diagonals of the section, and the expected chord if it is none of them."""
    first = seed - (seed @ span) * span
    norm = np.linalg.norm(first)
    first = first / norm if norm > 1e-6 else np.linalg.svd(span[None])[2][1]
    plane = np.stack([first, np.cross(span, first)])
    section = from_middle[np.abs(from_middle @ span) < _SECTION * length] @ plane.T
    found = diagonals(section)
    near = any(abs(way[0]) > _SAME_CHORD for way in found)
    return [way @ plane for way in found] if near else [first, *(way @ plane for way in found)]


def _roll(spans_B: FloatArray, bases_B: FloatArray, shape: FlyShape, found: tuple[bool, bool]) -> FloatArray:
    """(3, 3) the turn about the long axis that brings the bases of the shape nearest to the lines along the spans.

    min over r of sum log(1 + |(1 - s s^T) (Rx(r) b - b')|^2 / d^2) + r^2 / e^2 over the wings found: how far along its
    span a wing begins the hull cannot tell, and a span read wrongly shall not turn the fly.
    """
    angles = np.arange(-_ROLLS, _ROLLS + 1) * deg / 2
    b = shape.right_base_B
    cost = (angles / _ROLL_BETWEEN) ** 2
    for k in (0, 1):
        y, z = b[1] * (2 * k - 1), b[2]
        c, s = np.cos(angles), np.sin(angles)
        turned = np.stack([np.full(len(angles), b[0]), y * c - z * s, y * s + z * c], axis=1)
        away = turned - bases_B[k]
        off = away - np.outer(away @ spans_B[k], spans_B[k])
        cost += found[k] * np.log1p(np.sum(off**2, axis=1) / (_OFF_LINE * float(shape.wing[-1, 0])) ** 2)
    best = float(angles[np.argmin(cost)])
    return np.array([[1.0, 0.0, 0.0], [0.0, np.cos(best), -np.sin(best)], [0.0, np.sin(best), np.cos(best)]])


def _long_axis(points: FloatArray) -> FloatArray:
    """(3,) first principal axis of points (N, 3)."""
    away = points - points.mean(axis=0)
    return np.linalg.eigh(away.T @ away)[1][:, -1]


def _upright(forward: FloatArray, across: FloatArray) -> FloatArray:
    """(3, 3) forward, right, down: forward as given, right as near to `across` as it can be."""
    right = across - (across @ forward) * forward
    right = right / np.linalg.norm(right)
    return np.stack([forward, right, np.cross(forward, right)], axis=1)


def _covariance(parts: Dissection, stance: Stance) -> FloatArray:
    size = parts.hull.size
    spread = np.empty(STEPS)
    spread[MOVE] = _SPREAD_MOVE * size if parts.found[0] else 1e-3
    spread[TURN] = [_SPREAD_ROLL, _SPREAD_TURN, _SPREAD_TURN]
    covariance = np.zeros((STEPS, STEPS))
    for k in (0, 1):
        span = stance.wings_B[k][:, 0]
        along, across = np.outer(span, span), np.eye(3) - np.outer(span, span)
        turn = _SPREAD_PITCH**2 * along + _SPREAD_SPAN**2 * across
        covariance[WING_TURN[k], WING_TURN[k]] = turn if parts.found[k + 1] else np.eye(3) * (60 * deg) ** 2
        spread[BASE_MOVE[k]] = _SPREAD_BASE * size
    for columns in (MOVE, TURN, *BASE_MOVE):
        covariance[columns, columns] = np.diag(spread[columns] ** 2)
    return covariance

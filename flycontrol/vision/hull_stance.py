"""Body and wings from a dissected hull by its principal axes: what Hull Reconstruction Motion Tracking reads off it."""

from __future__ import annotations

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
from flycontrol.vision.wing_chord import diagonal

FloatArray = NDArray[np.float64]

_ROUNDS = 4  #: of parting voxels and reading axes, which come to rest in two or three
_TOO_FAR = np.cos(np.radians(60.0))  #: of a span from the expected one
_SECTION = 0.12  #: half width of the section from which the chord is read, in wing lengths
_OUTER = 0.3  #: of the wing length from the base: nearer voxels belong to body and wing alike
#: Of hull coordinates, by comparison with simulated flights (C): lengths in voxels, turns in radians.
_SPREAD_MOVE, _SPREAD_TURN, _SPREAD_ROLL = 1.5, 3 * deg, 20 * deg
_SPREAD_SPAN, _SPREAD_PITCH, _SPREAD_BASE = 15 * deg, 30 * deg, 4.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HullStance:
    """What a hull says of a fly."""

    stance: Stance
    covariance: FloatArray  #: (18, 18) of steps from the stance [m, rad]; as large as a turn for parts not found
    dissection: Dissection


def stance_of_hull(hull: VisualHull, seed: Stance, shape: FlyShape, stroke_plane_angle: float) -> HullStance:
    """Long axes are principal axes, chords diagonals of sections, roll the line from wing base to wing base.

    Parts that were not found stay where the seed has them. A leading edge is above its trailing edge, over the stroke
    plane: wings pitch between 0 and 180 deg.

    Parameters
    ----------
    hull : its voxels
    seed : the stance expected; it tells left from right and head from tail
    shape : sizes of the fly
    stroke_plane_angle : v_S = Ry(angle) v_B [rad]
    """
    stance, parts = seed, dissect(hull, seed, shape)
    up_B = pitch_rotation(stroke_plane_angle).T @ np.array([0.0, 0.0, -1.0])
    for _ in range(_ROUNDS):
        if not parts.found[0]:
            break
        stance = _read(parts, stance, shape, up_B)
        again = dissect(hull, stance, shape)
        settled = np.array_equal(again.labels, parts.labels)
        parts = again
        if settled:
            break
    return HullStance(stance=stance, covariance=_covariance(parts, stance), dissection=parts)


def _read(parts: Dissection, seed: Stance, shape: FlyShape, up_B: FloatArray) -> Stance:
    body = parts.part(BODY)
    centre, forward = body.mean(axis=0), _long_axis(body)
    forward = forward if forward @ seed.body_axes_W[:, 0] >= 0 else -forward
    axes = [seed.wing_axes_W(k) for k in (0, 1)]
    bases = np.array([centre + seed.body_axes_W @ seed.bases_B[k] for k in (0, 1)])
    for k, label in enumerate((LEFT, RIGHT)):
        if parts.found[label - 1]:
            axes[k], bases[k] = _wing(parts.part(label), axes[k], bases[k], shape, seed.body_axes_W @ up_B)
            axes[k][:, 2] *= 2 * k - 1
    across = bases[1] - bases[0] if all(parts.found) else seed.body_axes_W[:, 1]
    R = _upright(forward, across)
    return replace(
        seed,
        position_W=centre,
        body_axes_W=R,
        wings_B=np.stack([R.T @ wing for wing in axes]),
        bases_B=(bases - centre) @ R,
    )


def _wing(
    points: FloatArray, seed: FloatArray, base: FloatArray, shape: FlyShape, up: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """(3, 3) span, chord, span x chord and (3,) base of a wing from its voxels (N, 3) and what was expected."""
    length, plate = float(shape.wing[-1, 0]), _plate(shape)
    outer = points[(points - base) @ seed[:, 0] > _OUTER * length]
    points = outer if len(outer) > 10 else points
    middle, span = points.mean(axis=0), _long_axis(points)
    span = span if span @ seed[:, 0] >= 0 else -span
    if span @ seed[:, 0] < _TOO_FAR:
        span = seed[:, 0]  # the voxels of a wing half hidden may be wider than long
    chord = _chord(points - middle, span, seed[:, 1], length)
    chord = chord if chord @ up >= 0 else -chord
    turned = np.cos(plate.tilt) * span - np.sin(plate.tilt) * chord
    chord = np.cos(plate.tilt) * chord + np.sin(plate.tilt) * span
    reach = np.percentile((points - middle) @ turned, 99.0)
    axes = np.stack([turned, chord, np.cross(turned, chord)], axis=1)
    return axes, middle + (reach - length) * turned - plate.chordwise * chord


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


def _chord(from_middle: FloatArray, span: FloatArray, seed: FloatArray, length: float) -> FloatArray:
    """(3,) across the span; the expected chord where the section has none."""
    first = seed - (seed @ span) * span
    norm = np.linalg.norm(first)
    first = first / norm if norm > 1e-6 else np.linalg.svd(span[None])[2][1]
    plane = np.stack([first, np.cross(span, first)])
    section = from_middle[np.abs(from_middle @ span) < _SECTION * length] @ plane.T
    found = diagonal(section, np.array([1.0, 0.0]))
    return first if found is None else found @ plane


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

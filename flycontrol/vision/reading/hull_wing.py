"""A wing from its voxels: its span by their principal axis, its chord by the diagonals of their section."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flycontrol.vision.dissection import RIGHT, Dissection
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.kernels.section import section
from flycontrol.vision.reading.axes import across, cross
from flycontrol.vision.reading.moments import moments_of_points
from flycontrol.vision.reading.wing_chord import diagonals

FloatArray = NDArray[np.float64]

_TOO_FAR = np.cos(np.radians(60.0))  #: of a span from the expected one
_SAME_CHORD = np.cos(np.radians(15.0))  #: of a diagonal from the expected chord
_SECTION = 0.12  #: half width of the section from which the chord is read, in wing lengths
_OUTER = 0.3  #: of the wing length from the base: nearer voxels belong to body and wing alike
_TIP = 0.99  #: of the voxels are nearer to the base than the tip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HullWing:
    """Where a wing may be, in the world."""

    axes: FloatArray  #: (3, 3) span, chord, normal
    base: FloatArray  #: (3,) [m]


def wings_of_voxels(parts: Dissection, label: int, seed: HullWing, shape: FlyShape, up: FloatArray) -> list[HullWing]:
    """The wings that the voxels of one label may be, by what was expected: one for each way the chord may lie.

    Parameters
    ----------
    parts : of the hull
    label : LEFT or RIGHT
    seed : the wing expected
    shape : of the fly
    up : (3,) to where leading edges point
    """
    length, outward = float(shape.wing[-1, 0]), np.ascontiguousarray(seed.axes[:, 0])
    points = parts.beyond(label, seed.base, outward, _OUTER * length)
    points = points if len(points) > 10 else parts.beyond(label, seed.base, outward, -np.inf)
    moments = moments_of_points(points)
    span = moments.long_axis
    span = span if span @ outward >= 0 else -span
    if span @ outward < _TOO_FAR:
        span = outward  # the voxels of a wing half hidden may be wider than long
    cloud = _Cloud(points=points, middle=moments.middle, base=seed.base)
    chords = (chord if chord @ up >= 0 else -chord for chord in _chords(cloud, span, seed.axes[:, 1], length))
    return [_wing(cloud, span, chord, shape, 1 if label == RIGHT else -1) for chord in chords]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Cloud:
    """The outer voxels of a wing."""

    points: FloatArray  #: (N, 3) counted from the base [m]
    middle: FloatArray  #: (3,) likewise
    base: FloatArray  #: (3,) [m]


def _wing(cloud: _Cloud, span: FloatArray, chord: FloatArray, shape: FlyShape, hand: int) -> HullWing:
    """The wing by its long axis and its chord; hand -1 for a left wing."""
    length, plate = float(shape.wing[-1, 0]), _plate(shape)
    turned = np.cos(plate.tilt) * span - np.sin(plate.tilt) * chord
    chord = np.cos(plate.tilt) * chord + np.sin(plate.tilt) * span
    reach = _nearly_all(cloud.points @ turned)
    axes = np.stack([turned, chord, hand * cross(turned, chord)], axis=1)
    from_base = cloud.middle + (reach - cloud.middle @ turned - length) * turned - plate.chordwise * chord
    return HullWing(axes=axes, base=cloud.base + from_base)


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


def _chords(cloud: _Cloud, span: FloatArray, seed: FloatArray, length: float) -> list[FloatArray]:
    """(3,) across the span: the diagonals of the section, and the expected chord if it is none of them."""
    first = across(span, seed)
    second = cross(span, first)
    found = diagonals(section(cloud.points, cloud.middle, span, _SECTION * length, first, second))
    ways = [way[0] * first + way[1] * second for way in found]
    near = any(abs(way[0]) > _SAME_CHORD for way in found)
    return ways if near else [first, *ways]


def _nearly_all(along: FloatArray) -> float:
    """The quantile of places (N,) that tells the tip, straight between neighbours."""
    place = _TIP * (len(along) - 1)
    k = int(place)
    below, above = np.partition(along, (k, min(k + 1, len(along) - 1)))[[k, min(k + 1, len(along) - 1)]]
    return float(below + (place - k) * (above - below))

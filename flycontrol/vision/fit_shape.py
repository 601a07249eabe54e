"""A parametric fly in the form in which it is fitted: spheres along the body, a polygon for a wing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flycontrol.vision.fly_shape import FlyShape

FloatArray = NDArray[np.float64]

_SPHERES = 24  #: between them the body is drawn too thin by up to 3 um at 2.4 mm
_FINE = 400
_BARE, _RINGS, _AROUND = 4e-3, 3, 12  #: of the body length, what may be left out; rings at the most; spheres of a ring
_FLAT = 2e-3  #: of the wing length: corners of the outline that far from the line past them are left out


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitShape:
    """Lengths in [m]."""

    spheres: FloatArray  #: (K, 4) centres in body axes, radii
    outline: FloatArray  #: (M, 2) along span and chord, once around the wing
    half_thickness: float
    bases_B: FloatArray  #: (2, 3) left, right
    wing_length: float
    body_length: float


@lru_cache(maxsize=16)
def fit_shape(shape: FlyShape) -> FitShape:
    """The spheres that fill the body, and the wing's corners."""
    return FitShape(
        spheres=body_spheres(shape),
        outline=wing_outline(shape),
        half_thickness=shape.wing_thickness / 2,
        bases_B=np.stack([shape.right_base_B * [1.0, -1.0, 1.0], shape.right_base_B]),
        wing_length=float(shape.wing[-1, 0]),
        body_length=shape.body_length,
    )


def body_spheres(shape: FlyShape) -> FloatArray:
    """(K, 4) centres in body axes and radii [m]: the largest spheres about the axis that the body holds, and rings.

    Where the body is rounder than a sphere, as at a head that is wider than long, spheres about the axis leave its
    sides out; there rings of spheres are added until the profile is covered.
    """
    x, r = shape.profile.T
    fine = np.linspace(x[0], x[-1], _FINE)
    border = np.stack([fine, np.interp(fine, x, r)], axis=1)
    places = np.linspace(x[0], x[-1], _SPHERES + 2)[1:-1]
    along = np.stack([places, np.zeros(_SPHERES)], axis=1)
    spheres = [np.insert(row, 2, 0.0) for row in np.column_stack([along, _inscribed(along, border)])]
    bare = _gap(border, along, _inscribed(along, border)) > _BARE * shape.body_length
    grid = np.stack(np.meshgrid(fine[::5], np.linspace(0.05, 0.95, 19) * r.max(), indexing="ij"), axis=-1).reshape(
        -1, 2
    )
    grid = grid[grid[:, 1] < np.interp(grid[:, 0], x, r)]
    radius = _inscribed(grid, border)
    for _ in range(_RINGS):
        reached = np.abs(np.linalg.norm(border[bare][None] - grid[:, None], axis=2) - radius[:, None])
        served = np.count_nonzero(reached < _BARE * shape.body_length, axis=1)
        if not bare.any() or not served.max():
            break
        k = int(np.argmax(served))
        spheres += _ring(grid[k], radius[k])
        bare &= _gap(border, grid[k : k + 1], radius[k : k + 1]) > _BARE * shape.body_length
    return np.ascontiguousarray(spheres)


def _inscribed(centres: FloatArray, border: FloatArray) -> FloatArray:
    """(N,) radii of the largest circles about points (N, 2) of a meridian that its border (M, 2) leaves room for."""
    return np.min(np.linalg.norm(centres[:, None] - border[None], axis=2), axis=1)


def _gap(border: FloatArray, centres: FloatArray, radius: FloatArray) -> FloatArray:
    """(M,) distance from each point of a border to the nearest of some circles."""
    return np.min(np.linalg.norm(border[:, None] - centres[None], axis=2) - radius, axis=1)


def _ring(centre: FloatArray, radius: float) -> list[FloatArray]:
    angle = 2 * np.pi * np.arange(_AROUND) / _AROUND
    return [np.array([centre[0], centre[1] * np.cos(a), centre[1] * np.sin(a), radius]) for a in angle]


def wing_outline(shape: FlyShape) -> FloatArray:
    """(M, 2) corners along the leading edge to the tip and back along the trailing edge, without needless ones."""
    span, leading, trailing = shape.wing.T
    there, back = np.stack([span, leading], axis=1), np.stack([span, trailing], axis=1)[::-1]
    corners = np.concatenate([_straightened(there, _FLAT * span[-1]), _straightened(back, _FLAT * span[-1])])
    apart = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1) > 1e-6 * span[-1]
    return np.ascontiguousarray(corners[apart])


def _straightened(line: FloatArray, tolerance: float) -> FloatArray:
    """Ends of a line, and the corner farthest from the chord between them as long as it is beyond the tolerance."""
    chord = line[-1] - line[0]
    away = line - line[0]
    height = np.abs(chord[0] * away[:, 1] - chord[1] * away[:, 0]) / max(float(np.hypot(*chord)), 1e-30)
    k = int(np.argmax(height))
    if height[k] <= tolerance or len(line) < 3:
        return line[[0, -1]]
    return np.concatenate([_straightened(line[: k + 1], tolerance)[:-1], _straightened(line[k:], tolerance)])

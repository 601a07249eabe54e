"""A parametric fly to be drawn and fitted: a body of revolution, two flat wings and, if wanted, six legs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.planform import Planform
from flycontrol.units import um

FloatArray = NDArray[np.float64]

#: Head, thorax and abdomen as ellipsoids: middle behind the nose, half length, radius, over the body length (C).
_PARTS = ((0.09, 0.09, 0.13), (0.34, 0.20, 0.20), (0.70, 0.30, 0.17))
#: Direction of the right wing's base from the long axis: to the right and up, as of the published hinge (C).
_BASE_BEHIND_NOSE, _BASE_RIGHT, _BASE_UP = 0.31, 0.78, 0.63
#: Legs of the right side over the body length: forward of the base of the leg, right, down, joint by joint (C).
_LEGS = (
    ((0.30, 0.08, 0.14), (0.34, 0.16, 0.28), (0.22, 0.18, 0.40), (0.14, 0.16, 0.44)),
    ((0.16, 0.10, 0.17), (0.12, 0.22, 0.30), (-0.06, 0.24, 0.38), (-0.18, 0.20, 0.40)),
    ((0.06, 0.09, 0.16), (-0.10, 0.20, 0.28), (-0.34, 0.20, 0.34), (-0.52, 0.16, 0.34)),
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlyShape:
    """Lengths in [m]; body axes forward, right, down from the centre of the body's volume."""

    profile: FloatArray  #: (M, 2) place along the body, rising, and radius there
    wing: FloatArray  #: (S, 3) place along the span from the base, rising; leading and trailing edge along the chord
    right_base_B: FloatArray  #: (3,) where the right wing grows; the left one mirrored
    wing_thickness: float = 30 * um  #: with veins and motion blur; real membranes are thinner (C)
    legs: FloatArray | None = None  #: (L, J, 3) joints of the legs, body axes
    leg_radius: float = 25 * um

    def __post_init__(self) -> None:
        for name, columns in (("profile", 2), ("wing", 3)):
            rows = np.asarray(getattr(self, name), dtype=np.float64)
            if rows.ndim != 2 or rows.shape[1] != columns or len(rows) < 2 or not np.all(np.diff(rows[:, 0]) > 0):
                raise InvalidParameterError(f"FlyShape.{name} needs rows of {columns} with a rising first column.")
            rows.setflags(write=False)
        if np.any(self.profile[:, 1] < 0) or np.any(self.wing[:, 1] < self.wing[:, 2]):
            raise InvalidParameterError("FlyShape needs radii >= 0 and leading edges before the trailing ones.")

    @property
    def body_length(self) -> float:
        """[m]."""
        return float(np.ptp(self.profile[:, 0]))

    @property
    def body_volume(self) -> float:
        """Integral of pi r^2 dx, the profile straight between its rows [m^3]."""
        x, r = self.profile.T
        return float(np.pi / 3 * np.sum(np.diff(x) * (r[1:] ** 2 + r[1:] * r[:-1] + r[:-1] ** 2)))


def fly_shape(
    planform: Planform, *, body_length: float | None = None, pitch_axis: float = 0.25, legs: bool = False
) -> FlyShape:
    """A fly with the wings of a planform and the package's own drawing of a body, as long as its wings by default.

    Parameters
    ----------
    planform : of one wing
    body_length : [m]
    pitch_axis : x0, where the span's axis crosses each chord, from the leading edge, in chords
    legs : whether it has legs, folded as in flight
    """
    length = planform.length if body_length is None else body_length
    if not (length > 0 and np.isfinite(length)):
        raise InvalidParameterError(f"A body needs a finite length > 0 m, got {body_length!r}.")
    behind, radius = _outline_of_body()
    centre = _centroid(behind, radius)
    profile = np.stack([centre - behind, radius], axis=1)[::-1] * length
    x = (1 - np.cos(np.linspace(0, np.pi, 25))) / 2
    chord = planform.chord(np.clip(x, 1e-6, 1 - 1e-6))  # a beta distribution may be steep at its ends
    wing = np.stack([planform.length * x, pitch_axis * chord, (pitch_axis - 1) * chord], axis=1)
    out = float(np.interp(_BASE_BEHIND_NOSE, behind, radius))
    base = np.array([centre - _BASE_BEHIND_NOSE, _BASE_RIGHT * out, -_BASE_UP * out]) * length
    bare = FlyShape(profile=profile, wing=wing, right_base_B=base)
    return with_legs(bare) if legs else bare


def with_legs(shape: FlyShape) -> FlyShape:
    """The fly with six legs, folded as in flight, as long as its body asks for."""
    return replace(shape, legs=_both_sides(np.array(_LEGS)) * shape.body_length)


def _outline_of_body() -> tuple[FloatArray, FloatArray]:
    """Places behind the nose and radii over the body length."""
    places = [c - a * np.cos(np.linspace(0, np.pi, 21)) for c, a, _ in _PARTS]
    x = np.unique(np.round(np.concatenate(places), 9))
    radii = [r * np.sqrt(np.clip(1 - ((x - c) / a) ** 2, 0, None)) for c, a, r in _PARTS]
    return x, np.max(radii, axis=0)


def _centroid(x: FloatArray, r: FloatArray) -> float:
    fine = np.linspace(x[0], x[-1], 2001)
    area = np.interp(fine, x, r) ** 2
    return float(np.sum(fine * area) / np.sum(area))


def _both_sides(right: FloatArray) -> FloatArray:
    return np.concatenate([right, right * [1.0, -1.0, 1.0]])

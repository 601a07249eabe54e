"""Triangles over the surface of a parametric fly, part by part, and where a pose puts them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.pose import Pose
from flycontrol.vision.fly_shape import FlyShape

FloatArray = NDArray[np.float64]
FaceArray = NDArray[np.int64]
Part = Literal["body", "left", "right", "legs"]

ALL: tuple[Part, ...] = ("body", "left", "right", "legs")

_AROUND_BODY, _AROUND_LEG = 32, 6  #: corners of a ring: a 32-gon is inscribed within 0.5 % of its circle


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Patch:
    """Vertices (V, 3) [m] in the axes of their part, and faces (F, 3) that name three vertices each."""

    vertices: FloatArray
    faces: FaceArray


@lru_cache(maxsize=64)
def patch_of(shape: FlyShape, part: Part) -> Patch:
    """Surface of one part: body and legs in body axes; a wing in its own, span, chord, normal from the base."""
    if part == "body":
        rings = [_ring(x, r, _AROUND_BODY) for x, r in shape.profile]
        return _joined([_tube(np.array(rings))])
    if part == "legs":
        legs = [] if shape.legs is None else [_leg(joints, shape.leg_radius) for joints in shape.legs]
        return _joined(legs)
    return _slab(shape)


def placed(shape: FlyShape, pose: Pose, part: Part) -> FloatArray:
    """(N, V, 3) vertices of a part in the world [m] at the N instants of a pose."""
    vertices = patch_of(shape, part).vertices
    if part in ("left", "right"):
        axes, origin = pose.wing_axes_W(part), pose.base_W(part)
    else:
        axes, origin = pose.body_axes_W, pose.position_W
    return np.einsum("nij,vj->nvi", axes, vertices) + origin[:, None, :]


def _ring(x: float, radius: float, corners: int) -> FloatArray:
    angle = 2 * np.pi * np.arange(corners) / corners
    return np.stack([np.full(corners, x), radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def _tube(rings: FloatArray) -> Patch:
    """Skin between rings (R, K, 3), and flat lids."""
    count, corners = rings.shape[:2]
    here = np.arange(corners)
    along = (here + 1) % corners
    faces = []
    for k in range(count - 1):
        near, far = k * corners, (k + 1) * corners
        faces += [
            np.stack([near + here, near + along, far + here], 1),
            np.stack([far + here, near + along, far + along], 1),
        ]
    inner = np.arange(1, corners - 1)
    for first in (0, (count - 1) * corners):
        faces.append(np.stack([np.full_like(inner, first), first + inner, first + inner + 1], 1))
    return Patch(vertices=rings.reshape(-1, 3), faces=np.concatenate(faces).astype(np.int64))


def _leg(joints: FloatArray, radius: float) -> Patch:
    rings = []
    for k, joint in enumerate(joints):
        ahead = joints[min(k + 1, len(joints) - 1)] - joints[max(k - 1, 0)]
        across = np.linalg.svd(ahead[None])[2][1:]
        rings.append(joint + _ring(0.0, radius, _AROUND_LEG)[:, 1:] @ across)
    return _tube(np.array(rings))


def _slab(shape: FlyShape) -> Patch:
    """A flat wing of some thickness: four vertices a station, leading and trailing, above and below."""
    span, leading, trailing = shape.wing.T
    half = np.full_like(span, shape.wing_thickness / 2)
    corners = [(leading, half), (trailing, half), (trailing, -half), (leading, -half)]
    return _tube(np.stack([np.stack([span, chord, normal], axis=1) for chord, normal in corners], axis=1))


def _joined(patches: list[Patch]) -> Patch:
    if not patches:
        return Patch(vertices=np.empty((0, 3)), faces=np.empty((0, 3), np.int64))
    starts = np.cumsum([0] + [len(patch.vertices) for patch in patches[:-1]])
    return Patch(
        vertices=np.concatenate([patch.vertices for patch in patches]),
        faces=np.concatenate([patch.faces + start for patch, start in zip(patches, starts, strict=True)]),
    )

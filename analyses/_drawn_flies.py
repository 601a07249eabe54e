"""Two flies of different models drawn alike, so that only their places differ; for `beside_another_tracker.py`."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.camera import Camera
from flycontrol.units import um
from flycontrol.vision.kernels.fill import fill_triangles

FloatArray = NDArray[np.float64]
FaceArray = NDArray[np.int64]
Masks = tuple[NDArray[np.bool_], ...]
Part = Literal["body", "left wing", "right wing"]

PARTS: tuple[Part, ...] = ("body", "left wing", "right wing")

# Either fly is a body of revolution (the other one's is 1.2 times as wide as high) and two flat wings, here drawn
# 30 um thick. A body is placed by the centre of its volume, a wing by the centre of its area and by the long axis of
# its outline, so that no model's choice of origin or of a wing's axis counts as a difference.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawing:
    """What a fly looks like; lengths in [m]."""

    body: FloatArray  #: (M, 2) place along the body from the centre of volume, and radius there
    width: float  #: of a section over its height
    wing: FloatArray  #: (K, 2) outline from the centre of area, along its long axis and towards the leading edge
    centre: FloatArray  #: (2,) of the wing's area from its base, along the model's span and chord
    tilt: float  #: of the wing's long axis, from the model's span towards its chord [rad]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Placed:
    """Where a fly is, world z up."""

    position: FloatArray  #: (3,) centre of the body's volume [m]
    body: FloatArray  #: (3, 3) columns forward, right, down
    wing_centres: FloatArray  #: (2, 3) of the areas of the left and of the right wing [m]
    wings: FloatArray  #: (2, 3, 3) columns long axis, towards the leading edge, normal

    def with_part(self, part: Part, other: "Placed") -> "Placed":
        """Place one part as another fly has it."""
        if part == "body":
            return replace(self, position=other.position, body=other.body)
        k = PARTS.index(part) - 1
        centres, wings = self.wing_centres.copy(), self.wings.copy()
        centres[k], wings[k] = other.wing_centres[k], other.wings[k]
        return replace(self, wing_centres=centres, wings=wings)


def drawing_of(profile: FloatArray, width: float, outline: FloatArray) -> Drawing:
    """Of a body's profile (M, 2) and a wing's outline (K, 2) from its base along span and chord [m]."""
    x, r = profile.T
    fine = np.linspace(x[0], x[-1], 2001)
    area = np.interp(fine, x, r) ** 2
    centre, second = polygon_moments(outline)
    tilt = 0.5 * np.arctan2(2 * second[0, 1], second[0, 0] - second[1, 1])
    return Drawing(
        body=np.stack([x - np.sum(fine * area) / np.sum(area), r], axis=1),
        width=width,
        wing=(outline - centre) @ in_plane(tilt),
        centre=centre,
        tilt=float(tilt),
    )


def polygon_moments(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centre (2,) and second moments (2, 2) over the area, of a polygon (K, 2): triangles from its first corner."""
    a, b, c = corners[0], corners[1:-1], corners[2:]
    weight = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    middles = np.stack([(a + b) / 2, (b + c) / 2, (c + a) / 2])  # exact for squares
    centre = np.einsum("k,mkj->j", weight, middles) / (3 * weight.sum())
    away = middles - centre
    return centre, np.einsum("k,mki,mkj->ij", weight, away, away) / (3 * weight.sum())


def in_plane(angle: float) -> FloatArray:
    """(2, 2) columns: span and chord turned by an angle from the span towards the chord [rad]."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def placed(position: FloatArray, body: FloatArray, bases: FloatArray, wings: FloatArray, drawing: Drawing) -> Placed:
    """A fly of a model's own bases (2, 3) and axes (2, 3, 3) span, chord, normal of its wings."""
    plane = wings[:, :, :2]
    turned = plane @ in_plane(drawing.tilt)
    return Placed(
        position=position,
        body=body,
        wing_centres=bases + plane @ drawing.centre,
        wings=np.concatenate([turned, wings[:, :, 2:]], axis=2),
    )


def drawn(drawing: Drawing, fly: Placed, cameras: Sequence[Camera]) -> Masks:
    """Its silhouettes."""
    parts = [tube(drawing, fly), *(plate(drawing, fly, k) for k in (0, 1))]
    images = []
    for camera in cameras:
        image = np.zeros(camera.shape, dtype=bool)
        for points, faces in parts:
            fill_triangles(camera.project(points), faces, image)
        images.append(image)
    return tuple(images)


def tube(drawing: Drawing, fly: Placed) -> tuple[FloatArray, FaceArray]:
    """Points of a body in the world, and triangles between them."""
    x, r = drawing.body.T
    angle = 2 * np.pi * np.arange(32) / 32
    round_about = np.stack([np.zeros(32), drawing.width * np.cos(angle), np.sin(angle)], axis=1)
    rings = x[:, None, None] * [1.0, 0.0, 0.0] + r[:, None, None] * round_about
    return rings.reshape(-1, 3) @ fly.body.T + fly.position, skin(len(x), 32)


def plate(drawing: Drawing, fly: Placed, side: int, thickness: float = 30 * um) -> tuple[FloatArray, FaceArray]:
    """Points of a wing in the world, and triangles: from the middle of either face to its outline, and the rim."""
    flat = np.stack([np.zeros_like(drawing.wing), drawing.wing, drawing.wing, np.zeros_like(drawing.wing)])
    height = np.array([1, 1, -1, -1])[:, None, None] * np.full((4, len(drawing.wing), 1), thickness / 2)
    points = np.concatenate([flat, height], axis=2).reshape(-1, 3)
    return points @ fly.wings[side].T + fly.wing_centres[side], skin(4, len(drawing.wing))


def skin(rings: int, corners: int) -> FaceArray:
    """(F, 3) triangles between rings of as many corners."""
    k, i = (index.ravel() for index in np.indices((rings - 1, corners)))
    here, along = k * corners + i, k * corners + (i + 1) % corners
    far, far_along = here + corners, along + corners
    return np.concatenate([np.stack([here, along, far], 1), np.stack([far, along, far_along], 1)])


def overlap(drawing: Drawing, fly: Placed, masks: Masks, cameras: Sequence[Camera]) -> FloatArray:
    """(C,) intersection over union of a fly and the silhouettes; NaN for a fly that was lost."""
    if not np.all(np.isfinite(fly.position)):
        return np.full(len(masks), np.nan)
    pairs = zip(drawn(drawing, fly, cameras), masks, strict=True)
    return np.array([np.count_nonzero(a & b) / np.count_nonzero(a | b) for a, b in pairs])

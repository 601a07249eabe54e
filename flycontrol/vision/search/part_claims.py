"""What the silhouettes say of each part of a fitted fly by itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.vision.fit_shape import FitShape
from flycontrol.vision.kernels.shares import claims
from flycontrol.vision.soft_silhouette import BorderDistance
from flycontrol.vision.stance import Stance

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PartClaims:
    """Pixels of body, left and right wing in C views."""

    whole: FloatArray  #: (C, 3) of the part
    alone: FloatArray  #: (C, 3) of the part and no other
    denied: FloatArray  #: (C, 3) of those, surely off the silhouette
    missed: FloatArray  #: (C,) of the silhouette, surely off the fly: legs, or a part that is elsewhere


def part_claims(border: BorderDistance, shape: FitShape, stance: Stance, slack: float) -> PartClaims:
    """Count what each part claims; what is within `slack` [px] of a border is not surely on either side of it."""
    count = len(border.cameras)
    parts, missed = np.zeros((count, 3, 3)), np.zeros(count)
    cameras = np.stack([camera.matrix for camera in border.cameras])
    axes, wings = np.ascontiguousarray(stance.body_axes_W), np.ascontiguousarray(stance.wings_B)
    claims(
        cameras, border.distance, border.corner, border.extent, border.image, slack,
        stance.position_W, axes, wings, np.ascontiguousarray(stance.bases_B),
        shape.spheres, shape.outline, shape.half_thickness, parts, missed,
    )  # fmt: skip
    return PartClaims(whole=parts[..., 0], alone=parts[..., 1], denied=parts[..., 2], missed=missed)

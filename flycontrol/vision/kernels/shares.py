"""Which pixels of a view each part of a posed fly claims, and which of these the silhouette denies."""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.vision.kernels.fly_image import draw_fly, empty_image, look_at
from flycontrol.vision.kernels.part_distance import disc_distance, distance_to_box, wing_distance


@numba.njit(cache=True)
def claims(cameras, distance, corner, extent, size, slack, position, R, A, base, spheres, outline, half, parts, missed):
    """Count pixels of body, left and right wing in every view.

    Parameters
    ----------
    cameras : (C, 3, 4) from [m] to [px]
    distance : (C, V, U) D, signed distance to the silhouettes' borders, > 0 outside, cropped [px]
    corner : (C, 2) u, v of the crops' first pixel
    extent : (C, 2) columns and rows of each crop
    size : (C, 2) columns and rows of each image
    slack : a pixel farther than this from a border is surely on one side of it [px]
    position : (3,) [m];  R : (3, 3) body to world
    A : (2, 3, 3) left and right wing's span, chord, normal in body axes;  base : (2, 3) [m]
    spheres : (K, 4) centre in body axes, radius [m];  outline : (M, 2) span, chord [m];  half : thickness / 2 [m]
    parts : (C, 3, 3) written: for each part its pixels, those of no other part, and of these those surely off the
        silhouette
    missed : (C,) written: pixels of the silhouette surely off the fly
    """
    fly, image = (position, R, A, base, spheres, outline, half), empty_image(spheres, outline)
    near_body, near_wing, away, look = np.empty(4), np.empty((2, 4)), np.empty(3), np.empty(4, np.int64)
    parts[:], missed[:] = 0.0, 0.0
    for c in range(cameras.shape[0]):
        draw_fly(cameras[c], fly, image)
        look_at(image[4], slack, corner[c], extent[c], size[c], 1, look)
        for i in range(look[2], look[3]):
            for j in range(look[0], look[1]):
                _distances(image, slack, corner[c, 0] + j, corner[c, 1] + i, near_body, near_wing, away)
                D = distance[c, i, j] if 0 <= i < extent[c, 1] and 0 <= j < extent[c, 0] else 1e30
                if D < 0.0 and min(away[0], away[1], away[2]) > slack:
                    missed[c] += 1.0
                alone = (away[0] <= 0.0) + (away[1] <= 0.0) + (away[2] <= 0.0) == 1
                for part in range(3):
                    if away[part] <= 0.0:
                        parts[c, part, 0] += 1.0
                        parts[c, part, 1] += 1.0 if alone else 0.0
                        parts[c, part, 2] += 1.0 if alone and slack < D else 0.0


@numba.njit(cache=True)
def _distances(image, slack, u, v, near_body, near_wing, away):
    """Write the distances of a pixel to body, left and right wing; those beyond the slack are bounds."""
    discs, wings, edges, sweep, boxes = image
    for part in range(3):
        away[part] = distance_to_box(boxes, part, u, v)
        if away[part] <= slack:
            if part == 0:
                away[0] = disc_distance(discs, u, v, near_body)
            else:
                away[part] = wing_distance(wings, edges, sweep, part - 1, u, v, near_wing)

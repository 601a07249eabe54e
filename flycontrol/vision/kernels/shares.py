"""Which pixels of a view each part of a posed fly claims, and which of these the silhouette denies."""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.vision.kernels.cover import (
    _box,
    _disc_distance,
    _edges_of,
    _looked_at,
    _outside,
    _sphere_images,
    _wing_distance,
    _wing_image,
)


@numba.njit(cache=True)
def claims(
    cameras, distance, corner, extent, image, slack, position, R, A, base, spheres, outline, half, parts, missed
):
    """Count pixels of body, left and right wing in every view.

    Parameters
    ----------
    cameras : (C, 3, 4) from [m] to [px]
    distance : (C, V, U) D, signed distance to the silhouettes' borders, > 0 outside, cropped [px]
    corner : (C, 2) u, v of the crops' first pixel
    extent : (C, 2) columns and rows of each crop
    image : (C, 2) columns and rows of each image
    slack : a pixel farther than this from a border is surely on one side of it [px]
    position : (3,) [m];  R : (3, 3) body to world
    A : (2, 3, 3) left and right wing's span, chord, normal in body axes;  base : (2, 3) [m]
    spheres : (K, 4) centre in body axes, radius [m];  outline : (M, 2) span, chord [m];  half : thickness / 2 [m]
    parts : (C, 3, 3) written: for each part its pixels, those of no other part, and of these those surely off the
        silhouette
    missed : (C,) written: pixels of the silhouette surely off the fly
    """
    near_body, near_wing, away = np.empty(4), np.empty((2, 4)), np.empty(3)
    discs = np.empty((spheres.shape[0], 3))
    wings, edges, sweep = np.empty((2, outline.shape[0], 2)), np.empty((2, outline.shape[0], 3)), np.empty((2, 2))
    boxes, look = np.empty((3, 4)), np.empty(4, np.int64)
    parts[:], missed[:] = 0.0, 0.0
    for c in range(cameras.shape[0]):
        P = cameras[c]
        _sphere_images(P, position, R, spheres, discs)
        boxes[0] = _box(discs, discs[:, 2])
        for side in range(2):
            _wing_image(P, position, R, A[side], base[side], outline, half, wings[side], sweep[side])
            _edges_of(wings[side], edges[side])
            boxes[side + 1] = _box(wings[side], np.full(outline.shape[0], abs(sweep[side, 0]) + abs(sweep[side, 1])))
        _looked_at(boxes[0], boxes[1], boxes[2], slack, corner[c], extent[c], image[c], 1, look)
        for i in range(look[2], look[3]):
            v = corner[c, 1] + i
            for j in range(look[0], look[1]):
                u = corner[c, 0] + j
                framed = 0 <= i < extent[c, 1] and 0 <= j < extent[c, 0]
                D = distance[c, i, j] if framed else 1e30
                claimed = 0
                for part in range(3):
                    away[part] = _outside(boxes[part], u, v)
                    if away[part] <= slack:
                        if part == 0:
                            away[0] = _disc_distance(discs, u, v, near_body)
                        else:
                            away[part] = _wing_distance(wings, edges, sweep, part - 1, u, v, near_wing)
                    if away[part] <= 0.0:
                        claimed += 1
                if D < 0.0 and min(away[0], away[1], away[2]) > slack:
                    missed[c] += 1.0
                for part in range(3):
                    if away[part] <= 0.0:
                        parts[c, part, 0] += 1.0
                        if claimed == 1:
                            parts[c, part, 1] += 1.0
                            parts[c, part, 2] += 1.0 if slack < D else 0.0

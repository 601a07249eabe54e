"""The parts of a posed fly in one image: discs (spheres in its body), and two polygons swept by a thickness (wings).

A fly is the tuple (position (3,) [m], R (3, 3) body to world, A (2, 3, 3) left and right wing's span, chord, normal in
body axes, base (2, 3) [m], spheres (K, 4) centre in body axes and radius [m], outline (M, 2) span, chord [m], half the
wings' thickness [m]).  Its image is the tuple of `empty_image`.
"""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def empty_image(spheres, outline):
    """Room for discs (K, 3) u, v, radius [px]; wings (2, M, 2) [px]; edges (2, M, 3); sweep (2, 2) [px]; boxes (3, 4).

    An edge is its way along u and v [px] and one over its squared length; a sweep, by how much half the thickness moves
    a wing; a box, least and largest u, least and largest v [px] of body, left and right wing.
    """
    count = outline.shape[0]
    discs, boxes = np.empty((spheres.shape[0], 3)), np.empty((3, 4))
    return discs, np.empty((2, count, 2)), np.empty((2, count, 3)), np.empty((2, 2)), boxes


@numba.njit(cache=True)
def draw_fly(P, fly, image):
    """Write the image of a fly by a camera P (3, 4); whether it is before the camera."""
    position, R, A, base, spheres, outline, half = fly
    discs, wings, edges, sweep, boxes = image
    before = _draw_body(P, position, R, spheres, discs)
    _box(discs, discs[:, 2], boxes[0])
    for side in range(2):
        drawn = _draw_wing(P, position, R, A[side], base[side], outline, half, wings[side], sweep[side])
        before = before and drawn
        _edges_of(wings[side], edges[side])
        swept = abs(sweep[side, 0]) + abs(sweep[side, 1])
        _box(wings[side], np.full(outline.shape[0], swept), boxes[side + 1])
    return before


@numba.njit(cache=True)
def _draw_body(P, position, R, spheres, discs):
    """Spheres as discs, as large as the pixels to the metre at the body's centre have them."""
    w0 = P[2, 0] * position[0] + P[2, 1] * position[1] + P[2, 2] * position[2] + P[2, 3]
    scale = _pixels_to_the_metre(P, position, w0)
    for k in range(spheres.shape[0]):
        x, y, z = spheres[k, 0], spheres[k, 1], spheres[k, 2]
        X = position[0] + R[0, 0] * x + R[0, 1] * y + R[0, 2] * z
        Y = position[1] + R[1, 0] * x + R[1, 1] * y + R[1, 2] * z
        Z = position[2] + R[2, 0] * x + R[2, 1] * y + R[2, 2] * z
        w = P[2, 0] * X + P[2, 1] * Y + P[2, 2] * Z + P[2, 3]
        discs[k, 0] = (P[0, 0] * X + P[0, 1] * Y + P[0, 2] * Z + P[0, 3]) / w
        discs[k, 1] = (P[1, 0] * X + P[1, 1] * Y + P[1, 2] * Z + P[1, 3]) / w
        discs[k, 2] = spheres[k, 3] * scale * w0 / w
    return w0 > 0.0


@numba.njit(cache=True)
def _pixels_to_the_metre(P, position, w0):
    """Root of the area that the image gives a disc, of radius 1 m, that faces the camera, over pi."""
    a, b = np.empty((2, 3)), np.empty(2)
    for i in range(2):
        b[i] = (P[i, 0] * position[0] + P[i, 1] * position[1] + P[i, 2] * position[2] + P[i, 3]) / w0
        for j in range(3):
            a[i, j] = (P[i, j] - b[i] * P[2, j]) / w0
    c0 = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    c1 = a[0, 2] * a[1, 0] - a[0, 0] * a[1, 2]
    c2 = a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    return (c0 * c0 + c1 * c1 + c2 * c2) ** 0.25


@numba.njit(cache=True)
def _draw_wing(P, position, R, A, base, outline, half, corners, sweep):
    """Corners (M, 2) of a wing [px], and by how much half its thickness moves them (2,) [px]."""
    before = True
    for m in range(outline.shape[0]):
        y0 = base[0] + A[0, 0] * outline[m, 0] + A[0, 1] * outline[m, 1]
        y1 = base[1] + A[1, 0] * outline[m, 0] + A[1, 1] * outline[m, 1]
        y2 = base[2] + A[2, 0] * outline[m, 0] + A[2, 1] * outline[m, 1]
        X = position[0] + R[0, 0] * y0 + R[0, 1] * y1 + R[0, 2] * y2
        Y = position[1] + R[1, 0] * y0 + R[1, 1] * y1 + R[1, 2] * y2
        Z = position[2] + R[2, 0] * y0 + R[2, 1] * y1 + R[2, 2] * y2
        w = P[2, 0] * X + P[2, 1] * Y + P[2, 2] * Z + P[2, 3]
        before = before and w > 0.0
        u = (P[0, 0] * X + P[0, 1] * Y + P[0, 2] * Z + P[0, 3]) / w
        v = (P[1, 0] * X + P[1, 1] * Y + P[1, 2] * Z + P[1, 3]) / w
        corners[m, 0], corners[m, 1] = u, v
        if m == outline.shape[0] // 4:
            for i in range(2):
                q = u if i == 0 else v
                total = 0.0
                for j in range(3):
                    n = R[j, 0] * A[0, 2] + R[j, 1] * A[1, 2] + R[j, 2] * A[2, 2]
                    total += (P[i, j] - q * P[2, j]) / w * n
                sweep[i] = half * total
    return before


@numba.njit(cache=True)
def _edges_of(corners, edges):
    """Edges (M, 3): along u and v [px], and one over their squared length."""
    count = corners.shape[0]
    for m in range(count):
        n = m + 1 if m + 1 < count else 0
        along_u, along_v = corners[n, 0] - corners[m, 0], corners[n, 1] - corners[m, 1]
        edges[m, 0], edges[m, 1], edges[m, 2] = along_u, along_v, 1.0 / (along_u * along_u + along_v * along_v + 1e-12)


@numba.njit(cache=True)
def _box(points, radius, box):
    """Least and largest u and v of points, radius [px] around each."""
    low_u, high_u, low_v, high_v = 1e30, -1e30, 1e30, -1e30
    for m in range(points.shape[0]):
        r = radius[m]
        low_u, high_u = min(low_u, points[m, 0] - r), max(high_u, points[m, 0] + r)
        low_v, high_v = min(low_v, points[m, 1] - r), max(high_v, points[m, 1] + r)
    box[0], box[1], box[2], box[3] = low_u, high_u, low_v, high_v


@numba.njit(cache=True)
def look_at(boxes, band, corner, extent, size, stride, look):
    """First and last column and row, counted from a crop's corner: the crop and what of the fly is on the image."""
    for axis in range(2):
        low = min(boxes[0, 2 * axis], boxes[1, 2 * axis], boxes[2, 2 * axis]) - band - corner[axis]
        high = max(boxes[0, 2 * axis + 1], boxes[1, 2 * axis + 1], boxes[2, 2 * axis + 1]) + band - corner[axis]
        low, high = max(low, -corner[axis]), min(high, size[axis] - 1.0 - corner[axis])
        look[2 * axis] = -int(max(-low, 0.0) / stride) * stride
        look[2 * axis + 1] = max(int(high) + 1, extent[axis])

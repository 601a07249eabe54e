"""Soft silhouettes of a posed fly against soft silhouettes of images: cost, gradient and normal matrix in one sweep.

The fly in an image is a union of discs (its body, spheres in it) and of two polygons (its wings). With d the
signed distance to the union's border, > 0 outside, and D that of the image's silhouette, the residual of a pixel is
c(d / s) - c(D / s), c(x) = 1 / (1 + exp(x)).
"""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.vision.kernels.fly_image import draw_fly, empty_image, look_at
from flycontrol.vision.kernels.part_distance import disc_distance, distance_to_box, wing_distance

#: Beyond so many softnesses from the border a pixel counts as wholly inside or outside: c(4) = 0.018
BAND = 4.0
#: Columns: position 3, body turn 3, per wing turn 3, per wing base 3; factors of body length, radius, span, chord.
COLUMNS = 22


@numba.njit(cache=True)
def compare(
    cameras,
    targets,
    corner,
    extent,
    size,
    windows,
    softness,
    stride,
    lenience,
    position,
    R,
    A,
    base,
    spheres,
    outline,
    half,
    H,
    g,
    tally,
):
    """Sum of squared residuals over all pixels; H = J^T J and g = J^T r are added to; tally per view.

    Parameters
    ----------
    cameras : (C, 3, 4) from [m] to [px]
    targets : (C, V, U) c(D / s) of the silhouettes, cropped
    corner : (C, 2) u, v of the crops' first pixel
    extent : (C, 2) columns and rows of each crop
    size : (C, 2) columns and rows of each image: around its crop there is no silhouette, around it nothing is known
    windows : (C, 4) least and largest u, least and largest v of the pixels that count, as others do not; may be inf
    softness : s [px]
    stride : every how many pixels, along rows and along columns, are looked at; each stands for stride^2
    lenience : weight of pixels that the silhouette covers more than the fly does: legs, for one
    position : (3,) [m];  R : (3, 3) body to world
    A : (2, 3, 3) left and right wing's span, chord, normal in body axes;  base : (2, 3) [m]
    spheres : (K, 4) centre in body axes, radius [m];  outline : (M, 2) span, chord [m];  half : thickness / 2 [m]
    H : (22, 22), g : (22,) written; not if H is empty
    tally : (C, 3) written: pixels of the fly, of the silhouette, and of both

    Returns
    -------
    the sum, or inf if the fly is behind a camera
    """
    total, wanted = 0.0, H.shape[0] > 0
    band, area = BAND * softness, float(stride * stride)
    fly, image = (position, R, A, base, spheres, outline, half), empty_image(spheres, outline)
    discs, wings, edges, sweep, boxes = image
    near_body, near_wing, look = np.empty(4), np.empty((2, 4)), np.empty(4, np.int64)
    row, nonzero, work = np.empty(COLUMNS), np.empty(COLUMNS, np.int64), np.empty((5, 3))
    for c in range(cameras.shape[0]):
        P = cameras[c]
        if not draw_fly(P, fly, image):
            return np.inf
        look_at(boxes, band, corner[c], extent[c], size[c], stride, look)
        _within(windows[c], corner[c], stride, look)
        counted = tally[c]
        for i in range(look[2], look[3], stride):
            framed = 0 <= i < extent[c, 1]
            j = look[0]
            while j < look[1]:
                u, v = corner[c, 0] + j, corner[c, 1] + i
                # the nearest part: one that is farther than the band need not be known exactly
                d, part = distance_to_box(boxes, 0, u, v), 0
                if d <= band:
                    d = disc_distance(discs, u, v, near_body)
                for side in range(2):
                    if d < -band:
                        break
                    away = distance_to_box(boxes, side + 1, u, v)
                    if away <= band and away < max(d, 1e-9):
                        away = wing_distance(wings, edges, sweep, side, u, v, near_wing)
                    if away < d:
                        d, part = away, side + 1
                sure = d > band or d < -band
                # no nearer than d less the band, so many pixels on are as sure as this one
                stop = j + (max(int((abs(d) - band) / stride), 0) * stride if sure else 0) + stride
                cover = (0.0 if d > 0 else 1.0) if sure else 1.0 / (1.0 + np.exp(d / softness))
                target, residual, pull = 0.0, 0.0, 0.0
                while j < min(stop, look[1]):
                    target = targets[c, i, j] if framed and 0 <= j < extent[c, 0] else 0.0
                    residual = cover - target
                    pull = area * (lenience if residual < 0.0 else 1.0)
                    total += pull * residual * residual
                    _count(counted, area, d <= 0.0, target > 0.5)
                    j += stride
                if sure or not wanted:
                    continue
                slope = -cover * (1.0 - cover) / softness
                near = near_body if part == 0 else near_wing[part - 1]
                _row_of(P, position, R, A, base, outline, spheres, part, near, work, row)
                if part == 0:
                    row[19] += -discs[int(near[0]), 2]
                _add(row, nonzero, pull, slope, residual, H, g)
    if wanted:
        _mirror(H)
    return total


@numba.njit(cache=True)
def _count(tally, area, in_fly, in_silhouette):
    """Add pixels to those of the fly, of the silhouette, and of both."""
    if in_fly:
        tally[0] += area
    if in_silhouette:
        tally[1] += area
        if in_fly:
            tally[2] += area


@numba.njit(cache=True)
def _add(row, nonzero, pull, slope, residual, H, g):
    """Add what a residual of weight pull, that changes by slope times the row, says to J^T J (below) and to J^T r."""
    many = 0
    for a in range(COLUMNS):
        if row[a] != 0.0:
            nonzero[many] = a
            many += 1
    for p in range(many):
        a = nonzero[p]
        weight = pull * slope * row[a]
        g[a] += weight * residual
        weight *= slope
        for q in range(p + 1):
            H[a, nonzero[q]] += weight * row[nonzero[q]]


@numba.njit(cache=True)
def _mirror(H):
    """Copy what is below the diagonal to above it."""
    for a in range(COLUMNS):
        for b in range(a):
            H[b, a] = H[a, b]


@numba.njit(cache=True)
def _within(window, corner, stride, look):
    """What of the columns and rows to be looked at is in a window, with the same pixels left out by the stride."""
    for axis in range(2):
        first, last = look[2 * axis], look[2 * axis + 1]
        skipped = max(np.floor((window[2 * axis] - corner[axis] - first) / stride), 0.0)
        look[2 * axis] = first + int(min(skipped, max(last - first, 0.0))) * stride
        look[2 * axis + 1] = int(min(max(np.floor(window[2 * axis + 1] - corner[axis]) + 1.0, first), last))


@numba.njit(cache=True)
def _row_of(P, position, R, A, base, outline, spheres, part, near, work, row):
    """d (distance) / d (columns) of one pixel; near as the distances left it."""
    row[:] = 0.0
    aw, y, X, h, k_ = work[0], work[1], work[2], work[3], work[4]
    if part == 0:
        y[:] = spheres[int(near[0]), :3]
        gu, gv = near[1], near[2]
    else:
        side, m = part - 1, int(near[0])
        n = m + 1 if m + 1 < outline.shape[0] else 0
        s = outline[m, 0] + near[1] * (outline[n, 0] - outline[m, 0])
        c = outline[m, 1] + near[1] * (outline[n, 1] - outline[m, 1])
        for i in range(3):
            aw[i] = A[side, i, 0] * s + A[side, i, 1] * c
            y[i] = base[side, i] + aw[i]
        gu, gv = near[2], near[3]
    for i in range(3):
        X[i] = position[i] + R[i, 0] * y[0] + R[i, 1] * y[1] + R[i, 2] * y[2]
    w = P[2, 0] * X[0] + P[2, 1] * X[1] + P[2, 2] * X[2] + P[2, 3]
    u = (P[0, 0] * X[0] + P[0, 1] * X[1] + P[0, 2] * X[2] + P[0, 3]) / w
    v = (P[1, 0] * X[0] + P[1, 1] * X[1] + P[1, 2] * X[2] + P[1, 3]) / w
    for j in range(3):
        h[j] = -(gu * (P[0, j] - u * P[2, j]) + gv * (P[1, j] - v * P[2, j])) / w
    for j in range(3):
        k_[j] = R[0, j] * h[0] + R[1, j] * h[1] + R[2, j] * h[2]
    row[0], row[1], row[2] = h[0], h[1], h[2]
    row[3], row[4], row[5] = y[1] * k_[2] - y[2] * k_[1], y[2] * k_[0] - y[0] * k_[2], y[0] * k_[1] - y[1] * k_[0]
    if part == 0:
        row[18] = k_[0] * y[0]
        row[19] = k_[1] * y[1] + k_[2] * y[2]
    else:
        t = 6 + 3 * (part - 1)
        row[t] = aw[1] * k_[2] - aw[2] * k_[1]
        row[t + 1] = aw[2] * k_[0] - aw[0] * k_[2]
        row[t + 2] = aw[0] * k_[1] - aw[1] * k_[0]
        b = 12 + 3 * (part - 1)
        row[b], row[b + 1], row[b + 2] = k_[0], k_[1], k_[2]
        for i in range(3):
            row[20] += k_[i] * A[part - 1, i, 0] * s
            row[21] += k_[i] * A[part - 1, i, 1] * c

"""Soft silhouettes of a posed fly against soft silhouettes of images: cost, gradient and normal matrix in one sweep.

The fly in an image is a union of discs (its body, spheres in it) and of two polygons (its wings). With d the
signed distance to the union's border, > 0 outside, and D that of the image's silhouette, the residual of a pixel is
c(d / s) - c(D / s), c(x) = 1 / (1 + exp(x)).
"""

from __future__ import annotations

import numba
import numpy as np

#: Beyond so many softnesses from the border a pixel counts as wholly inside or outside: c(4) = 0.018
BAND = 4.0
#: Columns: position 3, body turn 3, per wing turn 3, per wing base 3; factors of body length, radius, span, chord.
COLUMNS = 22


@numba.njit(cache=True)
def _sphere_images(P, position, R, spheres, discs):
    """Discs (K, 3): u, v, radius [px], and the number of pixels to the metre at the body's centre."""
    w0 = P[2, 0] * position[0] + P[2, 1] * position[1] + P[2, 2] * position[2] + P[2, 3]
    a, b = np.empty((2, 3)), np.empty(2)
    for i in range(2):
        b[i] = (P[i, 0] * position[0] + P[i, 1] * position[1] + P[i, 2] * position[2] + P[i, 3]) / w0
        for j in range(3):
            a[i, j] = (P[i, j] - b[i] * P[2, j]) / w0
    c0 = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    c1 = a[0, 2] * a[1, 0] - a[0, 0] * a[1, 2]
    c2 = a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    scale = (c0 * c0 + c1 * c1 + c2 * c2) ** 0.25
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
def _wing_image(P, position, R, A, base, outline, half, corners, sweep):
    """Corners (M, 2) of a wing [px], and by how much half its thickness moves them (2,) [px]."""
    ok = True
    for m in range(outline.shape[0]):
        y0 = base[0] + A[0, 0] * outline[m, 0] + A[0, 1] * outline[m, 1]
        y1 = base[1] + A[1, 0] * outline[m, 0] + A[1, 1] * outline[m, 1]
        y2 = base[2] + A[2, 0] * outline[m, 0] + A[2, 1] * outline[m, 1]
        X = position[0] + R[0, 0] * y0 + R[0, 1] * y1 + R[0, 2] * y2
        Y = position[1] + R[1, 0] * y0 + R[1, 1] * y1 + R[1, 2] * y2
        Z = position[2] + R[2, 0] * y0 + R[2, 1] * y1 + R[2, 2] * y2
        w = P[2, 0] * X + P[2, 1] * Y + P[2, 2] * Z + P[2, 3]
        ok = ok and w > 0.0
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
    return ok


@numba.njit(cache=True)
def _disc_distance(discs, u, v, near):
    """Signed distance to the union of discs; near: sphere, and the outward direction there."""
    best, which = 1e30, 0
    for k in range(discs.shape[0]):
        du, dv, wanted = u - discs[k, 0], v - discs[k, 1], best + discs[k, 2]
        if wanted > 0.0 and du * du + dv * dv < wanted * wanted:  # a root only where it may be the least
            best, which = np.sqrt(du * du + dv * dv) - discs[k, 2], k
    du, dv = u - discs[which, 0], v - discs[which, 1]
    r = np.sqrt(du * du + dv * dv) + 1e-12
    near[0], near[1], near[2] = which, du / r, dv / r
    return best


@numba.njit(cache=True)
def _edges_of(corners, edges):
    """Edges (M, 3): along u and v [px], and one over their squared length."""
    count = corners.shape[0]
    for m in range(count):
        n = m + 1 if m + 1 < count else 0
        along_u, along_v = corners[n, 0] - corners[m, 0], corners[n, 1] - corners[m, 1]
        edges[m, 0], edges[m, 1], edges[m, 2] = along_u, along_v, 1.0 / (along_u * along_u + along_v * along_v + 1e-12)


@numba.njit(cache=True)
def _wing_distance(wings, edges, sweep, side, u, v, near):
    """Signed distance to one of two polygons swept by +-sweep; near: edge, fraction along it, outward direction."""
    count = wings.shape[1]
    best, inside = 1e30, False
    edge, part = 0, 0.0
    for m in range(count):
        av, along_u, along_v = wings[side, m, 1], edges[side, m, 0], edges[side, m, 1]
        pu, pv = u - wings[side, m, 0], v - av
        t = min(max((pu * along_u + pv * along_v) * edges[side, m, 2], 0.0), 1.0)
        eu, ev = pu - t * along_u, pv - t * along_v
        d2 = eu * eu + ev * ev
        if d2 < best:
            best, edge, part = d2, m, t
        if (av > v) != (av + along_v > v) and pu < pv * along_u / along_v:
            inside = not inside
    qu = wings[side, edge, 0] + part * edges[side, edge, 0]
    qv = wings[side, edge, 1] + part * edges[side, edge, 1]
    distance = np.sqrt(best)
    sign = -1.0 if inside else 1.0
    if distance > 1e-6:
        gu, gv = sign * (u - qu) / distance, sign * (v - qv) / distance
    else:
        length = np.sqrt(edges[side, edge, 2])
        gu, gv = edges[side, edge, 1] * length, -edges[side, edge, 0] * length
    near[side, 0], near[side, 1], near[side, 2], near[side, 3] = edge, part, gu, gv
    return sign * distance - abs(sweep[side, 0] * gu + sweep[side, 1] * gv)


@numba.njit(cache=True)
def _row_of(P, position, R, A, base, outline, spheres, part, near, work, row):
    """d (distance) / d (columns) of one pixel; near as the distances left it."""
    row[:] = 0.0
    aw, y, X, h, k_ = work[0], work[1], work[2], work[3], work[4]
    y[:] = 0.0
    if part == 0:
        k = int(near[0])
        y[:] = spheres[k, :3]
        gu, gv = near[1], near[2]
    else:
        side = part - 1
        m = int(near[0])
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


@numba.njit(cache=True)
def _box(points, radius):
    """Least and largest u and v of points, radius [px] around each."""
    low_u, high_u, low_v, high_v = 1e30, -1e30, 1e30, -1e30
    for m in range(points.shape[0]):
        r = radius[m]
        low_u, high_u = min(low_u, points[m, 0] - r), max(high_u, points[m, 0] + r)
        low_v, high_v = min(low_v, points[m, 1] - r), max(high_v, points[m, 1] + r)
    return low_u, high_u, low_v, high_v


@numba.njit(cache=True)
def _outside(box, u, v):
    """Distance from a point to a box, 0 inside."""
    du = max(box[0] - u, u - box[1], 0.0)
    dv = max(box[2] - v, v - box[3], 0.0)
    return np.sqrt(du * du + dv * dv)


@numba.njit(cache=True)
def _looked_at(body, left, right, band, corner, extent, image, stride, look):
    """First and last column and row, counted from a crop's corner: the crop and what of the fly is on the image."""
    for axis in range(2):
        low = min(body[2 * axis], left[2 * axis], right[2 * axis]) - band - corner[axis]
        high = max(body[2 * axis + 1], left[2 * axis + 1], right[2 * axis + 1]) + band - corner[axis]
        low, high = max(low, -corner[axis]), min(high, image[axis] - 1.0 - corner[axis])
        look[2 * axis] = -int(max(-low, 0.0) / stride) * stride
        look[2 * axis + 1] = max(int(high) + 1, extent[axis])


@numba.njit(cache=True)
def _within(window, corner, stride, look):
    """What of the columns and rows to be looked at is in a window, with the same pixels left out by the stride."""
    for axis in range(2):
        first, last = look[2 * axis], look[2 * axis + 1]
        skipped = max(np.floor((window[2 * axis] - corner[axis] - first) / stride), 0.0)
        look[2 * axis] = first + int(min(skipped, max(last - first, 0.0))) * stride
        look[2 * axis + 1] = int(min(max(np.floor(window[2 * axis + 1] - corner[axis]) + 1.0, first), last))


@numba.njit(cache=True)
def compare(
    cameras,
    targets,
    corner,
    extent,
    image,
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
    image : (C, 2) columns and rows of each image: around its crop there is no silhouette, around it nothing is known
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
    total = 0.0
    wanted = H.shape[0] > 0
    near, near_body, row = np.empty(4), np.empty(4), np.empty(COLUMNS)
    near_wing, work = np.empty((2, 4)), np.empty((5, 3))
    discs = np.empty((spheres.shape[0], 3))
    wings, edges, sweep = np.empty((2, outline.shape[0], 2)), np.empty((2, outline.shape[0], 3)), np.empty((2, 2))
    nonzero, look = np.empty(COLUMNS, np.int64), np.empty(4, np.int64)
    band, area = BAND * softness, float(stride * stride)
    for c in range(cameras.shape[0]):
        P = cameras[c]
        ok = _sphere_images(P, position, R, spheres, discs)
        for side in range(2):
            ok = ok and _wing_image(P, position, R, A[side], base[side], outline, half, wings[side], sweep[side])
            _edges_of(wings[side], edges[side])
        if not ok:
            return np.inf
        body_box = _box(discs, discs[:, 2])
        left_box = _box(wings[0], np.full(outline.shape[0], abs(sweep[0, 0]) + abs(sweep[0, 1])))
        right_box = _box(wings[1], np.full(outline.shape[0], abs(sweep[1, 0]) + abs(sweep[1, 1])))
        _looked_at(body_box, left_box, right_box, band, corner[c], extent[c], image[c], stride, look)
        _within(windows[c], corner[c], stride, look)
        for i in range(look[2], look[3], stride):
            v = corner[c, 1] + i
            framed = 0 <= i < extent[c, 1]
            j = look[0]
            while j < look[1]:
                u = corner[c, 0] + j
                # a part that is farther than the band need not be known exactly
                d, part = _outside(body_box, u, v), 0
                if d <= band:
                    d = _disc_distance(discs, u, v, near_body)
                for side in range(2):
                    if d < -band:
                        break
                    away = _outside(left_box if side == 0 else right_box, u, v)
                    if away <= band and away < max(d, 1e-9):
                        away = _wing_distance(wings, edges, sweep, side, u, v, near_wing)
                    if away < d:
                        d, part = away, side + 1
                if d > band or d < -band:
                    stop = min(j + max(int((abs(d) - band) / stride), 0) * stride + stride, look[1])
                    cover = 0.0 if d > 0 else 1.0
                    while j < stop:
                        target = targets[c, i, j] if framed and 0 <= j < extent[c, 0] else 0.0
                        total += area * (cover - target) ** 2 * (lenience if target > cover else 1.0)
                        tally[c, 0] += area * cover
                        if target > 0.5:
                            tally[c, 1] += area
                            tally[c, 2] += area * cover
                        j += stride
                    continue
                cover = 1.0 / (1.0 + np.exp(d / softness))
                target = targets[c, i, j] if framed and 0 <= j < extent[c, 0] else 0.0
                residual = cover - target
                pull = area * (lenience if residual < 0.0 else 1.0)
                total += pull * residual * residual
                if d <= 0.0:
                    tally[c, 0] += area
                if target > 0.5:
                    tally[c, 1] += area
                    if d <= 0.0:
                        tally[c, 2] += area
                j += stride
                if not wanted:
                    continue
                slope = -cover * (1.0 - cover) / softness
                if part == 0:
                    near[:3] = near_body[:3]
                else:
                    near[:] = near_wing[part - 1]
                _row_of(P, position, R, A, base, outline, spheres, part, near, work, row)
                if part == 0:
                    row[19] += -discs[int(near[0]), 2]
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
    if wanted:
        for a in range(COLUMNS):
            for b in range(a):
                H[b, a] = H[a, b]
    return total

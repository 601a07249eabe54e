"""Visual hulls by carving a lattice of voxels, block by block, the blocks that straddle an outline again in eighths.

A grade of a pixel is 2 on the silhouette, 1 within the slack of it, 0 elsewhere. A voxel stays if no view grades the
pixel nearest to its projected centre 0, and at most `lenient` views grade it 1. All pixels under the projections of a
block's voxels lie in the rectangle that holds the projections of its eight corners, and summed-area tables count grades
in it, so that a block is kept or dropped only if each of its voxels would be.
"""

from __future__ import annotations

import numba
import numpy as np

#: Edges of blocks to begin with and of those whose voxels are looked at one by one.
LARGEST, SMALLEST = 32, 4
#: More than all views together can count
_GONE = 1 << 20
#: By which rectangles are widened against rounding [px]
_ROUNDING = 1e-6


@numba.njit(cache=True)
def _mark(p, grades, u0, v0, block, slack):
    """One view's say on the voxels of a block: slack[k] counts its grades 1, and a grade 0 makes it _GONE."""
    p00, p01, p02, p03 = p[0]
    p10, p11, p12, p13 = p[1]
    p20, p21, p22, p23 = p[2]
    right, bottom = grades.shape[1], grades.shape[0]
    k = 0
    for x in range(block[0], block[3]):
        for y in range(block[1], block[4]):
            a = p00 * x + p01 * y + p03
            b = p10 * x + p11 * y + p13
            c = p20 * x + p21 * y + p23
            for z in range(block[2], block[5]):
                w = c + p22 * z
                # half a pixel more, so that cutting off the fraction rounds; the crop starts at u0, v0
                u = (a + p02 * z) / w - u0 + 0.5
                v = (b + p12 * z) / w - v0 + 0.5
                grade = np.uint8(0)
                if w > 0.0 and 0.0 <= u < right and 0.0 <= v < bottom:
                    grade = grades[np.uint64(v), np.uint64(u)]
                if grade < 2:
                    slack[k] = slack[k] + 1 if grade == 1 else _GONE
                k += 1


@numba.njit(cache=True, inline="always")
def _count(table, top, left, bottom, right):
    return table[bottom, right] - table[top, right] - table[bottom, left] + table[top, left]


@numba.njit(cache=True)
def _rectangle(p, x0, y0, z0, x1, y1, z1):
    """Least and largest u and v of a block's corners; (1, 0, ...) where one is not in front of the camera."""
    u0 = v0 = np.inf
    u1 = v1 = -np.inf
    for x in (x0, x1):
        for y in (y0, y1):
            a = p[0, 0] * x + p[0, 1] * y + p[0, 3]
            b = p[1, 0] * x + p[1, 1] * y + p[1, 3]
            c = p[2, 0] * x + p[2, 1] * y + p[2, 3]
            for z in (z0, z1):
                w = c + p[2, 2] * z
                if not w > 0.0:
                    return 1.0, 0.0, 1.0, 0.0
                u, v = (a + p[0, 2] * z) / w, (b + p[1, 2] * z) / w
                u0, u1 = min(u0, u), max(u1, u)
                v0, v1 = min(v0, v), max(v1, v)
    return u0, u1, v0, v1


@numba.njit(cache=True)
def _grade_range(P, tables, corner, c, x0, y0, z0, x1, y1, z1):
    """Lowest and highest grade that a voxel of the block can have in view c."""
    u0, u1, v0, v1 = _rectangle(P[c], x0, y0, z0, x1, y1, z1)
    if u0 > u1:
        return 0, 2
    rows, columns = tables.shape[2] - 1, tables.shape[3] - 1
    left = np.floor(u0 - corner[c, 0] + 0.5 - _ROUNDING)
    right = np.floor(u1 - corner[c, 0] + 0.5 + _ROUNDING) + 1.0
    top = np.floor(v0 - corner[c, 1] + 0.5 - _ROUNDING)
    bottom = np.floor(v1 - corner[c, 1] + 0.5 + _ROUNDING) + 1.0
    inside = left >= 0 and top >= 0 and right <= columns and bottom <= rows
    if right <= 0 or bottom <= 0 or left >= columns or top >= rows:
        return 0, 0
    j0, j1 = int(max(left, 0.0)), int(min(right, np.float64(columns)))
    i0, i1 = int(max(top, 0.0)), int(min(bottom, np.float64(rows)))
    area = (i1 - i0) * (j1 - j0)
    any_slack = _count(tables[c, 0], i0, j0, i1, j1)
    any_mask = _count(tables[c, 1], i0, j0, i1, j1)
    high = 2 if any_mask > 0 else (1 if any_slack > 0 else 0)
    if not inside:
        return 0, high
    return (2 if any_mask == area else (1 if any_slack == area else 0)), high


@numba.njit(cache=True)
def _verdict(P, tables, corner, lenient, x0, y0, z0, x1, y1, z1):
    """-1: no voxel of the block stays, 1: all stay, 0: it depends."""
    weak = unsure = 0
    sure = True
    for c in range(P.shape[0]):
        low, high = _grade_range(P, tables, corner, c, x0, y0, z0, x1, y1, z1)
        if high == 0:
            return -1
        weak += high == 1
        unsure += low < 2
        sure = sure and low > 0
    if weak > lenient:
        return -1
    return 1 if sure and unsure <= lenient else 0


@numba.njit(cache=True)
def _room(found, n, more):
    """Space for so many more rows."""
    if n + more <= found.shape[0]:
        return found
    larger = np.empty((2 * (n + more), 3), np.int32)
    larger[:n] = found[:n]
    return larger


@numba.njit(cache=True)
def coarse_to_fine(P, grades, tables, corner, lenient, low, high):
    """Voxels that stay, (N, 3) int32.

    Parameters
    ----------
    P : (C, 3, 4) from lattice indices (x, y, z, 1) to homogeneous pixels
    grades : (C, H, W) uint8, cropped images
    tables : (C, 2, H + 1, W + 1) int32, counts of grades >= 1 and >= 2 above and left
    corner : (C, 2) u and v of each crop's first pixel
    lenient : number of views that may grade a voxel 1
    low, high : (3,) lattice box, half open
    """
    found, n = np.empty((4096, 3), np.int32), 0
    stack, block = np.empty((64, 4), np.int64), np.empty(6, np.int64)
    slack = np.empty(LARGEST**3, np.int32)
    for bx in range(low[0], high[0], LARGEST):
        for by in range(low[1], high[1], LARGEST):
            for bz in range(low[2], high[2], LARGEST):
                stack[0] = bx, by, bz, LARGEST
                depth = 1
                while depth > 0:
                    depth -= 1
                    x0, y0, z0, edge = stack[depth, 0], stack[depth, 1], stack[depth, 2], stack[depth, 3]
                    x1, y1, z1 = min(x0 + edge, high[0]), min(y0 + edge, high[1]), min(z0 + edge, high[2])
                    verdict = _verdict(P, tables, corner, lenient, x0, y0, z0, x1 - 1, y1 - 1, z1 - 1)
                    if verdict < 0:
                        continue
                    if verdict == 0 and edge > SMALLEST:
                        half = edge // 2
                        for x in range(x0, x1, half):
                            for y in range(y0, y1, half):
                                for z in range(z0, z1, half):
                                    stack[depth] = x, y, z, half
                                    depth += 1
                        continue
                    found = _room(found, n, (x1 - x0) * (y1 - y0) * (z1 - z0))
                    slack[: (x1 - x0) * (y1 - y0) * (z1 - z0)] = 0
                    if verdict == 0:
                        block[:] = x0, y0, z0, x1, y1, z1
                        for c in range(P.shape[0]):
                            _mark(P[c], grades[c], corner[c, 0], corner[c, 1], block, slack)
                    k = 0
                    for x in range(x0, x1):
                        for y in range(y0, y1):
                            for z in range(z0, z1):
                                found[n, 0], found[n, 1], found[n, 2] = x, y, z
                                n += slack[k] <= lenient
                                k += 1
    return found[:n].copy()


@numba.njit(cache=True)
def summed_areas(grades):
    """(C, 2, H + 1, W + 1) int32 counts of grades >= 1 and >= 2 in all pixels above and left."""
    C, H, W = grades.shape
    tables = np.zeros((C, 2, H + 1, W + 1), np.int32)
    for c in range(C):
        for i in range(H):
            slack = mask = np.int32(0)
            for j in range(W):
                slack += np.int32(grades[c, i, j] >= 1)
                mask += np.int32(grades[c, i, j] >= 2)
                tables[c, 0, i + 1, j + 1] = tables[c, 0, i, j + 1] + slack
                tables[c, 1, i + 1, j + 1] = tables[c, 1, i, j + 1] + mask
    return tables

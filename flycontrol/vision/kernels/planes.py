"""Carving where every view looks along an axis of the lattice: rows of bits, ANDed 64 voxels at a time."""

from __future__ import annotations

import numba
import numpy as np

WORD = 64


@numba.njit(cache=True)
def packed_rows(plane):
    """(n, words) uint64 of a boolean (n, m): bit b of word w is column 64 w + b."""
    n, m = plane.shape
    words = np.zeros((n, (m + WORD - 1) // WORD), np.uint64)
    for i in range(n):
        for k in range(m):
            if plane[i, k]:
                words[i, k // WORD] |= np.uint64(1) << np.uint64(k % WORD)
    return words


@numba.njit(cache=True)
def meet_of_planes(xy, xz, yz, low):
    """Voxels (N, 3) int32 with xy[x, y] and xz[x, z] and yz[y, z], counted from `low` (3,)."""
    along_x, along_y = packed_rows(xz), packed_rows(yz)
    words = along_x.shape[1]
    found, n = np.empty((4096, 3), np.int32), 0
    one, none = np.uint64(1), np.uint64(0)
    for i in range(xy.shape[0]):
        for j in range(xy.shape[1]):
            if not xy[i, j]:
                continue
            if n + words * WORD > found.shape[0]:
                larger = np.empty((2 * found.shape[0] + words * WORD, 3), np.int32)
                larger[:n] = found[:n]
                found = larger
            for w in range(words):
                bits = along_x[i, w] & along_y[j, w]
                k = w * WORD
                while bits != none:
                    if bits & one:
                        found[n, 0], found[n, 1], found[n, 2] = low[0] + i, low[1] + j, low[2] + k
                        n += 1
                    bits >>= one
                    k += 1
    return found[:n].copy()

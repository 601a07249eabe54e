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
        for w in range(words.shape[1]):
            bits = np.uint64(0)
            for b in range(min(WORD, m - w * WORD)):
                bits |= np.uint64(plane[i, w * WORD + b]) << np.uint64(b)
            words[i, w] = bits
    return words


@numba.njit(cache=True, inline="always")
def _bits_set(x):
    """Number of bits set in 64, added in pairs, fours and bytes."""
    x = x - ((x >> np.uint64(1)) & np.uint64(0x5555555555555555))
    x = (x & np.uint64(0x3333333333333333)) + ((x >> np.uint64(2)) & np.uint64(0x3333333333333333))
    x = (x + (x >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return np.int64((x * np.uint64(0x0101010101010101)) >> np.uint64(56))


@numba.njit(cache=True)
def meet_of_planes(xy, xz, yz, low):
    """Voxels (N, 3) int32 with xy[x, y] and xz[x, z] and yz[y, z], counted from `low` (3,)."""
    along_x, along_y = packed_rows(xz), packed_rows(yz)
    words, count = along_x.shape[1], 0
    for i in range(xy.shape[0]):
        for j in range(xy.shape[1]):
            if xy[i, j]:
                for w in range(words):
                    count += _bits_set(along_x[i, w] & along_y[j, w])
    found, n = np.empty((count + 1, 3), np.int32), 0  # one more, to be written to in vain
    one, none = np.uint64(1), np.uint64(0)
    for i in range(xy.shape[0]):
        for j in range(xy.shape[1]):
            if not xy[i, j]:
                continue
            x, y = np.int32(low[0] + i), np.int32(low[1] + j)
            for w in range(words):
                bits = along_x[i, w] & along_y[j, w]
                z = np.int32(low[2] + w * WORD)
                while bits != none:
                    found[n, 0], found[n, 1], found[n, 2] = x, y, z
                    n += np.int64(bits & one)
                    bits >>= one
                    z += np.int32(1)
    return found[:count]

"""The polyhedron of half-spaces n . x + d >= 0: whether it is bounded, and the box around its corners."""

from __future__ import annotations

import numba
import numpy as np

_PARALLEL = 1e-9
_OUTSIDE = 1e-9


@numba.njit(cache=True)
def is_open(planes):
    """Whether some direction leads out of no half-space: if so, one along the meet of two planes does.

    Parameters
    ----------
    planes : (K, 4) n and d, |n| = 1
    """
    K = planes.shape[0]
    met = False
    for a in range(K):
        for b in range(a + 1, K):
            edge = np.cross(planes[a, :3], planes[b, :3])
            length = np.sqrt(np.sum(edge**2))
            if length <= _PARALLEL:
                continue
            met = True
            for sign in (1.0, -1.0):
                inward = True
                for c in range(K):
                    if sign * np.sum(edge * planes[c, :3]) < -_PARALLEL * length:
                        inward = False
                        break
                if inward:
                    return True
    return not met


@numba.njit(cache=True)
def box_of_corners(planes):
    """(2, 3) least and largest coordinates of all points where three planes meet inside the others; inf, -inf if none.

    Parameters
    ----------
    planes : (K, 4) n and d, |n| = 1
    """
    K = planes.shape[0]
    box = np.empty((2, 3))
    box[0], box[1] = np.inf, -np.inf
    for a in range(K):
        for b in range(a + 1, K):
            edge = np.cross(planes[a, :3], planes[b, :3])
            for c in range(b + 1, K):
                n = planes[c, :3]
                det = np.sum(edge * n)
                if abs(det) <= _PARALLEL:
                    continue
                x = -(
                    planes[c, 3] * edge
                    + planes[a, 3] * np.cross(planes[b, :3], n)
                    + planes[b, 3] * np.cross(n, planes[a, :3])
                ) / det  # fmt: skip
                slack = _OUTSIDE * (1.0 + np.max(np.abs(x)))
                inside = True
                for k in range(K):
                    if planes[k, 0] * x[0] + planes[k, 1] * x[1] + planes[k, 2] * x[2] + planes[k, 3] < -slack:
                        inside = False
                        break
                if inside:
                    box[0], box[1] = np.minimum(box[0], x), np.maximum(box[1], x)
    return box

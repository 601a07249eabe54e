"""Signed distances [px] from a pixel to the parts of a fly in an image, > 0 outside, and the nearest points."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def disc_distance(discs, u, v, near):
    """Distance to the union of discs; near: sphere, and the outward direction there."""
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
def wing_distance(wings, edges, sweep, side, u, v, near):
    """Distance to one of two polygons swept by +-sweep; near: edge, fraction along it, outward direction."""
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
def distance_to_box(boxes, part, u, v):
    """Distance from a point to the box of a part, 0 inside."""
    du = max(boxes[part, 0] - u, u - boxes[part, 1], 0.0)
    dv = max(boxes[part, 2] - v, v - boxes[part, 3], 0.0)
    return np.sqrt(du * du + dv * dv)

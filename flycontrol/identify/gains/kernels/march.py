"""One trial of the yaw loop and its derivatives, panel by panel. The mathematics stands in `gains.response`."""

from __future__ import annotations

import numba
import numpy as np

NODES = 14
MOST_PANELS = 2000  #: besides the images of edges; only a search astray meets rates that would need more
#: Sums may be regrouped, so that they run in lanes; infinities keep their meaning (no saturation).
# No fastmath: a caller's copy of a kernel may be optimised otherwise than the kernel alone, and which copy a process
# uses depends on which it loaded first; with exact arithmetic all copies give the same bytes, and no less swiftly.
COMPILED = {"cache": True, "error_model": "numpy"}
KP, KD, KI, DELAY, B, LIMIT, IMPULSE, SHIFT, YAW, RATE, HEADING, GAMMA = range(12)
PARAMETERS = 12


def _lobatto():
    """Chebyshev-Lobatto nodes on [0, 1], integration from 0 and values to series (transposed), barycentric weights."""
    n = NODES - 1
    nodes = 0.5 * (1.0 - np.cos(np.pi * np.arange(NODES) / n))
    chebyshev = np.polynomial.chebyshev
    to_values = chebyshev.chebvander(2.0 * nodes - 1.0, n)
    to_series = np.linalg.inv(to_values)
    integral = np.zeros((NODES, NODES))
    for j in range(NODES):
        anti = chebyshev.chebint(np.eye(NODES)[j], lbnd=-1.0, scl=0.5)
        integral[:, j] = chebyshev.chebval(2.0 * nodes - 1.0, anti)
    weights = (-1.0) ** np.arange(NODES)
    weights[[0, -1]] *= 0.5
    return nodes, np.ascontiguousarray((integral @ to_series).T), np.ascontiguousarray(to_series.T), weights


RULE = _lobatto()


@numba.njit(**COMPILED)
def panel_edges(start, end, delay, majors, minors, longest):
    """Edges of panels: the start and the majors with all their images under the delay, the minors as they are."""
    images = int((end - start) / delay) + 2
    found = np.empty((len(majors) + 1) * images + len(minors) + 2)
    count = 0
    for k in range(-1, len(majors)):
        t = start if k < 0 else majors[k]
        if t < start:
            t += np.ceil((start - t) / delay) * delay
        for _ in range(images):  # a search astray asks for knots so far off that adding a delay does not move them
            if t >= end:
                break
            if t >= start:
                found[count] = t
                count += 1
            t += delay
    for t in minors:
        if start < t < end:
            found[count] = t
            count += 1
    found[count] = end
    edges = np.sort(found[: count + 1])
    tolerance = 1e-11 * (end - start)
    parts = 0
    last = edges[0]
    for t in edges[1:]:
        if t - last > tolerance:
            parts += int(np.ceil((t - last) / longest - 1e-9))
            last = t
    divided = np.empty(parts + 1)
    divided[0] = edges[0]
    i, last = 0, edges[0]
    for t in edges[1:]:
        if t - last > tolerance:
            pieces = int(np.ceil((t - last) / longest - 1e-9))
            for piece in range(pieces):
                i += 1
                divided[i] = last + (piece + 1) * (t - last) / pieces
            last = t
    divided[parts] = end
    return divided


@numba.njit(**COMPILED)
def _series(values, to_series, series):
    """Chebyshev coefficients of each row of values."""
    for c in range(values.shape[0]):
        for i in range(NODES):
            series[c, i] = 0.0
        for j in range(NODES):
            value = values[c, j]
            for i in range(NODES):
                series[c, i] += value * to_series[j, i]


@numba.njit(**COMPILED)
def _past(p, active, ago, w, i):
    """Node i of the delayed signals before the start: uniform turning, psi = yaw + rate (t - start)."""
    m = 1 + len(active)
    kp, kd, ki = p[KP], p[KD], p[KI]
    w[m, i] = p[YAW] + p[RATE] * ago
    w[m + 1, i] = p[RATE]
    w[m + 2, i] = 0.0
    w[m + 3, i] = (p[YAW] + 0.5 * p[RATE] * ago) * ago
    w[0, i] = kp * w[m, i] + kd * w[m + 1, i] + ki * w[m + 3, i]
    for c in range(1, m):
        w[c, i] = 0.0
        if active[c - 1] == YAW:
            w[c, i] = kp + ki * ago
        elif active[c - 1] == RATE:
            w[c, i] = kp * ago + kd + 0.5 * ki * ago * ago


@numba.njit(**COMPILED)
def _interpolated(z, x, nodes, weights, w, i):
    """Node i of the delayed signals from an earlier panel's values at its nodes, barycentric at x in [0, 1]."""
    rows = z.shape[0]
    for c in range(rows):
        w[c, i] = 0.0
    total = 0.0
    for j in range(NODES):
        d = x - nodes[j]
        if abs(d) < 1e-13:
            for c in range(rows):
                w[c, i] = z[c, j]
            return
        share = weights[j] / d
        total += share
        for c in range(rows):
            w[c, i] += share * z[c, j]
    for c in range(rows):
        w[c, i] /= total


@numba.njit(**COMPILED)
def _delayed(p, active, edges, k, source, z, rule, w):
    """Fed-back signals one delay ago at the nodes of panel k; the index of the earliest panel that they come from."""
    nodes, weights = rule[0], rule[3]
    start, t0, h, delay = edges[0], edges[k], edges[k + 1] - edges[k], p[DELAY]
    first = t0 - delay
    if first + 0.5 * h < start:
        for i in range(NODES):
            _past(p, active, first + nodes[i] * h - start, w, i)
        return source
    while source + 1 < k and edges[source + 1] <= first + 1e-9 * h:
        source += 1
    length = edges[source + 1] - edges[source]
    if abs(edges[source] - first) < 1e-10 * delay and abs(length - h) < 1e-10 * delay:
        w[:, :] = z[source]
        return source
    s = source
    for i in range(NODES):
        t = first + nodes[i] * h
        while s + 1 < k and edges[s + 1] < t - 1e-9 * h:
            s += 1
        _interpolated(z[s], (t - edges[s]) / (edges[s + 1] - edges[s]), nodes, weights, w, i)
    return source


@numba.njit(**COMPILED)
def _fly(p, active, w, F):
    """N_fly / I at the nodes from the fed-back signals one delay ago, and its derivatives; tanh saturates it."""
    m = 1 + len(active)
    kp, kd, ki, limit = p[KP], p[KD], p[KI], p[LIMIT]
    for i in range(NODES):
        F[0, i], slope, by_limit = -w[0, i], 1.0, 0.0
        if limit < np.inf:
            bent = np.tanh(w[0, i] / limit)
            F[0, i], slope = -limit * bent, 1.0 - bent * bent
            by_limit = -(bent - w[0, i] / limit * slope)
        for c in range(1, m):
            which, direct = active[c - 1], w[c, i]
            if which == KP:
                direct += w[m, i]
            elif which == KD:
                direct += w[m + 1, i]
            elif which == KI:
                direct += w[m + 3, i]
            elif which == DELAY:
                direct -= kp * w[m + 1, i] + kd * w[m + 2, i] + ki * w[m, i]
            F[c, i] = -slope * direct
            if which == LIMIT:
                F[c, i] += by_limit


@numba.njit(**COMPILED)
def _push(p, active, drive, knots, t0, h, nodes, F, R):
    """R: the fly's torque F and the external one at the nodes of a panel that no knot cuts, with derivatives."""
    levels, slopes = drive[1], drive[2]
    piece = -1
    for q in range(len(knots)):
        if knots[q] <= t0 + 0.5 * h:
            piece = q
    for c in range(F.shape[0]):
        R[c] = F[c]
    if piece < 0:
        return
    for i in range(NODES):
        unit = levels[piece] + slopes[piece] * (t0 + nodes[i] * h - knots[piece])
        R[0, i] += p[IMPULSE] * unit
        for c in range(len(active)):
            if active[c] == IMPULSE:
                R[c + 1, i] += unit
            elif active[c] == SHIFT:
                R[c + 1, i] -= p[IMPULSE] * slopes[piece]


@numba.njit(**COMPILED)
def _kick(p, active, drive, knots, t0, tolerance, rates):
    """Derivatives with respect to the shift jump where the drive does: by minus the jump of psi''."""
    levels, slopes = drive[1], drive[2]
    for c in range(len(active)):
        if active[c] != SHIFT:
            continue
        for q in range(len(knots)):
            if abs(knots[q] - t0) < tolerance:
                before = levels[q - 1] + slopes[q - 1] * (knots[q] - knots[q - 1]) if q else 0.0
                rates[c + 1] -= p[IMPULSE] * (levels[q] - before)


@numba.njit(**COMPILED)
def _integrated(start, h, integral, rates, values):
    """values: start plus the integral of rates from the panel's beginning to each node."""
    for i in range(NODES):
        values[i] = start
    for j in range(NODES):
        rate = h * rates[j]
        for i in range(NODES):
            values[i] += rate * integral[j, i]


@numba.njit(**COMPILED)
def march(p, active, start, end, majors, minors, drive, wants_fly, rule):
    """Panels of psi and its derivatives, and if wanted of N_fly / I: edges and Chebyshev series.

    p (12,) as ordered above, active (m,) the parameters with derivatives, drive = (knots, levels, slopes) of the
    external acceleration for a unit impulse: majors are knots whose images under the delay are kinks that matter.
    Series have the shape (panels, 1 + m, NODES); the second array is empty unless wanted.
    """
    nodes, integral, to_series = rule[0], rule[1], rule[2]
    knots = drive[0] + p[SHIFT]
    kp, kd, ki, b = p[KP], p[KD], p[KI], p[B]
    quickest = abs(b) + abs(kd) + np.sqrt(abs(kp)) + abs(ki) ** (1.0 / 3.0) + 1e-9
    longest = max(min(3.0 / quickest, end - start), (end - start) / MOST_PANELS)
    edges = panel_edges(start, end, p[DELAY], majors + p[SHIFT], minors + p[SHIFT], longest)
    n, m = len(edges) - 1, 1 + len(active)
    yaw, fly = np.empty((n, m, NODES)), np.empty((n if wants_fly else 0, m, NODES))
    z, w = np.empty((n, m + 4, NODES)), np.empty((m + 4, NODES))  # by column, then psi, psi', psi'', integral of psi
    F, R = np.empty((m, NODES)), np.empty((m, NODES))
    PSI, OM, ZT = np.empty((m, NODES)), np.zeros((m, NODES)), np.zeros((m, NODES))
    psi, om, zt = np.zeros(m), np.zeros(m), np.zeros(m)
    psi[0], om[0] = p[YAW], p[RATE]
    by_b = -1
    for c in range(1, m):
        if active[c - 1] == YAW:
            psi[c] = 1.0
        elif active[c - 1] == RATE:
            om[c] = 1.0
        elif active[c - 1] == B:
            by_b = c
    fading = np.empty(NODES)
    source = 0
    for k in range(n):
        t0, h = edges[k], edges[k + 1] - edges[k]
        source = _delayed(p, active, edges, k, source, z, rule, w)
        _fly(p, active, w, F)
        if wants_fly:
            _series(F, to_series, fly[k])
        _push(p, active, drive, knots, t0, h, nodes, F, R)
        _kick(p, active, drive, knots, t0, 1e-9 * h, om)
        for i in range(NODES):
            fading[i] = np.exp(-b * h * nodes[i])
        for c in range(m):
            if c == by_b:
                for i in range(NODES):
                    R[c, i] -= OM[0, i]
            for i in range(NODES):
                w[c, i] = R[c, i] / fading[i]
            _integrated(om[c], h, integral, w[c], OM[c])
            for i in range(NODES):
                OM[c, i] *= fading[i]
            _integrated(psi[c], h, integral, OM[c], PSI[c])
            if ki != 0.0 or (c > 0 and active[c - 1] == KI) or c == 0:
                _integrated(zt[c], h, integral, PSI[c], ZT[c])
            for i in range(NODES):
                z[k, c, i] = kp * PSI[c, i] + kd * OM[c, i] + ki * ZT[c, i]
            psi[c], om[c], zt[c] = PSI[c, NODES - 1], OM[c, NODES - 1], ZT[c, NODES - 1]
        z[k, m], z[k, m + 1], z[k, m + 3] = PSI[0], OM[0], ZT[0]
        z[k, m + 2] = R[0] - b * OM[0]
        _series(PSI, to_series, yaw[k])
    return edges, yaw, fly


@numba.njit(**COMPILED)
def sampled(edges, series, times, out):
    """out (columns, k): the series at non-decreasing times, continuous to the right."""
    T = np.empty(NODES)
    panel, last = 0, len(edges) - 2
    columns = series.shape[1]
    for i in range(len(times)):
        while panel < last and edges[panel + 1] <= times[i]:
            panel += 1
        z = 2.0 * (times[i] - edges[panel]) / (edges[panel + 1] - edges[panel]) - 1.0
        T[0], T[1] = 1.0, z
        for k in range(2, NODES):
            T[k] = 2.0 * z * T[k - 1] - T[k - 2]
        for c in range(columns):
            total = 0.0
            for k in range(NODES):
                total += T[k] * series[panel, c, k]
            out[c, i] = total

"""March of a time response over collocation panels. The mathematics stands in `flycontrol.delay.response`."""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.delay.kernels.collocation import (
    SUMS,
    assign,
    chebyshev_from,
    clenshaw,
    factor,
    legendre,
    solve,
    transformed,
)

_LANES = 64


@numba.njit(cache=True)
def rate_scale(A, B2, C2):
    """Infinity norm of |A| + |B2| |C2| after Osborne's diagonal balancing [1/s]: how fast anything here can move."""
    n = A.shape[0]
    M = np.abs(A)
    for a in range(n):
        for c in range(C2.shape[0]):
            for b in range(n):
                M[a, b] += abs(B2[a, c]) * abs(C2[c, b])
    for _ in range(20):
        moved = False
        for i in range(n):
            row, column = 0.0, 0.0
            for j in range(n):
                if j != i:
                    row += M[i, j]
                    column += M[j, i]
            if row > 0.0 and column > 0.0:
                factor = np.sqrt(column / row)
                moved |= abs(factor - 1.0) > 1e-2
                for j in range(n):
                    M[i, j] *= factor
                    M[j, i] /= factor
        if not moved:
            break
    largest = 0.0
    for i in range(n):
        row = 0.0
        for j in range(n):
            row += M[i, j]
        largest = max(largest, row)
    return largest


@numba.njit(cache=True)
def _merged(times, tolerance):
    """Sorted times, those closer than the tolerance merged into one."""
    times = np.sort(times)
    kept = np.empty_like(times)
    count = 0
    for t in times:
        if count == 0 or t - kept[count - 1] > tolerance:
            kept[count] = t
            count += 1
    return kept[:count].copy()


@numba.njit(cache=True)
def _images_of_one_delay(edges, delay, end, tolerance):
    """Edges and their images under all multiples of one delay inside [0, end]."""
    found = np.empty(1 + len(edges) * (3 + int((end - min(0.0, edges.min())) / delay)))
    count = 0
    for edge in edges:
        k = 0
        t = edge
        while t < end - tolerance:
            if t >= 0.0:
                found[count] = t
                count += 1
            k += 1
            t = edge + k * delay
    found[count] = end
    return _merged(found[: count + 1], tolerance)


@numba.njit(cache=True)
def breakpoints(edges, tau, end, order):
    """Edges and their images under sums of up to `order` delays (all sums for a single delay) inside [0, end].

    Edges in the past are kinks of the history: only their images count.
    """
    tolerance = 1e-12 * end
    if len(tau) == 1:
        return _images_of_one_delay(edges, tau[0], end, tolerance)
    kept = edges[(edges >= 0.0) & (edges < end - tolerance)]
    newest = edges
    for _ in range(order if len(tau) else 0):
        images = np.empty(len(newest) * len(tau))
        count = 0
        for t in newest:
            for delay in tau:
                if t + delay < end - tolerance:
                    images[count] = t + delay
                    count += 1
        if count == 0:
            break
        newest = _merged(images[:count], tolerance)
        kept = np.concatenate((kept, newest))
    return _merged(np.append(kept, end), tolerance)


@numba.njit(cache=True)
def panels(breaks, longest):
    """Starts and lengths of panels: every stretch between breaks divided evenly so that none is over `longest`."""
    count = 0
    for k in range(len(breaks) - 1):
        count += int(np.ceil((breaks[k + 1] - breaks[k]) / longest - 1e-9))
    starts, lengths = np.empty(count), np.empty(count)
    i = 0
    for k in range(len(breaks) - 1):
        parts = int(np.ceil((breaks[k + 1] - breaks[k]) / longest - 1e-9))
        h = (breaks[k + 1] - breaks[k]) / parts
        for part in range(parts):
            starts[i] = breaks[k] + part * h
            lengths[i] = h
            i += 1
    return starts, lengths


@numba.njit(cache=True)
def _delayed(c, panel, t0, h, starts, lengths, delay, z_series, nodes, to_legendre, where, values, w, sliver):
    """Fill w (s + 1), the Legendre coefficients of z_c(t - delay) on a panel, from the panels before it."""
    first = t0 - delay
    k = where[c]
    while k + 1 < panel and starts[k] + lengths[k] <= first + 1e-9 * h:
        k += 1
    where[c] = k
    if abs(starts[k] - first) <= sliver and abs(lengths[k] - h) <= sliver:  # a whole earlier panel
        assign(w, z_series[k, c])
        return
    if starts[k] + lengths[k] >= first + h - 1e-9 * h and not z_series[k, c, 1:].any():  # at rest
        w[:] = 0.0
        w[0] = z_series[k, c, 0]
        return
    for i in range(len(w)):
        t = first if i == 0 else first + nodes[i - 1] * h
        while k + 1 < panel and starts[k + 1] < t - 1e-9 * h:
            k += 1
        values[i] = legendre(z_series[k, c], 2.0 * (t - starts[k]) / lengths[k] - 1.0)
    transformed(to_legendre, values, w)


@numba.njit(cache=True)
def held(edges, inputs, starts, lengths, degree):
    """Legendre series (P, m, degree + 1) on panels of an input that takes the rows of `inputs` (k, m) at its edges."""
    series = np.zeros((len(starts), inputs.shape[1], degree + 1))
    edge = 0
    for panel in range(len(starts)):
        while edge + 1 < len(edges) and edges[edge + 1] <= starts[panel] + 1e-9 * lengths[panel]:
            edge += 1
        assign(series[panel, :, 0], inputs[edge])
    return series


@numba.njit(cache=True)
def projected(pieces, rule, starts, lengths):
    """Legendre series (P, m, s + 1) on panels of a piecewise Chebyshev polynomial (starts, lengths, series)."""
    nodes, to_legendre = rule[0], rule[1]
    piece_starts, piece_lengths, piece_series = pieces
    m, points = piece_series.shape[1], len(nodes) + 1
    series = np.empty((len(starts), m, points))
    values = np.empty(points)
    k = 0
    for panel in range(len(starts)):
        h = lengths[panel]
        while k + 1 < len(piece_starts) and piece_starts[k + 1] <= starts[panel] + 1e-9 * h:
            k += 1
        for row in range(m):
            for i in range(points):
                t = starts[panel] - piece_starts[k] + (nodes[i - 1] * h if i > 0 else 0.0)
                values[i] = clenshaw(piece_series[k, row], 2.0 * t / piece_lengths[k] - 1.0)
            transformed(to_legendre, values, series[panel, row])
    return series


@numba.njit(cache=True, fastmath=SUMS)
def _readout(C, D1, D2, X, u, W, row, y):
    """Fill y (s + 1) = row of C x + D1 u + D2 w in Legendre coefficients."""
    for k in range(len(y)):
        total = 0.0
        for a in range(X.shape[1]):
            total += C[row, a] * X[k, a]
        y[k] = total
    for b in range(u.shape[0]):
        if D1[row, b] != 0.0:
            for k in range(len(y)):
                y[k] += D1[row, b] * u[b, k]
    for c in range(W.shape[0]):
        if D2[row, c] != 0.0:
            for k in range(len(y)):
                y[k] += D2[row, c] * W[c, k]


@numba.njit(cache=True)
def _force(F, B, u):
    """F (s + 1, n) += B u in Legendre coefficients u (m, s + 1)."""
    for a in range(F.shape[1]):
        for b in range(u.shape[0]):
            if B[a, b] != 0.0:
                for k in range(F.shape[0]):
                    F[k, a] += B[a, b] * u[b, k]


@numba.njit(cache=True)
def march_panels(blocks, grid, past, u_series, jumps, x0, rule):
    """March over given panels.

    `grid` = (starts, lengths) of the P panels; `past` = (starts, lengths, Legendre series (H, q, s + 1)) of the delayed
    signals before time 0; `u_series` (P, m, s + 1) the inputs in Legendre coefficients; `jumps` (P, n) are added to the
    state at panel starts (none if it has no rows). Returns y (P, p, s + 1) in Chebyshev coefficients, the states
    (P + 1, n) at panel starts and the end, x (P, s + 1, n), w (P, q, s + 1) and z (H + P, q, s + 1) in Legendre ones.
    """
    A, B1, B2, C1, C2, D11, D12, D21, D22, tau = blocks
    nodes, to_legendre, to_chebyshev, _ = rule
    n, q, p, s, H = A.shape[0], len(tau), C1.shape[0], len(nodes), len(past[0])
    starts, lengths = np.concatenate((past[0], grid[0])), np.concatenate((past[1], grid[1]))
    P = len(grid[0])
    sliver = 1e-14 * (starts[-1] + lengths[-1])
    slots = min(8, P)
    R, S = np.empty((slots, s, n, n)), np.empty((slots, s, n, n))
    kinds = np.full(slots, -1.0)
    oldest = 0
    z_series = np.empty((H + P, q, s + 1))
    for k in range(H):
        for i in range(q):
            assign(z_series[k, i], past[2][k, i])
    y_series, states = np.empty((P, p, s + 1)), np.empty((P + 1, n))
    x_series, w_series = np.empty((P, s + 1, n)), np.empty((P, q, s + 1))
    F, c = np.empty((s + 1, n)), np.empty((s, n))
    values, y, where = np.empty(s + 1), np.empty(s + 1), np.zeros(q, np.int64)
    x = x0.copy()
    for panel in range(P):
        h = lengths[H + panel]
        kind = -1
        for k in range(slots):
            if abs(h - kinds[k]) <= 1e-11 * h:
                kind = k
                break
        if kind < 0:
            kind, oldest = oldest, (oldest + 1) % slots
            kinds[kind] = h
            factor(A, h, R[kind], S[kind])
        if len(jumps):
            x += jumps[panel]
        assign(states[panel], x)
        u, W, X = u_series[panel], w_series[panel], x_series[panel]
        for i in range(q):
            _delayed(
                i, H + panel, starts[H + panel], h, starts, lengths, tau[i], z_series, nodes, to_legendre, where,
                values, W[i], sliver,
            )  # fmt: skip
        F[:] = 0.0
        _force(F, B1, u)
        _force(F, B2, W)
        solve(A, R[kind], S[kind], h, x, F, c, X)
        for a in range(n):
            x[a] += h * c[0, a]
        for row in range(p):
            _readout(C1, D11, D12, X, u, W, row, y)
            chebyshev_from(to_chebyshev, y, y_series[panel, row])
        for row in range(q):
            _readout(C2, D21, D22, X, u, W, row, z_series[H + panel, row])
    assign(states[P], x)
    return y_series, states, x_series, w_series, z_series


@numba.njit(cache=True)
def passages(tau, D22):
    """Delays and all sums of them along chains (D22) that a signal passes without passing a state, (k,) [s]."""
    q = len(tau)
    if not D22.any():
        return tau
    found = tau
    at, total = np.arange(q), tau
    for _ in range(q - 1):
        count = 0
        next_at, next_total = np.empty(len(at) * q, np.int64), np.empty(len(at) * q)
        for k in range(len(at)):
            for j in range(q):
                if D22[j, at[k]] != 0.0:
                    next_at[count], next_total[count] = j, total[k] + tau[j]
                    count += 1
        at, total = next_at[:count].copy(), next_total[:count].copy()
        found = np.concatenate((found, total))
    return _merged(found, 1e-12 * found.max())


@numba.njit(cache=True)
def grid_of(blocks, edges, end, rule):
    """Starts and lengths of panels over [0, end] that no kink falls into; edges may lie in the past."""
    A, B2, C2, D22, tau = blocks[0], blocks[2], blocks[4], blocks[8], blocks[9]
    longest = min(end, rule[3] / max(rate_scale(A, B2, C2), 1e-300))
    for delay in tau:  # a panel reads delayed values from panels before it, never from itself
        longest = min(longest, delay)
    return panels(breakpoints(edges, passages(tau, D22), end, 8), longest)


@numba.njit(cache=True)
def constant_past(z0, tau, degree):
    """One panel of the past, as long as the longest delay, on which the delayed signals are z0 (q,)."""
    longest = tau.max() if len(tau) else 1.0
    series = np.zeros((1, len(tau), degree + 1))
    assign(series[0, :, 0], z0)
    return np.array([-longest]), np.array([longest]), series


@numba.njit(cache=True)
def delayed_series(starts, lengths, first, tau, series, rule):
    """Legendre coefficients (P, q, s + 1) of series_i(t - tau_i) on the panels from number `first` on."""
    nodes, to_legendre = rule[0], rule[1]
    q, points = len(tau), len(nodes) + 1
    delayed = np.empty((len(starts) - first, q, points))
    where, values = np.zeros(q, np.int64), np.empty(points)
    sliver = 1e-14 * (starts[-1] + lengths[-1])
    for panel in range(first, len(starts)):
        for i in range(q):
            _delayed(
                i, panel, starts[panel], lengths[panel], starts, lengths, tau[i], series, nodes, to_legendre, where,
                values, delayed[panel - first, i], sliver,
            )  # fmt: skip
    return delayed


@numba.njit(cache=True)
def moving_jumps(starts, lengths, first, tau, tau_slope, z_series, B2, D22):
    """Jumps (P, n) of the states' derivatives where jumps of z arrive at times that move with the delays."""
    many, q = len(starts), len(tau)
    tolerance = 4e-12 * (starts[-1] + lengths[-1])
    impulses = np.zeros((many, q))  # of dz at panel starts
    jumps = np.zeros((many - first, B2.shape[0]))
    where = np.zeros(q, np.int64)
    dw = np.empty(q)
    for panel in range(first, many):
        for i in range(q):
            dw[i] = 0.0
            sent = starts[panel] - tau[i]
            while where[i] + 1 < many and starts[where[i]] < sent - tolerance:
                where[i] += 1
            k = where[i]
            if k > 0 and abs(starts[k] - sent) <= tolerance:
                jump = legendre(z_series[k, i], -1.0) - legendre(z_series[k - 1, i], 1.0)
                dw[i] = impulses[k, i] - tau_slope[i] * jump
        for a in range(B2.shape[0]):
            for i in range(q):
                jumps[panel - first, a] += B2[a, i] * dw[i]
        for c in range(q):
            for i in range(q):
                impulses[panel, c] += D22[c, i] * dw[i]
    return jumps


@numba.njit(cache=True)
def march(blocks, edges, inputs, x0, z0, end, rule):
    """March over panels; returns starts, lengths, Chebyshev series of y (P, p, s + 1) and the states at panel ends.

    `blocks` holds those of `DelayLTI`, tau last; `edges` (k,) are the times at which the input takes the rows of
    `inputs` (k, m); z0 (q,) are the delayed signals of a constant past; `rule` is the collocation rule.
    """
    grid = grid_of(blocks, edges, end, rule)
    degree = len(rule[0])
    past = constant_past(z0, blocks[9], degree)
    u_series = held(edges, inputs, grid[0], grid[1], degree)
    none = np.empty((0, len(x0)))
    y_series, states, _, _, _ = march_panels(blocks, grid, past, u_series, none, x0, rule)
    return grid[0], grid[1], y_series, states


@numba.njit(cache=True)
def sample(starts, lengths, series, times):
    """Values (p, len(times)) of a piecewise Chebyshev series at non-decreasing times inside its range.

    Clenshaw's recurrence runs over all times of a panel side by side, so that it fills the lanes of the processor.
    """
    p, degree, many = series.shape[1], series.shape[2] - 1, len(times)
    out = np.empty((p, many))
    x, b1, b2 = np.empty(_LANES), np.empty(_LANES), np.empty(_LANES)
    panel, first = 0, 0
    while first < many:
        while panel + 1 < len(starts) and starts[panel + 1] <= times[first]:
            panel += 1
        stop = first + 1
        limit = min(many, first + _LANES)
        right = starts[panel + 1] if panel + 1 < len(starts) else np.inf
        while stop < limit and times[stop] < right:
            stop += 1
        count = stop - first
        left, scale = starts[panel], 2.0 / lengths[panel]
        for i in range(count):
            x[i] = scale * (times[first + i] - left) - 1.0
        for row in range(p):
            coefficients = series[panel, row]
            for i in range(count):
                b1[i], b2[i] = 0.0, 0.0
            for k in range(degree, 0, -1):
                add = coefficients[k]
                for i in range(count):
                    b2[i], b1[i] = b1[i], 2.0 * x[i] * b1[i] - b2[i] + add
            add = coefficients[0]
            for i in range(count):
                out[row, first + i] = x[i] * b1[i] - b2[i] + add
        first = stop
    return out


@numba.njit(cache=True)
def _slope(series, slope):
    """Chebyshev coefficients of the derivative with respect to x."""
    degree = len(series) - 1
    slope[degree] = 0.0
    if degree >= 1:
        slope[degree - 1] = 2.0 * degree * series[degree]
    for k in range(degree - 1, 0, -1):
        slope[k - 1] = slope[k + 1] + 2.0 * k * series[k]
    slope[0] *= 0.5


@numba.njit(cache=True)
def _largest_between(series, slope, left, right):
    """Where |y| is largest on a short interval: an end, or the extremum that a change of the slope's sign brackets."""
    best = left if abs(clenshaw(series, left)) >= abs(clenshaw(series, right)) else right
    sign = clenshaw(slope, left)
    if sign * clenshaw(slope, right) < 0.0:
        a, b = left, right
        for _ in range(60):
            middle = 0.5 * (a + b)
            if clenshaw(slope, middle) * sign > 0.0:
                a = middle
            else:
                b = middle
        if abs(clenshaw(series, a)) > abs(clenshaw(series, best)):
            best = a
    return best


@numba.njit(cache=True)
def last_time_outside(starts, lengths, series, band):
    """Last time at which |y| > band for one output (P, s + 1); -1 when never, inf when still outside at the end."""
    cells = 16
    slope = np.empty(series.shape[1])
    for panel in range(len(starts) - 1, -1, -1):
        bound = 0.0
        for c in series[panel]:
            bound += abs(c)
        if bound <= band:
            continue
        if abs(clenshaw(series[panel], 1.0)) > band:
            return np.inf if panel == len(starts) - 1 else starts[panel] + lengths[panel]
        _slope(series[panel], slope)
        right = 1.0
        for k in range(cells - 1, -1, -1):
            left = 2.0 * k / cells - 1.0
            top = _largest_between(series[panel], slope, left, right)
            if abs(clenshaw(series[panel], top)) > band:
                return starts[panel] + 0.5 * (1.0 + _crossing(series[panel], band, top, right)) * lengths[panel]
            right = left
    return -1.0


@numba.njit(cache=True)
def _crossing(series, band, outside, inside):
    """Bisection for |y| = band between a point outside and a later one inside."""
    for _ in range(60):
        middle = 0.5 * (outside + inside)
        if abs(clenshaw(series, middle)) > band:
            outside = middle
        else:
            inside = middle
    return 0.5 * (outside + inside)


@numba.njit(cache=True)
def largest(starts, lengths, series):
    """Largest |y| of one output (P, s + 1) and its time."""
    best, when = -1.0, 0.0
    cells = 8
    slope = np.empty(series.shape[1])
    for panel in range(len(starts)):
        bound = 0.0
        for c in series[panel]:
            bound += abs(c)
        if bound <= best:
            continue
        _slope(series[panel], slope)
        for k in range(cells):
            top = _largest_between(series[panel], slope, 2.0 * k / cells - 1.0, 2.0 * (k + 1) / cells - 1.0)
            value = abs(clenshaw(series[panel], top))
            if value > best:
                best, when = value, starts[panel] + 0.5 * (1.0 + top) * lengths[panel]
    return best, when

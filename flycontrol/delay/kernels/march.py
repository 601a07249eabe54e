"""March of a time response over collocation panels. The mathematics stands in `flycontrol.delay.response`."""

from __future__ import annotations

import numba
import numpy as np


@numba.njit(cache=True)
def clenshaw(coefficients, x):
    """Value at x in [-1, 1] of a Chebyshev series."""
    b1, b2 = 0.0, 0.0
    for k in range(len(coefficients) - 1, 0, -1):
        b1, b2 = 2.0 * x * b1 - b2 + coefficients[k], b1
    return x * b1 - b2 + coefficients[0]


@numba.njit(cache=True)
def rate_scale(A, B2, C2):
    """Infinity norm of |A| + |B2| |C2| after Osborne's diagonal balancing [1/s]: how fast anything here can move."""
    n = A.shape[0]
    M = np.abs(A) + np.abs(B2) @ np.abs(C2)
    for _ in range(20):
        for i in range(n):
            row = M[i].sum() - M[i, i]
            column = M[:, i].sum() - M[i, i]
            if row > 0.0 and column > 0.0:
                factor = np.sqrt(column / row)
                M[i] *= factor
                M[:, i] /= factor
    largest = 0.0
    for i in range(n):
        largest = max(largest, M[i].sum())
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
def breakpoints(edges, tau, end, order):
    """Edges and their images under sums of up to `order` delays (all sums for a single delay) inside [0, end]."""
    tolerance = 1e-12 * end
    kept = edges[(edges >= 0.0) & (edges < end - tolerance)]
    newest = kept
    rounds = 1 + int(end / tau.min()) if len(tau) == 1 else order
    for _ in range(rounds if len(tau) else 0):
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
def _panel_inverse(A, h, K):
    """(I - h K (x) A)^-1, shape (s n, s n)."""
    s, n = K.shape[0], A.shape[0]
    big = np.eye(s * n)
    for i in range(s):
        for j in range(s):
            for a in range(n):
                for b in range(n):
                    big[i * n + a, j * n + b] -= h * K[i, j] * A[a, b]
    return np.linalg.inv(big)


@numba.njit(cache=True)
def _inverses(A, lengths, K):
    """One inverse for each different panel length, and for each panel the index of its own."""
    kind = np.empty(len(lengths), np.int64)
    different = np.empty(len(lengths))
    count = 0
    for i in range(len(lengths)):
        found = -1
        for k in range(count):
            if abs(lengths[i] - different[k]) <= 1e-11 * lengths[i]:
                found = k
                break
        if found < 0:
            different[count] = lengths[i]
            found = count
            count += 1
        kind[i] = found
    size = K.shape[0] * A.shape[0]
    inverses = np.empty((count, size, size))
    for k in range(count):
        inverses[k] = _panel_inverse(A, different[k], K)
    return inverses, kind


@numba.njit(cache=True)
def _delayed_values(W, panel, starts, lengths, tau, z_series, z0, nodes, where):
    """Fill W (s + 1, q) with z(t - tau) at the points of a panel, from earlier panels or the history z0."""
    h = lengths[panel]
    for c in range(len(tau)):
        first = starts[panel] - tau[c]
        if first + 0.5 * h < starts[0]:
            W[:, c] = z0[c]
            continue
        k = where[c]
        while starts[k] + lengths[k] <= first + 1e-9 * h:
            k += 1
        where[c] = k
        for i in range(W.shape[0]):
            t = first if i == 0 else first + nodes[i - 1] * h
            while k + 1 < panel and starts[k + 1] < t - 1e-9 * h:
                k += 1
            W[i, c] = clenshaw(z_series[k, c], 2.0 * (t - starts[k]) / lengths[k] - 1.0)


@numba.njit(cache=True)
def _readout(C, D1, D2, X, u, W, row, values):
    """values_i = row of C x + D1 u + D2 w at the points of a panel."""
    for i in range(len(values)):
        total = 0.0
        for a in range(X.shape[1]):
            total += C[row, a] * X[i, a]
        for b in range(len(u)):
            total += D1[row, b] * u[b]
        for c in range(W.shape[1]):
            total += D2[row, c] * W[i, c]
        values[i] = total


@numba.njit(cache=True)
def _fit(series, to_series, values):
    for k in range(len(values)):
        total = 0.0
        for i in range(len(values)):
            total += to_series[k, i] * values[i]
        series[k] = total


@numba.njit(cache=True)
def _advance(A, B1, B2, x, h, u, W, inverse, K, X, F, rhs):
    """Collocation states X (s + 1, n) of one panel from its start x; F (s, n) holds the forcing."""
    s, n = F.shape
    for i in range(s):
        for a in range(n):
            total = 0.0
            for b in range(len(u)):
                total += B1[a, b] * u[b]
            for c in range(W.shape[1]):
                total += B2[a, c] * W[i + 1, c]
            F[i, a] = total
    for i in range(s):
        for a in range(n):
            total = x[a]
            for j in range(s):
                total += h * K[i, j] * F[j, a]
            rhs[i * n + a] = total
    X[0] = x
    for i in range(s * n):
        total = 0.0
        for j in range(s * n):
            total += inverse[i, j] * rhs[j]
        X[1 + i // n, i % n] = total


@numba.njit(cache=True)
def march(blocks, edges, inputs, x0, z0, end, rule):
    """March over panels; returns starts, lengths, Chebyshev series of y (P, p, s + 1) and the states at panel ends.

    `blocks` holds those of `DelayLTI`, tau last; `edges` (k,) are the times at which the input takes the rows of
    `inputs` (k, m); `rule` is the collocation rule (nodes, weights, K, to_series, longest panel times rate).
    """
    A, B1, B2, C1, C2, D11, D12, D21, D22, tau = blocks
    nodes, weights, K, to_series, reach = rule
    n, q, p, s = A.shape[0], len(tau), C1.shape[0], len(nodes)
    breaks = breakpoints(edges, tau, end, 8)
    longest = min(end, reach / max(rate_scale(A, B2, C2), 1e-300))
    for delay in tau:  # a panel reads delayed values from panels before it, never from itself
        longest = min(longest, delay)
    starts, lengths = panels(breaks, longest)
    inverses, kind = _inverses(A, lengths, K)
    P = len(starts)
    x = x0.copy()
    states = np.empty((P + 1, n))
    states[0] = x
    y_series, z_series = np.empty((P, p, s + 1)), np.empty((P, q, s + 1))
    W, X, F = np.zeros((s + 1, q)), np.empty((s + 1, n)), np.empty((s, n))
    rhs, values = np.empty(s * n), np.empty(s + 1)
    where = np.zeros(q, np.int64)
    edge = 0
    for panel in range(P):
        h = lengths[panel]
        while edge + 1 < len(edges) and edges[edge + 1] <= starts[panel] + 1e-9 * h:
            edge += 1
        u = inputs[edge]
        _delayed_values(W, panel, starts, lengths, tau, z_series, z0, nodes, where)
        _advance(A, B1, B2, x, h, u, W, inverses[kind[panel]], K, X, F, rhs)
        for a in range(n):
            total = x[a]
            for j in range(s):
                slope = F[j, a]
                for b in range(n):
                    slope += A[a, b] * X[1 + j, b]
                total += h * weights[j] * slope
            states[panel + 1, a] = total
        x = states[panel + 1]
        for row in range(p):
            _readout(C1, D11, D12, X, u, W, row, values)
            _fit(y_series[panel, row], to_series, values)
        for row in range(q):
            _readout(C2, D21, D22, X, u, W, row, values)
            _fit(z_series[panel, row], to_series, values)
    return starts, lengths, y_series, states


@numba.njit(cache=True)
def sample(starts, lengths, series, times):
    """Values (p, len(times)) of a piecewise Chebyshev series at non-decreasing times inside its range."""
    out = np.empty((series.shape[1], len(times)))
    panel = 0
    for t in range(len(times)):
        while panel + 1 < len(starts) and starts[panel + 1] <= times[t]:
            panel += 1
        x = 2.0 * (times[t] - starts[panel]) / lengths[panel] - 1.0
        for row in range(series.shape[1]):
            out[row, t] = clenshaw(series[panel, row], x)
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

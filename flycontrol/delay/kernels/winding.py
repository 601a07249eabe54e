"""The count by the argument principle in one kernel. The mathematics stands in `flycontrol.delay.count`."""

from __future__ import annotations

import numba
import numpy as np

TOO_NEAR, NOT_COUNTED = -1, -2


@numba.njit(cache=True, error_model="numpy")
def scale(A, B2, C2, D22):
    """Scale states and delayed signals to each other, in place: by powers of two, so that nothing is rounded.

    Returns the factors of the states (n,) and of the delayed signals (q,): A_ij f_i / f_j, B2_ic f_i g_c,
    C2_cj / (g_c f_j), D22_cd g_d / g_c.
    """
    n, q = B2.shape
    states, signals = np.ones(n), np.ones(q)
    weight = np.zeros((n, n))
    for a in range(n):
        for b in range(n):
            weight[a, b] = abs(A[a, b])
            for c in range(q):
                weight[a, b] += abs(B2[a, c] * C2[c, b])
    for _ in range(10):
        settled = True
        for i in range(n):  # Osborne: row and column of alike size
            row, column = 0.0, 0.0
            for j in range(n):
                if j != i:
                    row += weight[i, j]
                    column += weight[j, i]
            factor = _halfway(column, row)
            if factor != 1.0:
                settled = False
                states[i] *= factor
                for j in range(n):
                    weight[i, j] *= factor
                    weight[j, i] /= factor
        if settled:
            break
    for c in range(q):  # a delayed signal's entry and reading of alike size
        entry, reading = 0.0, 0.0
        for a in range(n):
            entry = max(entry, abs(B2[a, c]) * states[a])
            reading = max(reading, abs(C2[c, a]) / states[a])
        signals[c] = _halfway(reading, entry)
    _rescale(A, B2, C2, D22, states, signals)
    return states, signals


@numba.njit(cache=True, error_model="numpy")
def _halfway(size, other):
    """The power of two next to sqrt(size / other); 1 where either is zero."""
    return 2.0 ** np.rint(0.5 * np.log2(size / other)) if size > 0.0 and other > 0.0 else 1.0


@numba.njit(cache=True, error_model="numpy")
def _rescale(A, B2, C2, D22, f, g):
    n, q = B2.shape
    for a in range(n):
        for b in range(n):
            A[a, b] *= f[a] / f[b]
        for c in range(q):
            B2[a, c] *= f[a] * g[c]
            C2[c, a] /= g[c] * f[a]
    for c in range(q):
        for d in range(q):
            D22[c, d] *= g[d] / g[c]


@numba.njit(cache=True, error_model="numpy")
def characteristic(M, A, B2, C2, D22, tau, s):
    """Fill M = [[s I - A, -B2], [-E C2, I - E D22]]."""
    n, q = A.shape[0], len(tau)
    for a in range(n):
        for b in range(n):
            M[a, b] = -A[a, b]
        M[a, a] += s
        for c in range(q):
            M[a, n + c] = -B2[a, c]
    for c in range(q):
        factor = np.exp(-s * tau[c])
        for b in range(n):
            M[n + c, b] = -factor * C2[c, b]
        for d in range(q):
            M[n + c, n + d] = -factor * D22[c, d]
        M[n + c, n + c] += 1.0


@numba.njit(cache=True, error_model="numpy")
def _size(z):
    return abs(z.real) + abs(z.imag)


@numba.njit(cache=True, error_model="numpy")
def invert(M, inverse):
    """Gauss-Jordan with row pivoting; returns the direction of det M, of modulus 1, or 0 if M is singular."""
    size = M.shape[0]
    direction = 1.0 + 0.0j
    for i in range(size):
        for j in range(size):
            inverse[i, j] = 0.0
        inverse[i, i] = 1.0
    for k in range(size):
        pivot, largest = k, _size(M[k, k])
        for i in range(k + 1, size):
            if _size(M[i, k]) > largest:
                pivot, largest = i, _size(M[i, k])
        if not largest > 0.0:
            return 0.0j
        if pivot != k:
            direction = -direction
            for j in range(size):
                M[k, j], M[pivot, j] = M[pivot, j], M[k, j]
                inverse[k, j], inverse[pivot, j] = inverse[pivot, j], inverse[k, j]
        entry = M[k, k] * (1.0 / largest)  # the quotient of complex numbers in Numba is slow
        square = entry.real * entry.real + entry.imag * entry.imag
        direction *= entry * (1.0 / np.sqrt(square))
        reciprocal = entry.conjugate() * (1.0 / (square * largest))
        for j in range(k + 1, size):
            M[k, j] *= reciprocal
        for j in range(size):
            inverse[k, j] *= reciprocal
        for i in range(size):
            ratio = M[i, k]
            if i != k and _size(ratio) > 0.0:
                for j in range(k + 1, size):
                    M[i, j] -= ratio * M[k, j]
                for j in range(size):
                    inverse[i, j] -= ratio * inverse[k, j]
    return direction


@numba.njit(cache=True, error_model="numpy")
def _perron_bound(inverse, slope, product, y, image):
    """Upper bound on the Perron root of P = |inverse| slope: max (P y)_i / y_i for any y > 0 (Collatz, Wielandt).

    A few power steps make it tight; y is kept from call to call, since neighbours on the line resemble each other.
    """
    size = len(y)
    for i in range(size):
        for j in range(size):
            product[i, j] = 0.0
        for k in range(size):
            entry = np.sqrt(inverse[i, k].real ** 2 + inverse[i, k].imag ** 2)
            for j in range(size):
                product[i, j] += entry * slope[k, j]
    bound = np.inf
    for _ in range(3):
        ratio, largest = 0.0, 0.0
        for i in range(size):
            total = 0.0
            for j in range(size):
                total += product[i, j] * y[j]
            image[i] = total
            ratio = max(ratio, total / y[i])
            largest = max(largest, total)
        bound = min(bound, ratio)
        for i in range(size):
            y[i] = image[i] / largest + 1e-6
    return bound


@numba.njit(cache=True, error_model="numpy")
def _feeds_itself(D22):
    """Whether a path leads from a delay back into itself without passing a state."""
    q = len(D22)
    fed = np.ones(q, np.bool_)
    for _ in range(q):  # each sweep settles at least one channel more
        looped = False
        for c in range(q):
            fed[c] = False
            for d in range(q):
                fed[c] = fed[c] or (D22[c, d] != 0.0 and fed[d])
            looped = looped or fed[c]
        if not looped:
            return False
    return q > 0


@numba.njit(cache=True, error_model="numpy")
def _sizes(A, B2, C2, D22, growth):
    """|A| + |B2| (I - G |D22|)^-1 G |C2|, G = diag growth."""
    n, q = B2.shape
    N, chain = np.empty((n, n)), np.zeros((q, n))
    for _ in range(q):  # exact: D22 is nilpotent
        for c in range(q):
            for b in range(n):
                total = abs(C2[c, b])
                for d in range(q):
                    total += abs(D22[c, d]) * chain[d, b]
                chain[c, b] = growth[c] * total
    for a in range(n):
        for b in range(n):
            N[a, b] = abs(A[a, b])
            for c in range(q):
                N[a, b] += abs(B2[a, c]) * chain[c, b]
    return N


@numba.njit(cache=True, error_model="numpy")
def radius(A, B2, C2, D22, growth):
    """A bound on |s| for every root with |exp(-s tau)| <= growth; inf for a system of neutral type or on overflow.

    The Perron root of |A| + |B2| (I - G |D22|)^-1 G |C2|, G = diag growth, from above by Collatz and Wielandt.
    """
    n = len(A)
    if _feeds_itself(D22):
        return np.inf
    N = _sizes(A, B2, C2, D22, growth)
    y, image = np.ones(n), np.empty(n)
    bound = np.inf
    for _ in range(8):
        ratio, largest = 0.0, 0.0
        for a in range(n):
            image[a] = 0.0
            for b in range(n):
                image[a] += N[a, b] * y[b]
            if not image[a] < 1e300:  # overflow, or zero times infinity
                return np.inf
            ratio = max(ratio, image[a] / y[a])
        bound = min(bound, ratio)
        for a in range(n):
            y[a] = image[a] + 0.3 * ratio * y[a] + 1e-300  # the shift keeps a periodic matrix from swinging
            largest = max(largest, y[a])
        for a in range(n):
            y[a] = max(y[a] / largest, 1e-12)
    return bound


@numba.njit(cache=True, error_model="numpy")
def _phase_along_line(M, A, B2, C2, D22, tau, line, top, most):
    """Phase change of det M(line + j w) from w = 0 to `top`, its direction there, and the steps taken.

    From a point s the step h keeps h times the Perron root of |M(s)^-1| |M'| below rho, where |M'| bounds the slope of
    M on the whole line entry by entry. Then det M(s + j h) / det M(s) is a product of n + q numbers within rho of 1, so
    its phase is below pi when (n + q) asin(rho) is, and its principal value is the true change. The phase is NaN if a
    root lies so near the line that steps vanish.
    """
    n, q = A.shape[0], len(tau)
    size = n + q
    slope = np.zeros((size, size))
    for a in range(n):
        slope[a, a] = 1.0
    for c in range(q):
        growth = tau[c] * np.exp(-line * tau[c])
        for b in range(n):
            slope[n + c, b] = growth * abs(C2[c, b])
        for d in range(q):
            slope[n + c, n + d] = growth * abs(D22[c, d])
    rho = 0.9 * np.sin(min(np.pi / size, 0.5 * np.pi))
    inverse = np.empty((size, size), np.complex128)
    product, y, image = np.empty((size, size)), np.ones(size), np.empty(size)
    w, total, steps = 0.0, 0.0, 0
    characteristic(M, A, B2, C2, D22, tau, complex(line, 0.0))
    before = invert(M, inverse)
    while w < top:
        if before == 0.0 or steps >= most:
            return np.nan, before, steps
        ahead = min(top, w + rho / _perron_bound(inverse, slope, product, y, image))
        if not ahead > w:
            return np.nan, before, steps
        w = ahead
        characteristic(M, A, B2, C2, D22, tau, complex(line, w))
        after = invert(M, inverse)
        total += np.angle(after * np.conj(before))
        before = after
        steps += 1
    return (total if before != 0.0 else np.nan), before, steps


@numba.njit(cache=True, error_model="numpy")
def count_right_of(A, B2, C2, D22, tau, line, most):
    """Roots with Re s > line of a system with states, scaled as by `scale`, or TOO_NEAR or NOT_COUNTED; and the steps.

    All roots there have |s| <= R. At |s| >= R / sin(pi / n) the factors 1 - mu / s of det M(s) / s^n, |mu| <= R, turn
    by less than pi altogether, so that the principal value of its phase is the phase of the arc.
    """
    n, size = A.shape[0], A.shape[0] + len(tau)
    bound = radius(A, B2, C2, D22, np.exp(-line * tau))
    if not bound < 1e150:
        return NOT_COUNTED, 0
    if line > 1.0001 * bound:
        return 0, 0
    top = bound / (0.9 * np.sin(np.pi / max(n, 2)))
    M = np.empty((size, size), np.complex128)
    phase, direction, steps = _phase_along_line(M, A, B2, C2, D22, tau, line, top, most)
    if np.isnan(phase):
        return (NOT_COUNTED if steps >= most else TOO_NEAR), steps
    corner = n * np.angle(complex(line, top))
    arc = corner + np.angle(direction * np.exp(complex(0.0, -corner)))
    turns = (arc - phase) / np.pi
    whole = np.rint(turns)
    return (int(whole) if abs(turns - whole) < 1e-6 else NOT_COUNTED), steps


@numba.njit(cache=True, error_model="numpy")
def count_each(A, B2, C2, D22, tau, line, most):
    """`count_right_of` for k systems of one structure: blocks (k, ...), tau (k, q), line (k,). Scales the blocks."""
    roots = np.empty(len(line), np.int64)
    steps = np.empty(len(line), np.int64)
    for k in range(len(line)):
        scale(A[k], B2[k], C2[k], D22[k])
        roots[k], steps[k] = count_right_of(A[k], B2[k], C2[k], D22[k], tau[k], line[k], most)
    return roots, steps

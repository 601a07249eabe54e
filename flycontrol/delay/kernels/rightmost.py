"""From a delay system to eigenvalues, and from these to roots. The mathematics: `flycontrol.delay.spectrum`."""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.delay.kernels.newton import polish


@numba.njit(cache=True, error_model="numpy")
def _differentiation(n):
    """Differentiation matrix (n + 1, n + 1) at the Chebyshev points of [0, 1] from 0 up to 1 (Trefethen 2000)."""
    x, c, D = np.empty(n + 1), np.ones(n + 1), np.empty((n + 1, n + 1))
    for k in range(n + 1):
        x[k] = 0.5 - 0.5 * np.cos(np.pi * k / n)
        if k % 2 == 1:
            c[k] = -1.0
    c[0] *= 2.0
    c[n] *= 2.0
    for i in range(n + 1):
        total = 0.0
        for j in range(n + 1):
            if j != i:
                D[i, j] = c[i] / (c[j] * (x[i] - x[j]))
                total += D[i, j]
        D[i, i] = -total
    return D


@numba.njit(cache=True, error_model="numpy")
def collocation(A, B2, C2, D22, tau, longest, nodes):
    """Matrix of states and transport lines v_t = -v_theta / tau, v(0) = z, w = v(1); A, B2, D22 real or complex.

    The longest delay has `nodes` nodes, a shorter one its share, at least 6.
    """
    n, q = B2.shape
    ends = np.empty(q, np.int64)
    last = n - 1
    for i in range(q):
        last += max(6, int(np.ceil(nodes * tau[i] / longest)))
        ends[i] = last
    M = np.zeros((last + 1, last + 1), A.dtype)
    for a in range(n):
        for b in range(n):
            M[a, b] = A[a, b]
        for i in range(q):
            M[a, ends[i]] = B2[a, i]
    first = n
    for i in range(q):
        D = _differentiation(ends[i] + 1 - first)
        for k in range(1, len(D)):
            row = first + k - 1
            for j in range(1, len(D)):
                M[row, first + j - 1] = -D[k, j] / tau[i]
            inflow = -D[k, 0] / tau[i]
            for b in range(n):
                M[row, b] = inflow * C2[i, b]
            for d in range(q):
                M[row, ends[d]] += inflow * D22[i, d]
        first = ends[i] + 1
    return M


@numba.njit(cache=True, error_model="numpy")
def _precedes(a, b, unit):
    """Order by falling real part (to rounding), then rising |imag|, upper half first."""
    left, right = np.rint(a.real / unit), np.rint(b.real / unit)
    if left != right:
        return left > right
    if abs(a.imag) != abs(b.imag):
        return abs(a.imag) < abs(b.imag)
    return a.imag > b.imag


@numba.njit(cache=True, error_model="numpy")
def _rounding(roots):
    largest = 0.0
    for z in roots:
        largest = max(largest, abs(z))
    return 1e-12 * largest + 1e-300


@numba.njit(cache=True, error_model="numpy")
def _is_possible(A, B2, C2, D22, tau, longest, s):
    """Whether |s| <= ||A|| + ||B2|| ||(I - E D22)^-1 E C2||, E = diag exp(-tau Re s), as for every root of the system.

    Weak feedback has its later roots far left, where collocation also puts eigenvalues that are roots of nothing.
    """
    n, q = B2.shape
    chain = np.zeros(q)
    for _ in range(q):  # exact: D22 is nilpotent
        for c in range(q):
            reading = 0.0
            for b in range(n):
                reading += abs(C2[c, b])
            for d in range(q):
                reading += abs(D22[c, d]) * chain[d]
            chain[c] = np.exp(min(-s.real * tau[c], 200.0)) * reading
    bound = 0.0
    for a in range(n):
        row = 0.0
        for b in range(n):
            row += abs(A[a, b])
        for c in range(q):
            row += abs(B2[a, c]) * chain[c]
        bound = max(bound, row)
    return abs(s) <= 1.5 * bound + 1e-3 / longest


@numba.njit(cache=True, error_model="numpy")
def _starts(blocks, longest, eigenvalues, many):
    """Of the first `many` possible eigenvalues in order, those with imag >= 0."""
    A, B2, C2, D22, tau = blocks
    unit = _rounding(eigenvalues)
    left = np.empty(len(eigenvalues), np.bool_)
    for k in range(len(eigenvalues)):
        left[k] = _is_possible(A, B2, C2, D22, tau, longest, eigenvalues[k])
    found = np.empty(many, np.complex128)
    upper = 0
    for _ in range(many):
        best = -1
        for k in range(len(eigenvalues)):
            if left[k] and (best < 0 or _precedes(eigenvalues[k], eigenvalues[best], unit)):
                best = k
        if best < 0:
            break
        left[best] = False
        if eigenvalues[best].imag >= 0.0:
            found[upper] = eigenvalues[best]
            upper += 1
    return found[:upper].copy()


@numba.njit(cache=True, error_model="numpy")
def _keep(start, roots, steps, longest):
    """Which roots to trust.

    A start that Newton carries far away was no root of the exact system, and two starts apart that meet were one: both
    are dropped, for the count to notice if a root is missing. Three roots that meet are known to eps^(1/3); what still
    moves by more circles around a root that others hold.
    """
    keep = np.zeros(len(roots), np.bool_)
    for k in range(len(roots)):
        size = abs(roots[k])
        near = abs(roots[k] - start[k]) <= 0.1 * abs(start[k]) + 1e-3 / longest
        keep[k] = near and steps[k] <= 1e-4 * size + 1e-12 / longest
        for j in range(k):
            twin = keep[j] and abs(roots[j] - roots[k]) <= 1e-7 * size + 1e-13 / longest
            if twin and abs(start[j] - start[k]) > 1e-2 * abs(start[k]):
                keep[k] = False
    return keep


@numba.njit(cache=True, error_model="numpy")
def _polished(blocks, longest, start):
    """Roots with their conjugates in order, and the error of each: its last Newton step, or the size of its cluster."""
    roots = start.copy()
    paired = np.empty(len(start), np.bool_)
    for k in range(len(start)):
        paired[k] = start[k].imag > 0.0
    steps = polish(blocks, roots, paired, 40)
    for k in range(len(roots)):
        roots[k] = complex(roots[k].real, abs(roots[k].imag))
    keep = _keep(start, roots, steps, longest)
    unit = _rounding(roots[keep])
    found, errors = np.empty(2 * len(roots), np.complex128), np.empty(2 * len(roots))
    many = 0
    for k in range(len(roots)):
        for mirrored in range(2 if paired[k] else 1):
            if keep[k]:
                root = roots[k].conjugate() if mirrored else roots[k]
                place = many
                while place > 0 and _precedes(root, found[place - 1], unit):
                    found[place], errors[place] = found[place - 1], errors[place - 1]
                    place -= 1
                found[place], errors[place] = root, steps[k]
                many += 1
    for k in range(many):  # no root of a tight cluster is known better than its spread
        for j in range(many):
            gap = abs(found[k] - found[j])
            if gap < 1e-4 * abs(found[k]):
                errors[k] = max(errors[k], gap)
    return found[:many], errors[:many]


@numba.njit(cache=True, error_model="numpy")
def _whole(roots, count):
    """How many of the roots make up the first `count`, one more if the last would leave its conjugate behind."""
    head = min(count, len(roots))
    return head + 1 if 0 < head < len(roots) and roots[head - 1].imag > 0.0 else head


@numba.njit(cache=True, error_model="numpy")
def _line_left_of(roots, errors, many, longest):
    """A vertical line between root `many` and the next one on the left; NaN where the gap is too narrow.

    What is narrow is judged by these two roots: a fast root far right does not blur a chain of slow ones.
    """
    if many == 0:
        return np.nan
    last, size = roots[many - 1].real, abs(roots[many - 1])
    if many == len(roots):
        return last - max(0.02 * size, 1e-5 / longest)
    size = max(size, abs(roots[many]))
    gap = last - roots[many].real
    narrow = 1e-9 * size + 10.0 * (errors[many - 1] + errors[many])
    return last - min(0.5 * gap, 0.05 * size) if gap > narrow else np.nan


@numba.njit(cache=True, error_model="numpy")
def _cluster_goes_on(roots, many):
    """Whether the next root is a near neighbour: a count between roots of a cluster takes steps without end."""
    nearest = np.inf
    for k in range(many):
        if many < len(roots):
            nearest = min(nearest, abs(roots[k] - roots[many]) / abs(roots[many]))
    return nearest < 0.6


@numba.njit(cache=True, error_model="numpy")
def rightmost(A, B2, C2, D22, tau, longest, eigenvalues, count, apart):
    """The `count` rightmost roots of a scaled system, their errors, a line left of them, and whether a cluster goes on.

    A pair is not split. The line is NaN if the next root shares the real part; if they must be `apart`, it comes along.
    """
    blocks = (A, B2, C2, D22, tau)
    roots, errors = _polished(blocks, longest, _starts(blocks, longest, eigenvalues, count + 6))
    many = _whole(roots, count)
    line = _line_left_of(roots, errors, many, longest)
    while apart and np.isnan(line) and many < len(roots):
        many = _whole(roots, many + 1)
        line = _line_left_of(roots, errors, many, longest)
    return roots[:many], errors[:many], line, _cluster_goes_on(roots, many)

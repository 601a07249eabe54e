"""Roots, extremes and turns of polynomials in Bernstein form, by halving until the control points decide.

A polynomial on [-1, 1] is a convex combination of its control points, the first and last of which are its end values.
What all control points have in common, the polynomial has everywhere; halving moves them towards the polynomial.
"""

from __future__ import annotations

import numba
import numpy as np

_DEEPEST = 26  # halvings: two roots within 2^-26 of a panel count as one touch


@numba.njit(cache=True)
def _halves(points):
    """De Casteljau's algorithm: control points (n + 1, d) of the left and of the right half."""
    n, many = points.shape[0] - 1, points.shape[1]
    left, right, work = np.empty_like(points), np.empty_like(points), points.copy()
    for k in range(n + 1):
        for e in range(many):
            for i in range(n + 1 - k if k else 0):
                work[i, e] = 0.5 * (work[i, e] + work[i + 1, e])
            left[k, e], right[n - k, e] = work[0, e], work[n - k, e]
    return left, right


@numba.njit(cache=True)
def _changes_of_sign(values):
    """Sign changes along the control points, zero taken as positive: at least the number of roots (Descartes)."""
    changes = 0
    for k in range(1, len(values)):
        if (values[k] >= 0.0) != (values[k - 1] >= 0.0):
            changes += 1
    return changes


@numba.njit(cache=True)
def _value(points, x):
    """The polynomial with control points (n + 1,) at x in [0, 1], by Horner's scheme with binomials carried along."""
    n = len(points) - 1
    weight, total = 1.0, points[0] * (1.0 - x)
    for i in range(1, n):
        weight *= x * (n - i + 1) / i
        total = (total + weight * points[i]) * (1.0 - x)
    return total + weight * x / n * points[n]


@numba.njit(cache=True)
def _only_root(points):
    """The root in [0, 1] of a polynomial with one change of sign, by the Illinois variant of regula falsi."""
    a, b, at_a, at_b = 0.0, 1.0, points[0], points[-1]
    for _ in range(60):
        step = at_b * (b - a) / (at_b - at_a)
        a, b, at_a, at_b = (a, b - step, at_a, at_b) if step != 0.0 else (a, b, at_a, at_b)
        here = _value(points, b)
        if (here >= 0.0) != (at_b >= 0.0):
            a, at_a = b + step, at_b
        else:
            at_a *= 0.5
        at_b = here
        if abs(step) < 1e-12 or here == 0.0:
            break
    return b


@numba.njit(cache=True)
def roots(points, noise):
    """Every root on each of P panels, control points (P, n + 1): arrays of panel and u; panels under `noise` (P,) hold
    none. Roots that are not simple to within 2^-26 of the panel are given once.
    """
    found_panel, found_u = [0][:0], [0.0][:0]
    for panel in range(points.shape[0]):
        if np.abs(points[panel]).max() <= noise[panel] or _changes_of_sign(points[panel]) == 0:
            continue
        waiting = [(points[panel].reshape(-1, 1).copy(), -1.0, 0)]
        while len(waiting) > 0:
            piece, start, depth = waiting.pop()
            changes = _changes_of_sign(piece[:, 0])
            width = 2.0 * 0.5**depth
            if changes == 1 or (changes > 1 and depth == _DEEPEST):
                found_panel.append(panel)
                found_u.append(start + width * (_only_root(piece[:, 0]) if changes == 1 else 0.5))
            elif changes > 1:
                left, right = _halves(piece)
                waiting.append((right, start + 0.5 * width, depth + 1))
                waiting.append((left, start, depth + 1))
    return np.array(found_panel), np.array(found_u)


@numba.njit(cache=True)
def squared(series):
    """|sum_k c_k u^k|^2 of polynomials (P, K + 1), complex, as polynomials (P, 2 K + 1), real."""
    count, terms = series.shape
    product = np.zeros((count, 2 * terms - 1))
    for panel in range(count):
        for k in range(terms):
            a = series[panel, k]
            product[panel, 2 * k] += a.real * a.real + a.imag * a.imag
            for j in range(k):
                b = series[panel, j]
                product[panel, k + j] += 2.0 * (a.real * b.real + a.imag * b.imag)
    return product


@numba.njit(cache=True)
def smallest(points, slack):
    """The smallest value on P panels, control points (P, n + 1), to within `slack` of its size; its panel and u."""
    best, where, at = np.inf, 0, 0.0
    for panel in range(points.shape[0]):
        for end in (0, -1):
            if points[panel, end] < best:
                best, where, at = points[panel, end], panel, (-1.0 if end == 0 else 1.0)
    for panel in range(points.shape[0]):
        waiting = [(points[panel].reshape(-1, 1).copy(), -1.0, 0)]
        while len(waiting) > 0:
            piece, start, depth = waiting.pop()
            if piece.min() >= best - slack * abs(best) or depth == 2 * _DEEPEST:
                continue
            left, right = _halves(piece)
            middle = start + 0.5**depth
            if right[0, 0] < best:
                best, where, at = right[0, 0], panel, middle
            waiting.append((right, middle, depth + 1))
            waiting.append((left, start, depth + 1))
    return best, where, at


@numba.njit(cache=True)
def _gain(entries, p, above):
    """Largest singular value of a matrix (p, m) given row by row, or its Frobenius norm where that is not `above`."""
    square = 0.0
    for e in range(len(entries)):
        square += entries[e].real ** 2 + entries[e].imag ** 2
    frobenius = np.sqrt(square)
    if frobenius <= above or p == 1 or len(entries) == p:
        return frobenius
    return np.linalg.svd(entries.reshape(p, len(entries) // p))[1][0]


@numba.njit(cache=True)
def largest_gain(points, errors, p, best, slack):
    """The largest singular value on P panels, control points (P, n + 1, p m), errors (P,); starts from a known `best`.

    Returns a bound that none exceeds, the largest found, its panel (-1: the known one) and u. A piece is done when none
    of its control points exceeds (1 + slack) times the largest found.
    """
    bound, where, at = best, -1, 0.0
    for panel in range(points.shape[0]):
        waiting = [(points[panel].copy(), -1.0, 0)]
        while len(waiting) > 0:
            piece, start, depth = waiting.pop()
            limit = (1.0 + slack) * best - errors[panel]
            largest = 0.0
            for k in range(piece.shape[0]):
                largest = max(largest, _gain(piece[k], p, limit))
            if largest <= limit or depth == 2 * _DEEPEST:
                bound = max(bound, largest + errors[panel])
                continue
            left, right = _halves(piece)
            middle = start + 0.5**depth
            here = _gain(right[0], p, best)
            if here - errors[panel] > best:
                best, where, at = here - errors[panel], panel, middle
            waiting.append((right, middle, depth + 1))
            waiting.append((left, start, depth + 1))
    return bound, best, where, at


@numba.njit(cache=True)
def turn(points, errors):
    """Change of the phase along each of P panels, control points (P, n + 1) complex; NaN where the curve meets 0.

    A piece whose control points lie in a half plane without 0 turns by the principal value of its ends' phases.
    """
    total = np.zeros(points.shape[0])
    for panel in range(points.shape[0]):
        waiting = [(points[panel].reshape(-1, 1).copy(), 0)]
        while len(waiting) > 0:
            piece, depth = waiting.pop()
            first, last = piece[0, 0], piece[-1, 0]
            if abs(first) <= errors[panel] or abs(last) <= errors[panel]:
                total[panel] = np.nan
                break
            middle = first / abs(first) + last / abs(last)
            inside = abs(middle) > 0.0
            for k in range(piece.shape[0]):
                ahead = piece[k, 0].real * middle.real + piece[k, 0].imag * middle.imag
                inside = inside and ahead > errors[panel] * abs(middle)
            if inside:
                total[panel] += np.angle(last * np.conj(first))
                continue
            if depth == 2 * _DEEPEST:
                total[panel] = np.nan
                break
            left, right = _halves(piece)
            waiting.append((right, depth + 1))
            waiting.append((left, depth + 1))
    return total

"""Strictly proper Pade approximants [m/n], m < n, as a lossless ladder that one resistor damps."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from math import comb, factorial

import numpy as np

from flycontrol.delay.system import FloatArray
from flycontrol.errors import InvalidParameterError


@lru_cache(maxsize=64)
def damped_ladder(m: int, n: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A (n, n), B (n,), C (n,) of the [m/n] approximant P(s) / Q(s) of exp(-s), 0 <= m < n.

    Odd over even part of Q (or even over odd, whichever is proper) is 1 / (a_1 s + 1 / (a_2 s + ... + 1 / (a_n s))),
    all a_k > 0 if and only if the poles are stable (Stieltjes). So Q belongs to a ladder of n lossless storages a_k,
    driven through and damped by one resistor. Storage k answers with a polynomial N_k of degree n - k over Q, in terms
    of which P is expanded. All of this is done in fractions, exactly; states scaled to stored energy make
    A + A' = -B B', so that |C| is the H2 norm of P / Q and nothing is ill conditioned at any order.

    Raises
    ------
    InvalidParameterError
        If the approximant has unstable poles, as [0/n] from n = 5 on.
    """
    Q = _denominator(m, n)
    storages = _storages(Q)
    if min(storages) <= 0:
        raise InvalidParameterError(
            f"The [{m}/{n}] Pade approximant has unstable poles (all with at most 4 degrees between them are stable); "
            f"choose a numerator of degree {n - 4} or more."
        )
    readings = _expanded(_denominator(n, m, sign=-1), storages, Q[n])
    scale = np.array([float(a) ** -0.5 for a in storages])
    couplings = scale[:-1] * scale[1:]
    A = np.diag(couplings, -1) - np.diag(couplings, 1)
    A[0, 0] = -(scale[0] ** 2)
    B, C = np.zeros(n), np.array([float(c) for c in readings]) * scale / np.sqrt(2.0)
    B[0] = np.sqrt(2.0) * scale[0]
    for array in (A, B, C):
        array.setflags(write=False)
    return A, B, C


def _denominator(m: int, n: int, sign: int = 1) -> list[Fraction]:
    """Coefficients of s^0 .. s^n of the denominator of [m/n]; the numerator of [n/m] with sign -1."""
    return [Fraction(sign**k * comb(n, k) * factorial(m + n - k), factorial(m + n)) for k in range(n + 1)]


def _storages(Q: list[Fraction]) -> list[Fraction]:
    """a_1 .. a_n by division of one parity of Q by the other (Routh); a last one <= 0 says that Q is not Hurwitz."""
    n = len(Q) - 1
    even = [q if (n - k) % 2 == 0 else Fraction(0) for k, q in enumerate(Q)]
    odd = [q if (n - k) % 2 else Fraction(0) for k, q in enumerate(Q)]
    found: list[Fraction] = []
    for degree in range(n, 0, -1):
        if odd[degree - 1] == 0:
            return [*found, Fraction(0)]
        a = even[degree] / odd[degree - 1]
        rest = [e - (a * odd[k - 1] if k else 0) for k, e in enumerate(even)]
        even, odd = odd, rest
        found.append(a)
    return found


def _expanded(P: list[Fraction], storages: list[Fraction], leading: Fraction) -> list[Fraction]:
    """c_1 .. c_n with P = sum_k c_k N_k, where N_(k-1) = a_k s N_k + N_(k+1) and N_n = leading / (a_1 ... a_n)."""
    n = len(storages)
    polynomial = [leading]
    for a in storages:
        polynomial = [polynomial[0] / a]
    later: list[Fraction] = []
    answers = [polynomial]
    for a in reversed(storages[1:]):
        raised = [Fraction(0), *[a * c for c in polynomial]]
        for k, c in enumerate(later):
            raised[k] += c
        later, polynomial = polynomial, raised
        answers.append(polynomial)
    rest = [*P, *[Fraction(0)] * (n - len(P))]
    found: list[Fraction] = []
    for N in reversed(answers):  # degree n - 1 first
        degree = len(N) - 1
        c = rest[degree] / N[degree]
        found.append(c)
        for k, value in enumerate(N):
            rest[k] -= c * value
    return found

"""Sine and cosine of one angle together, inlined and free of branches, so that loops around them run in lanes.

x = k pi/2 + r with |r| <= pi/4, then Cephes' polynomials: absolute errors below 2.3e-16 up to a
hundred turns.
"""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.flight.kernels.vectors import INLINED

_QUARTER_TURNS = 2.0 / np.pi
_HALF_PI = 1.5707963267341256  # to 33 bits, so that its products with small integers are exact
_HALF_PI_REST = 6.077100506506192e-11


@numba.njit(**{**INLINED, "fastmath": {"contract", "nsz"}})
def sine_cosine(x):
    """(sin x, cos x)."""
    k = np.rint(x * _QUARTER_TURNS)
    r = (x - k * _HALF_PI) - k * _HALF_PI_REST
    z = r * r
    s = 1.58962301576546568060e-10 * z - 2.50507477628578072866e-8
    s = s * z + 2.75573136213857245213e-6
    s = s * z - 1.98412698295895385996e-4
    s = s * z + 8.33333333332211858878e-3
    s = s * z - 1.66666666666666307295e-1
    s = r + r * z * s
    c = -1.13585365213876817300e-11 * z + 2.08757008419747316778e-9
    c = c * z - 2.75573141792967388112e-7
    c = c * z + 2.48015872888517045348e-5
    c = c * z - 1.38888888888730564116e-3
    c = c * z + 4.16666666666665929218e-2
    c = 1.0 - 0.5 * z + z * z * c
    # k mod 4 without integers
    half = 0.5 * k
    odd = half != np.floor(half)
    quarter = 0.25 * k
    turn = quarter - np.floor(quarter)
    sine = c if odd else s
    cosine = s if odd else c
    return (-sine if turn >= 0.5 else sine), (-cosine if 0.0 < turn < 0.75 else cosine)

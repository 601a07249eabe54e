"""Transfer matrices as polynomials on panels of the imaginary axis, each with a proven bound on its error.

In one disc around s0 the states and delayed signals X(s) = M(s)^-1 F(s) have a Taylor series whose terms follow from
one inverse of M(s0). Cut after K terms it leaves a residual F - M X known in closed form, and hence an error
(I + M(s0)^-1 (M(s) - M(s0)))^-1 M(s0)^-1 (F - M X), which a contraction bounds. A panel is as long as that bound stays
below a tolerance: panels are short at a resonance and grow in proportion away from it, so that no peak, dip or
crossing falls between grid points. Every question about a frequency response is then one about polynomials, put in
Bernstein form, where control points bound them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np
import scipy.special
from numpy.typing import ArrayLike, NDArray

from flycontrol.delay.kernels import taylor
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError

_ORDER = 16
_TOLERANCE = 1e-12
MOST_PANELS = 200_000


class Blocks(NamedTuple):
    """Blocks of a `DelayLTI` as the kernels take them."""

    A: FloatArray
    B1: FloatArray
    B2: FloatArray
    C1: FloatArray
    C2: FloatArray
    D11: FloatArray
    D12: FloatArray
    D21: FloatArray
    D22: FloatArray
    tau: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Panels:
    """G(centre + half u) = sum_k series_k u^k + e, |u| <= 1, on P panels that join; |e| <= error in Frobenius norm."""

    centre: ComplexArray  #: [1/s], shape (P,)
    half: ComplexArray  #: half of each panel, along its direction [1/s], shape (P,)
    series: ComplexArray  #: shape (P, K + 1, p, m)
    error: FloatArray  #: shape (P,)

    def __len__(self) -> int:
        return len(self.error)

    @property
    def entry(self) -> ComplexArray:
        """Series of the only entry of a system with one input and one output, shape (P, K + 1)."""
        return self.series.reshape(len(self), -1)

    @property
    def control_points(self) -> ComplexArray:
        """In Bernstein form, shape (P, K + 1, p, m): G is a convex combination of them, and meets first and last."""
        return np.einsum("ik,Pkab->Piab", bernstein_matrix(self.series.shape[1] - 1), self.series)

    def points(self, panel: NDArray[np.intp], u: FloatArray) -> ComplexArray:
        """Complex frequencies at the places u of panels, shape of u [1/s]."""
        return self.centre[panel] + self.half[panel] * u


def kernel_blocks(system: DelayLTI) -> Blocks:
    """Blocks of a balanced system, writeable and contiguous so that one compiled signature serves all systems."""
    x = system
    reading = np.hstack([np.abs(x.C2), np.abs(x.D21)]).max(axis=1, initial=0.0)
    c = np.where(reading > 0, reading, 1.0)  # delayed signals of size 1
    scaled = (
        x.A, x.B1, x.B2 * c, x.C1, x.C2 / c[:, None],
        x.D11, x.D12 * c, x.D21 / c[:, None], x.D22 * c / c[:, None], x.tau,
    )  # fmt: skip
    return Blocks(*[np.array(block, order="C") for block in scaled])


def panels_along(
    blocks: Blocks, start: complex, end: complex, first: float | None = None, floor: float = 0.0
) -> Panels:
    """Panels from one complex frequency [1/s] to another; the first tries the half length `first`.

    Errors are 1e-12 of G's size on the panel, or `floor` where that is larger, and what rounding adds.

    Raises
    ------
    InvalidParameterError
        If more than `MOST_PANELS` would be needed.
    """
    first, tolerances = float(first or abs(end - start) / 8), (_TOLERANCE, float(floor))
    found = taylor.panels(blocks, complex(start), complex(end), first, _ORDER, tolerances, MOST_PANELS)
    centre, half, series, error, done = cast("tuple[ComplexArray, ComplexArray, ComplexArray, FloatArray, bool]", found)
    if not done:
        raise InvalidParameterError(
            f"The frequency response from {abs(start):.3g} to {abs(end):.3g} rad/s turns too often to be followed "
            f"({MOST_PANELS} pieces do not do); shorten the range by a larger floor or tolerance, or remove poles on "
            "the imaginary axis."
        )
    return Panels(centre, half, series, error)


def joined(parts: list[Panels]) -> Panels:
    """All panels of several stretches."""
    return Panels(
        np.concatenate([part.centre for part in parts]),
        np.concatenate([part.half for part in parts]),
        np.concatenate([part.series for part in parts]),
        np.concatenate([part.error for part in parts]),
    )


def transfer(blocks: Blocks, s: ArrayLike) -> tuple[ComplexArray, ComplexArray]:
    """G and dG/ds at complex frequencies s (k,) [1/s], shapes (k, p, m); infinite at a root of the system."""
    return taylor.values(blocks, np.ascontiguousarray(s, dtype=np.complex128))


@lru_cache(maxsize=8)
def bernstein_matrix(degree: int) -> FloatArray:
    """Control points i of u^k on [-1, 1], shape (degree + 1, degree + 1): means of products of k out of i ones and
    degree - i minus ones, so that no entry exceeds 1 and the change of basis loses nothing.
    """
    binomial = scipy.special.binom
    j = np.arange(degree + 1)
    matrix = np.empty((degree + 1, degree + 1))
    for i in range(degree + 1):
        for k in range(degree + 1):
            minus = k - j[: k + 1]
            matrix[i, k] = (binomial(i, j[: k + 1]) * binomial(degree - i, minus) * (-1.0) ** minus).sum()
            matrix[i, k] /= binomial(degree, k)
    return matrix

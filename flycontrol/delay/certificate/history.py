"""What of a delay system's past can act on it: the fewest delayed signals that carry it."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from flycontrol.delay.system import DelayLTI, FloatArray, require_retarded
from flycontrol.errors import InvalidParameterError

RationalArray = NDArray[np.object_]
_Path = tuple[Fraction, RationalArray, RationalArray]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class DelayedSignals:
    """x' = A x + B w,  w_i(t) = z_i(t - h_i),  z = C x: one group of signals for each distinct delay.

    Entries of B and C may be off by a unit in the last place where delays in a chain or a low rank made products.
    """

    A: FloatArray  #: (n, n) [1/s]
    B: FloatArray  #: (n, q)
    C: FloatArray  #: (q, n)
    sizes: tuple[int, ...]  #: signals in each group, q in all
    delays: FloatArray  #: of each group, rising [s]

    def __post_init__(self) -> None:
        for array in (self.A, self.B, self.C, self.delays):
            array.setflags(write=False)

    def each(self, of_group: FloatArray) -> FloatArray:
        """A value of each group repeated for its signals, shape (q,)."""
        return np.repeat(of_group, self.sizes)


def delayed_signals(system: DelayLTI, *, full_history: bool = False) -> DelayedSignals:
    """The signals through which the past of a system acts on it.

    A chain of delays (D22) is unrolled into paths x(t - h) with h the sum of its delays. The paths of equal h add up to
    A_d x(t - h), and A_d = B C is cut in exact rational arithmetic to as few signals as its rank; `full_history`
    keeps C = I, the whole state, instead.

    Raises
    ------
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    InvalidParameterError
        If no delayed signal acts on a state.
    """
    require_retarded(system)
    paths: dict[Fraction, list[_Path]] = {}
    for path in _paths(system):
        paths.setdefault(path[0], []).append(path)
    factors = {h: _factors(paths[h], full_history=full_history) for h in sorted(paths)}
    delays = [h for h, (columns, _) in factors.items() if columns.shape[1]]
    if not delays:
        raise InvalidParameterError(
            "No delayed signal acts on a state, so there is no delay to certify; the eigenvalues of A decide."
        )
    return DelayedSignals(
        A=system.A,
        B=np.hstack([factors[h][0] for h in delays]).astype(np.float64),
        C=np.vstack([factors[h][1] for h in delays]).astype(np.float64),
        sizes=tuple(factors[h][0].shape[1] for h in delays),
        delays=np.array(delays, dtype=np.float64),
    )


def _rational(matrix: FloatArray) -> RationalArray:
    return np.array([Fraction(float(entry)) for entry in matrix.flat], dtype=object).reshape(matrix.shape)


def _paths(system: DelayLTI) -> list[_Path]:
    """Every way (h, b, c) from the states through delays of sum h to their derivatives: x' = ... + b c x(t - h)."""
    B, C, D = _rational(system.B2), _rational(system.C2), _rational(system.D22)
    lags = [Fraction(float(tau)) for tau in system.tau]
    found: list[_Path] = []
    open_ends = [(Fraction(0), B[:, i], i) for i in range(system.n_delays)]
    while open_ends:
        before, column, i = open_ends.pop()
        lag = before + lags[i]
        found.append((lag, column, C[i]))
        open_ends += [(lag, column * D[i, j], j) for j in range(system.n_delays) if D[i, j]]
    return found


def _factors(paths: list[_Path], *, full_history: bool) -> tuple[RationalArray, RationalArray]:
    """Columns B and rows C with B C the sum of the paths' b c, exactly."""
    columns = np.stack([column for _, column, _ in paths], axis=1)
    rows = np.stack([row for _, _, row in paths])
    acting = columns @ rows
    crosses = _crosses(acting)
    rank = len(crosses)
    if full_history and rank:
        return acting, _rational(np.eye(acting.shape[1]))
    if rank == len(paths):
        return columns, rows
    n = acting.shape[0]
    empty = np.empty((n, 0), dtype=object), np.empty((0, n), dtype=object)
    return (np.stack([c for c, _ in crosses], 1), np.stack([r for _, r in crosses])) if rank else empty


def _crosses(matrix: RationalArray) -> list[tuple[RationalArray, RationalArray]]:
    """Matrix = sum of column times row, as many as its rank: elimination with complete pivoting, without rounding."""
    rest = matrix.copy()
    crosses: list[tuple[RationalArray, RationalArray]] = []
    while rest.any():
        i, j = (int(k) for k in np.unravel_index(np.argmax(np.abs(rest)), rest.shape))
        column, row = rest[:, j] / rest[i, j], rest[i].copy()
        crosses.append((column, row))
        rest = rest - np.outer(column, row)
    return crosses


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Units:
    """x = states x^,  z = signals z^: powers of two, so that a change of units rounds nothing."""

    states: FloatArray  #: (n,)
    signals: FloatArray  #: (q,)

    def of_functional(self, order: int) -> FloatArray:
        """Units of (x, zeta_0, ..., zeta_(order - 1))."""
        return np.concatenate([self.states, *[self.signals] * order])


def balancing_units(signals: DelayedSignals) -> Units:
    """Units in which rows and columns of |A| + |B| |C| are of equal size, and the entry and exit of every signal."""
    weight = np.abs(signals.A) + np.abs(signals.B) @ np.abs(signals.C)
    _, (scale, _) = scipy.linalg.matrix_balance(weight, permute=False, separate=True)
    states = np.asarray(scale, dtype=np.float64)
    arriving = np.abs(signals.B / states[:, None]).max(axis=0)
    reading = np.abs(signals.C * states).max(axis=1)
    return Units(states=states, signals=np.exp2(np.round(0.5 * np.log2(reading / arriving))))


def in_units(signals: DelayedSignals, units: Units) -> DelayedSignals:
    """The same signals with states and signals measured in other units."""
    x, z = units.states, units.signals
    return DelayedSignals(
        A=signals.A * x / x[:, None], B=signals.B * z / x[:, None], C=signals.C * x / z[:, None],
        sizes=signals.sizes, delays=signals.delays,
    )  # fmt: skip

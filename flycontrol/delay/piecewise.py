"""Piecewise polynomials of time: inputs, and histories of delayed signals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from flycontrol.delay.kernels import march as kernels
from flycontrol.delay.real import real_array, require_callable
from flycontrol.delay.system import FloatArray
from flycontrol.errors import InvalidParameterError

LARGEST_DEGREE = 9  # what collocation at ten nodes takes in exactly
_MOST_PIECES = 4096
_SHORTEST = 1e-9  # of the range: a kink looks smooth once its pieces are small enough to hide it in rounding


@dataclass(frozen=True, slots=True, eq=False)
class PiecewisePolynomial:
    """m signals, polynomials of degree at most 9 on pieces that join; at a join the later piece holds.

    Raises
    ------
    InvalidParameterError
        If pieces do not rise and join, shapes do not fit, the degree is over 9, or anything is not finite.
    """

    starts: FloatArray  #: start of each piece [s], shape (k,)
    lengths: FloatArray  #: length of each piece [s], shape (k,)
    series: FloatArray  #: Chebyshev coefficients, shape (k, m, degree + 1)

    def __post_init__(self) -> None:
        k, shape = len(self.starts), self.series.shape
        if not (k > 0 and self.lengths.shape == (k,) and len(shape) == 3 and shape[0] == k):
            raise InvalidParameterError(
                "A piecewise polynomial needs starts (k,), lengths (k,) and series (k, m, degree + 1), got shapes "
                f"{self.starts.shape}, {self.lengths.shape} and {shape}."
            )
        if not 1 <= shape[2] <= LARGEST_DEGREE + 1:
            raise InvalidParameterError(
                f"Pieces must be polynomials of degree 0 to {LARGEST_DEGREE}, got {shape[2] - 1}; split them, or let "
                "`fitted` do so."
            )
        if not all(np.isfinite(values).all() for values in (self.starts, self.lengths, self.series)):
            raise InvalidParameterError("A piecewise polynomial must be finite.")
        ends = self.starts + self.lengths
        if not ((self.lengths > 0).all() and np.allclose(ends[:-1], self.starts[1:], rtol=0, atol=1e-9 * np.ptp(ends))):
            raise InvalidParameterError("Pieces must have lengths > 0 s and each must start where the last one ends.")

    @property
    def end(self) -> float:
        """End of the last piece [s]."""
        return float(self.starts[-1] + self.lengths[-1])

    def __call__(self, times: ArrayLike) -> FloatArray:
        """Values (m, len(times)) at non-decreasing times [s]; end pieces continue beyond their ends."""
        t = np.atleast_1d(np.asarray(times, dtype=np.float64))
        return kernels.sample(self.starts.copy(), self.lengths.copy(), np.ascontiguousarray(self.series), t)


def piecewise_polynomial(edges: ArrayLike, coefficients: ArrayLike) -> PiecewisePolynomial:
    """sum_j coefficients[k, :, j] (t - edges[k])^j on the piece from edges[k] to edges[k + 1].

    Parameters
    ----------
    edges
        Edges [s], k + 1 of them, rising; the last one ends the last piece.
    coefficients
        Shape (k, m, degree + 1), rising powers; j-th ones in units of the signal per s^j.

    Raises
    ------
    InvalidParameterError
        As `PiecewisePolynomial`.
    """
    t, powers = real_array(edges, "Edges [s]"), real_array(coefficients, "Coefficients")
    lengths = np.diff(t)
    if powers.ndim != 3 or len(powers) != len(lengths):
        raise InvalidParameterError(
            f"Coefficients must have shape (k, m, degree + 1) with k + 1 edges; got {powers.shape} and {len(t)} edges."
        )
    scaled = powers * (lengths[:, None, None] / 2) ** np.arange(powers.shape[2])
    basis = np.zeros((powers.shape[2], powers.shape[2]))  # (1 + x)^j in Chebyshev polynomials
    power = np.ones(1)
    for j in range(powers.shape[2]):
        basis[j, : j + 1] = power
        power = chebyshev.chebmul(power, [1.0, 1.0])
    return PiecewisePolynomial(t[:-1].copy(), lengths, scaled @ basis)


def sampled(times: ArrayLike, samples: ArrayLike, hold: Literal["linear", "zero"] = "linear") -> PiecewisePolynomial:
    """Samples (m, k) or (k,) at rising times (k,) [s], joined by lines or held until the next; every sample is a kink.

    Samples on one line, or alike when held, share a piece, so that a long record with few changes costs little.

    Raises
    ------
    InvalidParameterError
        If shapes do not fit, times do not rise, or anything is not finite.
    """
    t, values = real_array(times, "Times of samples [s]"), real_array(samples, "Samples", 2)
    if t.ndim != 1 or len(t) < 2 or values.shape[1:] != t.shape or not np.isfinite(values).all():
        raise InvalidParameterError(
            f"Samples must be finite with one column for each of at least 2 times, got shape {values.shape} and times "
            f"of shape {t.shape}."
        )
    if not (np.diff(t) > 0).all():
        raise InvalidParameterError("Times of samples must rise.")
    if hold not in ("linear", "zero"):
        raise InvalidParameterError(f"hold must be 'linear' or 'zero', got {hold!r}.")
    slopes = np.diff(values) / np.diff(t) if hold == "linear" else np.zeros((len(values), len(t) - 1))
    repeats = (slopes[:, 1:] == slopes[:, :-1]).all(axis=0)
    if hold == "zero":
        repeats &= (values[:, 1:-1] == values[:, :-2]).all(axis=0)
    kept = np.append(True, ~repeats)
    coefficients = np.stack([values[:, :-1], slopes], axis=2).transpose(1, 0, 2)[kept]
    return piecewise_polynomial(np.append(t[:-1][kept], t[-1]), coefficients)


def fitted(function: Callable[[float], ArrayLike], breaks: Sequence[float] | FloatArray) -> PiecewisePolynomial:
    """A function t -> (m,) as polynomials of degree 9, pieces halved until their last coefficients are rounding.

    Parameters
    ----------
    breaks
        Rising times [s]: the ends of the range, and every kink or jump between them.

    Raises
    ------
    InvalidParameterError
        If the function does not become smooth: a kink or jump is missing in `breaks`.
    """
    require_callable(function, "What is fitted")
    marks = real_array(breaks, "Breaks [s]")
    if not (marks.ndim == 1 and len(marks) > 1 and (np.diff(marks) > 0).all()):
        raise InvalidParameterError(f"Breaks must be at least 2 rising times [s], got {marks.tolist()!r}.")
    x = np.cos(np.pi * (np.arange(LARGEST_DEGREE + 1) + 0.5) / (LARGEST_DEGREE + 1))[::-1]
    to_series = np.linalg.inv(chebyshev.chebvander(x, LARGEST_DEGREE))
    todo = list(zip(marks[-2::-1].tolist(), marks[:0:-1].tolist(), strict=True))
    done: list[tuple[float, float, FloatArray]] = []
    scale = 0.0
    while todo:
        a, b = todo.pop()
        values = np.array(
            [np.atleast_1d(function(float(a + (b - a) * (1 + node) / 2))) for node in x], dtype=np.float64
        )
        scale = max(scale, float(np.abs(values).max(initial=0.0)))
        series = (to_series @ values).T
        if np.abs(series[:, -2:]).max(initial=0.0) <= 1e-14 * scale:
            done.append((a, b - a, series))
        elif len(todo) + len(done) >= _MOST_PIECES or b - a <= _SHORTEST * (marks[-1] - marks[0]):
            raise InvalidParameterError(
                f"The function is not smooth near {a:g} s; give that time in `breaks` if it has a kink or a jump there."
            )
        else:
            todo += [((a + b) / 2, b), (a, (a + b) / 2)]
    starts, lengths, coefficients = zip(*done, strict=True)
    return PiecewisePolynomial(np.array(starts), np.array(lengths), np.array(coefficients))

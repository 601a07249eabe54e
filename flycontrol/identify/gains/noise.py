"""Residuals of a fit as autoregressive noise: order by BIC, coefficients by restricted likelihood.

    e_t = phi_1 e_(t-1) + ... + phi_q e_(t-q) + innovation,

held stationary through its partial autocorrelations r_j = tanh z_j. The restricted likelihood projects out what the
model's derivatives can explain, so that the innovations' variance is not underestimated. After a gap the noise begins
anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.identify.gains.kernels import noise as kernels

FloatArray = NDArray[np.float64]
_TIGHT = 4.0  #: largest |z|: a partial autocorrelation of 0.9993
_LARGEST = float(np.tanh(_TIGHT))
_STEP = 1e-3  #: of differences in z
_MOST_STEPS = 20


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """Noise of one channel of one trial."""

    deviation: float  #: standard deviation of the innovations, in the channel's unit
    pacf: FloatArray  #: partial autocorrelations (q,); empty for white noise
    uncertainty: (
        FloatArray  #: covariance of (log variance, z) (1 + q, 1 + q), from the restricted likelihood's curvature
    )

    @property
    def order(self) -> int:
        """Number q of coefficients."""
        return len(self.pacf)

    @property
    def coefficients(self) -> FloatArray:
        """phi (q,)."""
        table = np.zeros((self.order, self.order))
        kernels.coefficients(self.pacf, table)
        return table[-1] if self.order else np.zeros(0)

    @property
    def standard_deviation(self) -> float:
        """Of the noise itself, in the channel's unit."""
        return float(self.deviation / np.sqrt(np.prod(1.0 - self.pacf**2)))


def white(deviation: float, freedom: float) -> Noise:
    """White noise whose variance was estimated with so many degrees of freedom."""
    return Noise(deviation, np.zeros(0), np.array([[2.0 / max(freedom, 1.0)]]))


def whitened(rows: FloatArray, firsts: NDArray[np.int64], noise: Noise) -> FloatArray:
    """Rows (c, n) as multiples of the innovations' standard deviation, uncorrelated if the noise is as described."""
    if noise.order == 0:
        return rows / noise.deviation
    out = np.empty_like(rows)
    kernels.whitened(rows, firsts, noise.pacf, out)
    out /= noise.deviation
    return out


def estimate(rows: FloatArray, firsts: NDArray[np.int64], order: int) -> Noise:
    """Noise of a given order by restricted maximum likelihood, Newton steps from Burg's coefficients.

    Parameters
    ----------
    rows
        (1 + p, n): residuals, then the model's derivatives with respect to its p parameters.
    firsts
        Indices at which stretches without gap begin.
    """
    size = np.maximum(np.sqrt(np.mean(rows**2, axis=1)), 1e-300)
    likelihood = _Likelihood(np.ascontiguousarray(rows / size[:, None]), firsts, order)
    freedom = max(rows.shape[1] - rows.shape[0] + 1, 1)
    if order == 0:
        _, variance = likelihood(np.zeros(0))
        return white(float(size[0] * np.sqrt(variance)), freedom)
    z, curvature = _maximum(likelihood, np.arctanh(burg(rows[0], firsts, order)))
    (_, variance), slope = likelihood(z), likelihood.slope_of_variance(z)
    information = np.empty((1 + order, 1 + order))
    information[0, 0] = freedom / 2
    information[0, 1:] = information[1:, 0] = -freedom / 2 * slope
    information[1:, 1:] = curvature / 2 + freedom / 2 * np.outer(slope, slope)
    uncertainty: FloatArray = np.asarray(np.linalg.pinv(information, hermitian=True), dtype=np.float64)
    return Noise(float(size[0] * np.sqrt(variance)), np.tanh(z), uncertainty)


class _Likelihood:
    """Minus twice the restricted log likelihood of z, and the innovations' variance."""

    def __init__(self, rows: FloatArray, firsts: NDArray[np.int64], order: int) -> None:
        self.products, self.samples = kernels.lagged(rows, firsts, order), rows.shape[1]

    def __call__(self, z: FloatArray) -> tuple[float, float]:
        value, variance = kernels.restricted(*self.products, self.samples, np.tanh(z))
        return float(value), float(variance)

    def slope_of_variance(self, z: FloatArray) -> FloatArray:
        """d log variance / dz (q,), by central differences."""
        steps = _STEP * np.eye(len(z))
        return np.array([np.log(self(z + h)[1] / self(z - h)[1]) for h in steps]) / (2 * _STEP)


def _maximum(likelihood: _Likelihood, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The z (q,) of largest likelihood and the curvature of minus twice its logarithm there."""
    z = np.clip(z, -_TIGHT, _TIGHT)
    best = likelihood(z)[0]
    curvature = np.eye(len(z))
    for _ in range(_MOST_STEPS):
        gradient, curvature = _derivatives(likelihood, z, best)
        values, vectors = np.linalg.eigh(curvature)
        step = -vectors @ ((vectors.T @ gradient) / np.maximum(np.abs(values), 1.0))
        step /= max(1.0, float(np.abs(step).max()))
        trial, reached = z, np.inf
        for halving in range(6):
            trial = np.clip(z + 0.5**halving * step, -_TIGHT, _TIGHT)
            reached = likelihood(trial)[0]
            if reached <= best:
                break
        if not reached < best - 1e-4:  # a ten-thousandth of a unit of likelihood moves no interval
            break
        z, best = trial, reached
    return z, curvature


def _derivatives(likelihood: _Likelihood, z: FloatArray, centre: float) -> tuple[FloatArray, FloatArray]:
    """Gradient (q,) and curvature (q, q) by differences."""
    q, steps = len(z), _STEP * np.eye(len(z))
    ahead = np.array([likelihood(z + h)[0] for h in steps])
    behind = np.array([likelihood(z - h)[0] for h in steps])
    curvature = np.diag(ahead + behind - 2 * centre)
    for i in range(q):
        for j in range(i):
            corner = likelihood(z + steps[i] + steps[j])[0]
            curvature[i, j] = curvature[j, i] = corner - ahead[i] - ahead[j] + centre
    return (ahead - behind) / (2 * _STEP), curvature / _STEP**2


def burg(residuals: FloatArray, firsts: NDArray[np.int64], order: int) -> FloatArray:
    """Partial autocorrelations (order,) by Burg's recursion over the stretches without gap."""
    return np.array(list(_burg(residuals, firsts, order)) or [0.0] * order)


def order_by_bic(residuals: FloatArray, firsts: NDArray[np.int64], largest: int) -> int:
    """Order of an autoregressive model, 0 to `largest`, by BIC of Burg's recursion."""
    n = len(residuals)
    gains = [n * np.log(1.0 - r * r) + np.log(n) for r in _burg(residuals, firsts, largest)]
    criterion = np.concatenate([[0.0], np.cumsum(gains)])
    return int(np.argmin(criterion))


def _burg(residuals: FloatArray, firsts: NDArray[np.int64], order: int) -> Iterator[float]:
    stretches = [part for part in np.split(residuals, firsts[1:]) if len(part) > order + 1]
    if not stretches:
        return
    forward, backward = [part[1:] for part in stretches], [part[:-1] for part in stretches]
    for _ in range(order):
        top = 2 * sum(float(f @ b) for f, b in zip(forward, backward, strict=True))
        bottom = sum(float(f @ f + b @ b) for f, b in zip(forward, backward, strict=True))
        r = float(np.clip(top / bottom if bottom else 0.0, -_LARGEST, _LARGEST))
        yield r
        moved = [(f - r * b, b - r * f) for f, b in zip(forward, backward, strict=True)]
        forward, backward = [f[1:] for f, _ in moved], [b[:-1] for _, b in moved]


def drawn(noise: Noise, firsts: NDArray[np.int64], n: int, rng: np.random.Generator) -> FloatArray:
    """Noise (n,) as described, begun anew at each stretch, in the channel's unit."""
    out = noise.deviation * rng.standard_normal(n)
    if noise.order:
        kernels.coloured(out.copy(), firsts, noise.pacf, out)
    return out

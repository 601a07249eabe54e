"""Smoothing by a parabola in a sliding window, as wide as the noise demands and the signal allows.

The value at the middle of a window is a weighted sum of its samples; its error follows from the autocorrelation of the
fitted noise. Windows at the ends are one-sided and have larger errors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.identify.gains.noise import Noise

FloatArray = NDArray[np.float64]
_FEWEST = 5  #: samples of a window
_PLACES = 24  #: samples that decide about the width


@dataclass(frozen=True, slots=True, eq=False)
class Smooth:
    """A smoothed channel at its own samples."""

    times: FloatArray  #: (n,) [s]
    values: FloatArray  #: (n,) [rad]
    errors: FloatArray  #: (n,) standard errors [rad]
    window: float  #: whole width [s]


def smoothed(times: FloatArray, values: FloatArray, noise: Noise, wanted: float, widest: float) -> Smooth:
    """Smooth samples (n,) at increasing times (n,) by the narrowest window that makes errors as small as wanted.

    Parameters
    ----------
    noise
        Of the samples.
    wanted
        Standard error in the middle of the channel [rad].
    widest
        Window that no noise justifies to exceed [s].

    Raises
    ------
    InvalidInputError
        If there are fewer than five samples.
    """
    if len(times) < _FEWEST:
        raise InvalidInputError(f"Smoothing needs at least {_FEWEST} samples, got {len(times)}.")
    step = float(np.median(np.diff(times)))
    smallest, largest = step * (_FEWEST // 2), max(widest / 2, step * (_FEWEST // 2))
    half, middle = largest, np.linspace(0, len(times) - 1, _PLACES + 2).astype(np.int64)[1:-1]
    for narrow in np.geomspace(smallest, largest, 12):
        windows = _Windows(times, noise, step, float(narrow))
        if np.median([windows.at(int(i))[2] for i in middle]) <= wanted:
            half = float(narrow)
            break
    windows = _Windows(times, noise, step, half)
    found = np.empty((len(times), 2))
    for i in range(len(times)):
        window, weights, error = windows.at(i)
        found[i] = weights @ values[window], error
    return Smooth(times, found[:, 0], found[:, 1], 2 * half)


class _Windows:
    """Weights of the samples around each sample; where samples are alike spaced they are computed once."""

    def __init__(self, times: FloatArray, noise: Noise, step: float, half: float) -> None:
        self.times, self.step, self.half = times, step, half
        self.lagged = autocovariance(noise, int(2 * half / step) + 4 * _FEWEST)
        self.known: dict[bytes, tuple[FloatArray, float]] = {}

    def at(self, i: int) -> tuple[slice, FloatArray, float]:
        """Window of sample i, weights of its samples, standard error; at the ends the window stays whole."""
        t, half = self.times, self.half + 1e-6 * self.step
        centre = np.clip(t[i], t[0] + self.half, max(t[-1] - self.half, t[0] + self.half))
        first, last = np.searchsorted(t, [centre - half, centre + half])
        if last - first < _FEWEST:  # a gap
            first = min(max(i - _FEWEST // 2, 0), len(t) - _FEWEST)
            last = first + _FEWEST
        places = np.rint((t[first:last] - t[i]) / self.step).astype(np.int64)
        key = places.tobytes()
        if key not in self.known:
            self.known[key] = self._weighed(places)
        return slice(int(first), int(last)), *self.known[key]

    def _weighed(self, places: NDArray[np.int64]) -> tuple[FloatArray, float]:
        x = places / max(float(np.abs(places).max()), 1.0)
        weights = np.linalg.pinv(np.column_stack([np.ones_like(x), x, x * x]))[0]
        apart = np.abs(places - places[:, None])
        covariance = np.where(apart < len(self.lagged), self.lagged[np.minimum(apart, len(self.lagged) - 1)], 0.0)
        return weights, float(np.sqrt(max(weights @ covariance @ weights, 0.0)))


def autocovariance(noise: Noise, count: int) -> FloatArray:
    """Covariance of samples 0, 1, ..., count - 1 apart [rad^2]."""
    variance, phi = noise.standard_deviation**2, noise.coefficients
    q = noise.order
    if q == 0:
        return variance * (np.arange(count) == 0)
    # Yule-Walker: r_k = sum of phi_j r_|k - j| for k = 1 to q, r_0 = 1
    system = np.eye(q)
    known = np.zeros(q)
    for k in range(1, q + 1):
        for j in range(1, q + 1):
            if k == j:
                known[k - 1] += phi[j - 1]
            else:
                system[k - 1, abs(k - j) - 1] -= phi[j - 1]
    r = np.zeros(max(count, q + 1))
    r[0], r[1 : q + 1] = 1.0, np.linalg.solve(system, known)
    for k in range(q + 1, count):
        r[k] = phi @ r[k - q : k][::-1]
    return variance * r[:count]

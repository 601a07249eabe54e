"""Lens distortion by Brown's polynomial, in the form of OpenCV and anipose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError

FloatArray = NDArray[np.float64]

_ROUNDS = 200  #: of the fixed-point iteration; it gains a digit in a few where a lens is usable
_CONVERGED = 1e-12  #: change of a normalised coordinate


@dataclass(frozen=True, slots=True, kw_only=True)
class Distortion:
    """x_d = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), y_d likewise with p1, p2 swapped.

    x = (u - c_u) / f_u, y = (v - c_v) / f_v, r^2 = x^2 + y^2.
    """

    focal: tuple[float, float]  #: f_u, f_v [px]
    centre: tuple[float, float]  #: c_u, c_v, zero-based [px]
    radial: tuple[float, float, float] = (0.0, 0.0, 0.0)  #: k1, k2, k3
    tangential: tuple[float, float] = (0.0, 0.0)  #: p1, p2

    def __post_init__(self) -> None:
        numbers = np.array([*self.focal, *self.centre, *self.radial, *self.tangential])
        if not (numbers.shape == (9,) and np.all(np.isfinite(numbers)) and self.focal[0] and self.focal[1]):
            raise InvalidParameterError(
                "Distortion needs two focal lengths other than 0, a centre of two, three radial and two tangential "
                f"coefficients, all finite; got {self!r}."
            )

    def distorted(self, pixels: FloatArray) -> FloatArray:
        """Where the lens puts what an ideal camera would see at `pixels`; both (N, 2) [px]."""
        x = (pixels - self.centre) / self.focal
        return np.asarray((x * self._gain(x) + self._shift(x)) * self.focal + self.centre)

    def undistorted(self, pixels: FloatArray) -> FloatArray:
        """Inverse of `distorted`, both (N, 2) [px]; NaN where the polynomial folds and has no inverse nearby."""
        seen = (pixels - self.centre) / self.focal
        x = before = seen
        with np.errstate(all="ignore"):
            for _ in range(_ROUNDS):
                x, before = (seen - self._shift(x)) / self._gain(x), x
                if not np.any(np.abs(x - before) > _CONVERGED):
                    break
            found = np.all(np.abs(x - before) <= _CONVERGED, axis=1, keepdims=True)
        return np.where(found, x * self.focal + self.centre, np.nan)

    def _gain(self, x: FloatArray) -> FloatArray:
        k1, k2, k3 = self.radial
        r2 = np.sum(x * x, axis=1, keepdims=True)
        return 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))

    def _shift(self, x: FloatArray) -> FloatArray:
        p1, p2 = self.tangential
        r2, xy = np.sum(x * x, axis=1), x[:, 0] * x[:, 1]
        along_u = 2 * p1 * xy + p2 * (r2 + 2 * x[:, 0] ** 2)
        along_v = 2 * p2 * xy + p1 * (r2 + 2 * x[:, 1] ** 2)
        return np.stack([along_u, along_v], axis=1)

"""A delay line: what was written at every step, read at any time before, with its derivatives.

Between steps it is the cubic through values and rates, so that reading costs h^4 / 384 max |v''''|, h the step: at 200
steps a wingbeat 3e-9 of an oscillation at the wingbeat frequency.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class DelayLine:
    """Holds a signal from time 0 on; before it, the signal was as at the beginning."""

    def __init__(self, step: float, instants: int) -> None:
        """
        Make an empty line.

        Parameters
        ----------
        step : between what is written [s]
        instants : that it has room for
        """
        self.step = step
        self._values, self._rates = np.zeros(instants), np.zeros(instants)
        self._written = 0

    def write(self, first: int, values: FloatArray, rates: FloatArray) -> None:
        """Write values (n,) and their rates (n,) at the instants from `first` on."""
        self._written = first + len(values)
        self._values[first : self._written], self._rates[first : self._written] = values, rates

    def read(self, time: FloatArray) -> FloatArray:
        """Value, rate and its rate, (3, N), at times (N,) [s] up to the last one written."""
        h = self.step
        at = np.clip(time / h, 0.0, None)
        k = np.minimum(at.astype(np.int64), max(self._written - 2, 0))
        s = at - k
        v0, v1 = self._values[k], self._values[k + 1]
        r0, r1 = h * self._rates[k], h * self._rates[k + 1]
        square, cube = 3 * (v1 - v0) - 2 * r0 - r1, 2 * (v0 - v1) + r0 + r1
        found = np.stack([
            v0 + s * (r0 + s * (square + s * cube)),
            (r0 + s * (2 * square + 3 * s * cube)) / h,
            (2 * square + 6 * s * cube) / h**2,
        ])  # fmt: skip
        found[1:, time < 0] = 0.0
        return found

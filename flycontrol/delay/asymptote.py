"""What a transfer matrix of retarded type comes to at high frequencies, and a bound on how soon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.delay.system import DelayLTI, FloatArray, require_retarded


@dataclass(frozen=True, slots=True, eq=False)
class Asymptote:
    """|G(s) - D(s)| <= C (|s| I - A)^-1 B entry by entry for Re s >= 0 and |s| above the Perron root of A.

    D(s) is the feedthrough, delayed or not; A, B and C bound the sizes of what the states are driven by and read with.
    """

    A: FloatArray  #: |A| + |B2| chain |C2|, shape (n, n)
    B: FloatArray  #: |B1| + |B2| chain |D21|, shape (n, m)
    C: FloatArray  #: |C1| + |D12| chain |C2|, shape (p, n)
    undelayed: FloatArray  #: D11, shape (p, m)
    delayed: FloatArray  #: a bound on the feedthrough through delays, entry by entry, shape (p, m)
    slowest: float  #: the Perron root of A [1/s]

    def rest(self, size: float) -> float:
        """Bound on the Frobenius norm of G - D for |s| >= size [1/s]; inf where there is none."""
        if len(self.A) == 0:
            return 0.0
        if size <= self.slowest * (1 + 1e-9):
            return np.inf
        return float(np.linalg.norm(self.C @ np.linalg.solve(size * np.eye(len(self.A)) - self.A, self.B)))

    def beyond(self, level: float) -> float:
        """A frequency [rad/s] from which on the Frobenius norm of G - D stays below `level`, little larger than needed.

        `level` must be > 0.
        """
        low = max(self.slowest, 1e-300)
        if len(self.A) == 0 or not (self.B.any() and self.C.any()):
            return low
        high = 2.0 * low + 1e-6 * float(np.linalg.norm(self.B) * np.linalg.norm(self.C))
        while self.rest(high) > level:
            low, high = high, 4.0 * high
        for _ in range(6):
            middle = float(np.sqrt(low * high))
            low, high = (low, middle) if self.rest(middle) <= level else (middle, high)
        return float(high)


def asymptote(system: DelayLTI) -> Asymptote:
    """The `Asymptote` of a balanced system.

    Raises
    ------
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    require_retarded(system)
    x = system
    chain = np.linalg.inv(np.eye(x.n_delays) - np.abs(x.D22)).astype(np.float64)
    A: FloatArray = np.abs(x.A) + np.abs(x.B2) @ chain @ np.abs(x.C2)
    B: FloatArray = np.abs(x.B1) + np.abs(x.B2) @ chain @ np.abs(x.D21)
    C: FloatArray = np.abs(x.C1) + np.abs(x.D12) @ chain @ np.abs(x.C2)
    delayed: FloatArray = np.abs(x.D12) @ chain @ np.abs(x.D21)
    slowest = float(np.abs(np.linalg.eigvals(A)).max(initial=0.0))
    return Asymptote(A, B, C, x.D11, delayed, slowest)

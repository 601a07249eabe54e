"""How well two series of wingbeats agree: correlation and slope, with intervals that respect their memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.identify.yaw_plant import Estimate
from flycontrol.model.resampling import wrapped_blocks

FloatArray = NDArray[np.float64]

SEED = 20101020
BLOCK = 5  #: wingbeats that the bootstrap keeps together
RESAMPLES = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement:
    """Supplied against required, means of each flight taken out; 95 % intervals by a moving-block bootstrap.

    Where the supplied series carries the noise (forces of tracked wings) and the required one hardly any, noise lowers
    the correlation and the slope of required on supplied, and leaves the slope of supplied on required as it is.
    """

    correlation: Estimate  #: Pearson's
    slope: Estimate  #: least squares of supplied on required
    slope_of_required: Estimate  #: least squares of required on supplied
    wingbeats: int


def agreement(
    supplied: Sequence[FloatArray], required: Sequence[FloatArray], block: int = BLOCK, seed: int = SEED
) -> Agreement:
    """Pool one or more flights, blocks drawn within each flight.

    Parameters
    ----------
    supplied, required
        One array (n,) for each flight, any unit.
    block
        Wingbeats kept together.
    seed
        Of the bootstrap.

    Raises
    ------
    InvalidInputError
        Series do not match, or a flight has fewer than three wingbeats.
    """
    for s, r in zip(supplied, required, strict=True):
        if s.shape != r.shape or s.ndim != 1 or len(s) < 3:
            raise InvalidInputError(
                f"Agreement needs equally long series of at least 3 wingbeats, got shapes {s.shape} and {r.shape}."
            )
    rng = np.random.default_rng(seed)
    pairs = [np.stack([s, r], axis=1) for s, r in zip(supplied, required, strict=True)]
    drawn = [
        _moments([p[wrapped_blocks(len(p), block, RESAMPLES, rng)] for p in pairs]),
        _moments([p[None] for p in pairs]),
    ]
    resampled, as_is = (_measures(m) for m in drawn)
    low, high = np.quantile(resampled, [0.025, 0.975], axis=1)
    correlation, slope, slope_of_required = (
        Estimate(value=float(value[0]), low=float(a), high=float(b))
        for value, a, b in zip(as_is, low, high, strict=True)
    )
    return Agreement(
        correlation=correlation, slope=slope, slope_of_required=slope_of_required, wingbeats=sum(map(len, pairs))
    )


def _moments(flights: list[FloatArray]) -> FloatArray:
    """(3, draws) sums of squares and products about each flight's mean, from arrays (draws, n, 2)."""
    centred = [f - f.mean(axis=1, keepdims=True) for f in flights]
    sums = [np.stack([np.sum(c[..., a] * c[..., b], axis=1) for a, b in ((0, 0), (1, 1), (0, 1))]) for c in centred]
    return np.sum(sums, axis=0)


def _measures(moments: FloatArray) -> FloatArray:
    """(3, draws) correlation, slope of the first on the second, of the second on the first."""
    ss, rr, sr = moments
    return np.stack([sr / np.sqrt(ss * rr), sr / rr, sr / ss])

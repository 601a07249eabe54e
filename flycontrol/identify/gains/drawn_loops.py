"""Loops that the data allow as well as the fitted one: draws of gains, damping and delay from a fit's distribution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.identify.gains.result import FitResult
from flycontrol.model.yaw import YawLoop

FloatArray = NDArray[np.float64]
LOOP = ("damping", "kp", "kd", "delay", "ki")  #: [1/s], [1/s^2], [1/s], [s], [1/s^3]


def drawn_loops(found: FitResult, draws: int, seed: int) -> FloatArray:
    """Loops (draws, 5) in the order of `LOOP`, inside the bounds: Student's distribution with the fit's covariance.

    It has the smallest of the unknowns' degrees of freedom.

    Raises
    ------
    InvalidInputError
        If a gain, the delay or the damping is not determined, or not shared by all recordings.
    """
    names = found.problem.names
    apart = [name for name in LOOP if name in found.problem.kinds and name not in names]
    if apart:
        raise InvalidInputError(f"The recordings do not share {' and '.join(apart)}; draw the loops of one fly alone.")
    asked = [name for name in LOOP if name in names]
    places = [names.index(name) for name in asked]
    C = found.covariance[places][:, places]
    lost = [name for name, variance in zip(asked, np.diag(C), strict=True) if not np.isfinite(variance)]
    if lost:
        raise InvalidInputError(
            f"{' and '.join(lost)} is not determined by this fit; fix it, or carry a bootstrap into the loop instead."
        )
    rng = np.random.default_rng(seed)
    size = np.sqrt(np.diag(C))  # gains and delays differ by five orders, so the root is taken of correlations
    values, vectors = np.linalg.eigh(C / np.outer(size, size))
    root = size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    freedom = float(found.uncertainty.freedom[places].min(initial=np.inf))
    wide = np.sqrt(freedom / rng.chisquare(freedom, draws)) if np.isfinite(freedom) else np.ones(draws)
    x = np.tile([e.value for e in found.estimates], (draws, 1))
    x[:, places] += (rng.standard_normal((draws, len(places))) * wide[:, None]) @ root.T
    return loops_of(found, x)


def loops_of(found: FitResult, x: FloatArray) -> FloatArray:
    """Loops (b, 5) in the order of `LOOP` of vectors of unknowns (b, k), inside the bounds."""
    names, x = found.problem.names, np.clip(x, found.problem.low, found.problem.high)
    return np.column_stack(
        [x[:, names.index(name)] if name in names else np.full(len(x), found.value(name)) for name in LOOP]
    )


def yaw_loops(loops: FloatArray) -> list[YawLoop]:
    """The same as `YawLoop`s of unit inertia."""
    return [YawLoop.from_rates(b=b, kp=kp, kd=kd, delay=delay, ki=ki) for b, kp, kd, delay, ki in loops.tolist()]

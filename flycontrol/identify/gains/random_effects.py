"""How much flies differ: theta_i = mean + u_i + e_i, u_i of variance tau^2 between flies, e_i of known variance v_i.

tau^2 is estimated by restricted likelihood; its interval inverts Q(tau^2) = sum (theta_i - mean)^2 / (v_i + tau^2),
which follows chi^2 with m - 1 degrees of freedom (Viechtbauer 2007, Statistics in Medicine 26, 37-52); the mean's
interval uses Student's t with Hartung and Knapp's variance, where that is the larger one (Roever, Knapp & Friede 2015,
BMC Medical Research Methodology 15, 99).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.optimize
import scipy.stats
from numpy.typing import ArrayLike, NDArray

from flycontrol.delay.bracket import bracketed_root
from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.identify.gains.alone import LoneFit
from flycontrol.identify.gains.response import UNITS

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RandomEffects:
    """Mean and spread of one parameter between flies."""

    kind: str  #: "kp"
    unit: str
    count: int  #: flies, or recordings
    mean: float
    mean_low: float  #: of the mean's interval
    mean_high: float
    deviation: float  #: tau, between flies, by restricted likelihood
    deviation_low: float
    deviation_high: float  #: infinite where so few flies say nothing
    p: float  #: of Cochran's test that tau = 0


def random_effects(alone: Sequence[LoneFit], kind: str, level: float = 0.95) -> RandomEffects:
    """Summarise one shared unknown over flies or recordings fitted alone; those that are not usable are left out.

    Raises
    ------
    InvalidInputError
        If fewer than two fits are usable.
    InvalidParameterError
        If the level is outside of (0, 1).
    """
    usable = [fit for fit in alone if fit.usable]
    values = [fit.estimate(kind) for fit in usable]
    return spread(kind, values, [fit.standard_error(kind) for fit in usable], level)


def spread(kind: str, values: ArrayLike, errors: ArrayLike, level: float = 0.95) -> RandomEffects:
    """Summarise estimates (m,) with standard errors (m,) of one parameter.

    Raises
    ------
    InvalidInputError
        If there are fewer than two.
    InvalidParameterError
        If the level is outside of (0, 1).
    """
    theta, v = np.asarray(values, dtype=np.float64), np.asarray(errors, dtype=np.float64) ** 2
    m = len(theta)
    if m < 2:
        raise InvalidInputError(f"The spread of {kind} needs at least two fits that converged, got {m}.")
    if not 0 < level < 1:
        raise InvalidParameterError(f"The level of intervals must lie between 0 and 1, got {level!r}.")
    tau2 = _restricted_maximum(theta, v)
    mean, Q = _pooled(theta, v, tau2)
    width = scipy.stats.t.isf((1 - level) / 2, m - 1) * np.sqrt(max(Q / (m - 1), 1.0) / np.sum(1 / (v + tau2)))
    low, high = (_variance_where(theta, v, float(scipy.stats.chi2.isf(tail, m - 1))) for tail in _tails(level))
    return RandomEffects(
        kind=kind, unit=UNITS.get(kind, ""), count=m, mean=mean, mean_low=float(mean - width),
        mean_high=float(mean + width), deviation=float(np.sqrt(tau2)), deviation_low=float(np.sqrt(low)),
        deviation_high=float(np.sqrt(high)), p=float(scipy.stats.chi2.sf(_pooled(theta, v, 0.0)[1], m - 1)),
    )  # fmt: skip


def _tails(level: float) -> tuple[float, float]:
    return (1 - level) / 2, (1 + level) / 2


def _pooled(theta: FloatArray, v: FloatArray, tau2: float) -> tuple[float, float]:
    """Weighted mean and Q at tau^2."""
    w = 1 / (v + tau2)
    mean = float(w @ theta / w.sum())
    return mean, float(w @ (theta - mean) ** 2)


def _restricted_maximum(theta: FloatArray, v: FloatArray) -> float:
    """tau^2 of largest restricted likelihood, zero included."""

    def minus_twice_log(tau2: float) -> float:
        w = 1 / (v + tau2)
        return float(-np.log(w).sum() + np.log(w.sum()) + _pooled(theta, v, tau2)[1])

    roof = float(10 * np.var(theta) + v.min())  # beyond it Q < m / 10, far from the maximum
    found: Any = scipy.optimize.minimize_scalar(
        lambda r: minus_twice_log(r * r),
        bounds=(0.0, np.sqrt(roof)),
        method="bounded",
        options={"xatol": 1e-10 * np.sqrt(roof)},
    )
    best = float(found.x) ** 2
    return best if minus_twice_log(best) < minus_twice_log(0.0) else 0.0


def _variance_where(theta: FloatArray, v: FloatArray, wanted: float) -> float:
    """tau^2 at which Q, which falls with tau^2, has the value wanted; 0 where it is smaller from the start."""

    def excess(tau2: float) -> float:
        return _pooled(theta, v, tau2)[1] - wanted

    if excess(0.0) <= 0:
        return 0.0
    high = float(np.var(theta) + v.max())
    while excess(high) > 0:
        high *= 4
    return bracketed_root(excess, 0.0, high)

"""Recordings whose gains are not those of the others, named.

    d_i = theta_i - mean of the others,    p_i: d_i^T (C_i + C_others + diag tau^2)^-1 d_i / k ~ F(k, f_i),

k shared unknowns, C covariances, tau the spread between recordings that half of them have for sure (from the median of
squared deviations, so that a few outliers do not hide each other). The mean is that of all that are not outliers; p is
multiplied by the number of recordings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy.stats
from numpy.typing import NDArray

from flycontrol.delay.bracket import bracketed_root
from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.alone import LoneFit
from flycontrol.identify.gains.response import UNITS

FloatArray = NDArray[np.float64]
_MEDIAN = float(scipy.stats.chi2.median(1))
_ROUNDS = 20
_FEWEST = 3  #: with two nobody knows which is the odd one


@dataclass(frozen=True, slots=True, kw_only=True)
class Outlier:
    """One recording, or fly, that does not go with the others."""

    name: str
    kind: str  #: the unknown that is furthest off; empty if the recording could not be fitted
    value: float  #: its own
    others: float  #: mean of the others
    deviations: float  #: difference in standard deviations of a difference
    p: float  #: of all shared unknowns together, corrected for the number of recordings
    sentence: str


def outliers(alone: Sequence[LoneFit], level: float = 0.05) -> tuple[Outlier, ...]:
    """Name the fits that do not go with the others, the worst first, and those that could not be fitted.

    Parameters
    ----------
    alone
        From `fits_alone`, usually by recording; fewer than three usable ones name none.
    level
        Largest corrected p of an outlier.

    Raises
    ------
    InvalidParameterError
        If the level is outside of (0, 1).
    """
    if not 0 < level < 1:
        raise InvalidParameterError(f"The level of outliers must lie between 0 and 1, got {level!r}.")
    usable = [fit for fit in alone if fit.usable]
    found = _deviants(usable, level) if len(usable) >= _FEWEST and usable[0].kinds else []
    unfitted = [_unfitted(fit) for fit in alone if not fit.usable]
    return (*sorted(found, key=lambda outlier: outlier.p), *unfitted)


def _deviants(usable: Sequence[LoneFit], level: float) -> list[Outlier]:
    compared, inside, p = _Compared(usable), _core(usable), np.zeros(0)
    for _ in range(_ROUNDS):
        p = np.array([compared(i, inside).p for i in range(len(usable))])
        if np.array_equal(p > level, inside) or (p > level).sum() < 2:
            break
        inside = p > level
    return [_outlier(usable[i], len(usable), compared(i, inside)) for i in np.flatnonzero(p <= level).tolist()]


def _spread(usable: Sequence[LoneFit]) -> FloatArray:
    """tau^2 (k,) at which the median of squared deviations from the median, over their variance, is that of chi^2."""
    theta = np.array([fit.values for fit in usable])
    v = np.array([np.diag(fit.covariance) for fit in usable])
    squares = (theta - np.median(theta, axis=0)) ** 2

    def excess(tau2: float, k: int) -> float:
        return float(np.median(squares[:, k] / (v[:, k] + tau2))) - _MEDIAN

    roof = squares.max(axis=0) / _MEDIAN + 1e-300
    return np.array([
        bracketed_root(partial(excess, k=k), 0.0, float(roof[k])) if excess(0.0, k) > 0 else 0.0
        for k in range(theta.shape[1])
    ])  # fmt: skip


def _core(usable: Sequence[LoneFit]) -> NDArray[np.bool_]:
    """The half nearest to the median."""
    theta = np.array([fit.values for fit in usable])
    errors = np.sqrt([np.diag(fit.covariance) for fit in usable])
    distance = np.max(np.abs(theta - np.median(theta, axis=0)) / errors, axis=1)
    return distance <= np.median(distance)


@dataclass(frozen=True, slots=True, eq=False)
class _Difference:
    """Between one fit and the mean of others."""

    own: FloatArray  #: (k,)
    others: FloatArray  #: (k,)
    covariance: FloatArray  #: (k, k) of the difference
    p: float  #: corrected


class _Compared:
    """Fits against the mean of others, weighted by inverse covariances with the spread in them."""

    def __init__(self, usable: Sequence[LoneFit]) -> None:
        spread = np.diag(_spread(usable))
        self.values = np.array([fit.values for fit in usable])
        self.covariances = np.array([fit.covariance + spread for fit in usable])
        self.freedoms = np.array([np.median(fit.freedom) for fit in usable])
        self.weights = np.linalg.inv(self.covariances)
        self.pulls = np.einsum("nij,nj->ni", self.weights, self.values)

    def __call__(self, i: int, inside: NDArray[np.bool_]) -> _Difference:
        others = inside & (np.arange(len(inside)) != i)
        C = np.linalg.inv(self.weights[others].sum(axis=0))
        mean, total = C @ self.pulls[others].sum(axis=0), self.covariances[i] + C
        d = self.values[i] - mean
        p = scipy.stats.f.sf(d @ np.linalg.solve(total, d) / len(d), len(d), self.freedoms[i])
        return _Difference(self.values[i], mean, total, min(1.0, len(inside) * float(p)))


def _outlier(fit: LoneFit, count: int, found: _Difference) -> Outlier:
    apart = (found.own - found.others) / np.sqrt(np.diag(found.covariance))
    k = int(np.argmax(np.abs(apart)))
    kind, unit = fit.kinds[k], UNITS[fit.kinds[k]]
    return Outlier(
        name=fit.name, kind=kind, value=float(found.own[k]), others=float(found.others[k]),
        deviations=float(apart[k]), p=found.p,
        sentence=(
            f"{fit.name} does not go with the others: its {kind} is {found.own[k]:.4g} {unit}, theirs "
            f"{found.others[k]:.4g} {unit}, {abs(apart[k]):.1f} standard deviations apart (p = {found.p:.2g} for all "
            f"its shared parameters together, corrected for {count} recordings)."
        ),
    )  # fmt: skip


def _unfitted(fit: LoneFit) -> Outlier:
    nan = float("nan")
    return Outlier(
        name=fit.name, kind="", value=nan, others=nan, deviations=nan, p=nan,
        sentence=f"{fit.name} could not be fitted alone: {fit.status}",
    )  # fmt: skip

"""A second opinion on intervals: fits to recordings drawn anew around the estimate.

    data* = model(x) + e*,   e* drawn from the noise model (parametric) or from blocks of the residuals (block),
    x* = argmin |V^(-1/2) (model(x*) - data*)|^2,   from x - C J^T V^-1 (model(x) - data*), V as estimated.

The spread of x* around x stands for that of x around the truth (Efron and Tibshirani 1993). Moving blocks (Kuensch
1989) keep whatever correlation the noise model missed; their length follows Andrews (1991) for the first
autocorrelation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, cast

import numpy as np
import scipy.special
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.labour import HERE, Labour
from flycontrol.identify.gains.least_squares import WeightedProblem, minimise
from flycontrol.identify.gains.noise import Noise, drawn, whitened
from flycontrol.identify.gains.problem import Channel
from flycontrol.identify.gains.result import FitResult
from flycontrol.jobs.work import Work

FloatArray = NDArray[np.float64]
Resampling = Literal["parametric", "block"]
Method = Literal["percentile", "basic", "bca"]
_CLOSE = 1e-6  #: Newton decrement: a thousandth of a standard error


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Bootstrap:
    """Estimates from data drawn anew."""

    names: tuple[str, ...]
    kind: Resampling
    centre: FloatArray  #: (k,) least-squares estimate that data were drawn around
    draws: FloatArray  #: (b, k) of the fits that converged
    failed: int  #: fits that did not
    acceleration: FloatArray  #: (k,) of BCa intervals: a sixth of the skewness of the data's influence
    seed: int

    @property
    def covariance(self) -> FloatArray:
        """Of the draws (k, k)."""
        return np.atleast_2d(np.cov(self.draws, rowvar=False))

    @property
    def bias(self) -> FloatArray:
        """Mean of the draws less the estimate (k,)."""
        return np.asarray(self.draws.mean(axis=0) - self.centre, dtype=np.float64)

    def interval(self, name: str, level: float = 0.95, method: Method = "bca") -> tuple[float, float]:
        """Ends of an interval.

        Parameters
        ----------
        method
            "percentile": quantiles of the draws; "basic": twice the estimate less those; "bca": quantiles corrected for
            bias and acceleration (Efron 1987).

        Raises
        ------
        InvalidParameterError
            For an unknown name or method, or a level outside of (0, 1).
        """
        if name not in self.names or method not in ("percentile", "basic", "bca") or not 0 < level < 1:
            raise InvalidParameterError(
                f"An interval needs one of {', '.join(self.names)}, a level in (0, 1) and a method of percentile, "
                f"basic or bca, got {name!r}, {level!r} and {method!r}."
            )
        i = self.names.index(name)
        draws, centre = self.draws[:, i], self.centre[i]
        tails = np.array([0.5 - level / 2, 0.5 + level / 2])
        if method == "bca":
            tails = _corrected(tails, draws, centre, self.acceleration[i])
        low, high = np.quantile(draws, tails)
        return (float(2 * centre - high), float(2 * centre - low)) if method == "basic" else (float(low), float(high))


def bootstrap(
    found: FitResult,
    draws: int = 1000,
    *,
    kind: Resampling = "parametric",
    seed: int = 0,
    block: int | None = None,
    labour: Labour = HERE,
) -> Bootstrap:
    """Fit data drawn anew, the same bytes whatever the number of workers.

    Parameters
    ----------
    kind
        "parametric": from the fit's noise model; "block": moving blocks of its residuals.
    block
        Samples of a block; None: by the residuals' first autocorrelation.

    Raises
    ------
    InvalidParameterError
        If there are fewer than 2 draws, the kind is unknown or the block is not >= 1.
    """
    if draws < 2 or kind not in ("parametric", "block") or (block is not None and block < 1):
        raise InvalidParameterError(
            f'A bootstrap needs at least 2 draws, the kind "parametric" or "block" and blocks of at least one sample, '
            f"got {draws!r}, {kind!r} and {block!r}."
        )
    source = _source(found, kind, block)
    work = Work(task=partial(_refit, source), items=range(draws), seed=seed, name="bootstrap fits")
    rows = np.array(cast("list[FloatArray]", labour.done(work)))
    converged = rows[:, -1] > 0
    return Bootstrap(
        names=found.problem.names, kind=kind, centre=found.minimum.x, draws=rows[converged, :-1],
        failed=int((~converged).sum()), acceleration=_acceleration(source), seed=seed,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Series:
    """One channel at the estimate."""

    clean: FloatArray  #: (n,) predicted
    residuals: FloatArray  #: (n,) centred, of the size that noise has
    pull: FloatArray  #: (m, n) V^(-1/2) J^T
    block: int


@dataclass(frozen=True, slots=True, eq=False)
class _Source:
    """All that a worker needs to draw data and fit them."""

    weighted: WeightedProblem
    centre: FloatArray
    inverse: FloatArray  #: (J^T V^-1 J)^-1, zero for unknowns at a bound
    series: tuple[tuple[_Series, ...], ...]  #: by trial, by channel
    kind: Resampling


def _source(found: FitResult, kind: Resampling, block: int | None) -> _Source:
    weighted, x = found.weighted, found.minimum.x
    share = max(1.0 - len(x) / weighted.problem.samples, 1e-3)  # of the variance that the fit leaves in residuals
    series: list[tuple[_Series, ...]] = []
    for part, noises in zip(weighted.problem.parts, weighted.noise, strict=True):
        mine: list[_Series] = []
        for rows, channel, noise in zip(part.predicted(x), part.channels, noises, strict=True):
            residuals = channel.values - rows[0]
            length = _block_length(noise, len(residuals)) if block is None else min(block, len(residuals))
            mine.append(
                _Series(
                    clean=rows[0].copy(), residuals=(residuals - residuals.mean()) / np.sqrt(share),
                    pull=whitened(rows[1:], channel.firsts, noise), block=length,
                )
            )  # fmt: skip
        series.append(tuple(mine))
    covariance = found.covariance
    inverse = np.where(np.isfinite(covariance), covariance, 0.0)
    inverse[~np.isfinite(np.diag(covariance))] = 0.0
    inverse[:, ~np.isfinite(np.diag(covariance))] = 0.0
    return _Source(weighted, x, inverse, tuple(series), kind)


def _block_length(noise: Noise, n: int) -> int:
    """1.1447 (4 r^2 n / (1 - r^2)^2)^(1/3) for the first autocorrelation r, between n^(1/3) and n / 4."""
    r = float(noise.pacf[0]) if noise.order else 0.0
    andrews = 1.1447 * (4 * r**2 * n / (1 - r**2) ** 2) ** (1 / 3)
    return int(np.clip(np.ceil(max(andrews, n ** (1 / 3))), 1, max(n // 4, 1)))


def _refit(source: _Source, item: int, rng: np.random.Generator) -> FloatArray:
    """Unknowns of one fit and whether it converged (k + 1,)."""
    del item
    problem = source.weighted.problem
    parts, slope = [], np.zeros(len(source.centre))
    for part, noises, series in zip(problem.parts, source.weighted.noise, source.series, strict=True):
        channels: list[Channel] = []
        for channel, noise, one in zip(part.channels, noises, series, strict=True):
            error = _error(one, channel, noise, source.kind, rng)
            slope[part.places] += one.pull @ whitened(error[None, :], channel.firsts, noise)[0]
            channels.append(replace(channel, values=one.clean + error))
        parts.append(replace(part, channels=tuple(channels)))
    weighted = replace(source.weighted, problem=replace(problem, parts=tuple(parts)))
    found = minimise(weighted, source.centre + source.inverse @ slope, scale=1.0, close=_CLOSE)
    return np.append(found.x, float(found.converged))


def _error(one: _Series, channel: Channel, noise: Noise, kind: Resampling, rng: np.random.Generator) -> FloatArray:
    n = len(one.clean)
    if kind == "parametric":
        return drawn(noise, channel.firsts, n, rng)
    starts = rng.integers(0, n - one.block + 1, size=-(-n // one.block))
    return one.residuals[(starts[:, None] + np.arange(one.block)).ravel()[:n]]


def _acceleration(source: _Source) -> FloatArray:
    """A sixth of the skewness of the influences of blocks of residuals (k,); none where noise is drawn normal."""
    if source.kind == "parametric":
        return np.zeros(len(source.centre))
    influences: list[FloatArray] = []
    problem = source.weighted.problem
    for part, noises, series in zip(problem.parts, source.weighted.noise, source.series, strict=True):
        for channel, noise, one in zip(part.channels, noises, series, strict=True):
            error = whitened(one.residuals[None, :], channel.firsts, noise)[0]
            edges = np.arange(0, len(error), one.block)
            influences.append((source.inverse[:, part.places] @ np.add.reduceat(one.pull * error, edges, axis=1)).T)
    every = np.concatenate(influences)
    size = np.maximum(np.sum(every**2, axis=0), 1e-300)
    return np.asarray(np.sum(every**3, axis=0) / (6 * size**1.5), dtype=np.float64)


def _corrected(tails: FloatArray, draws: FloatArray, centre: float, a: float) -> FloatArray:
    """Phi(z0 + (z0 + z) / (1 - a (z0 + z))), z0 from the share of draws below the estimate."""
    below = (np.sum(draws < centre) + 0.5 * np.sum(draws == centre)) / len(draws)
    z0 = scipy.special.ndtri(np.clip(below, 1 / len(draws), 1 - 1 / len(draws)))
    z = z0 + scipy.special.ndtri(tails)
    return np.asarray(scipy.special.ndtr(z0 + z / (1 - a * z)), dtype=np.float64)

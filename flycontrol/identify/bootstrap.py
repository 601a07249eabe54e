"""A second opinion on the intervals of Eq. 3: resample the unknown torque in blocks and identify again."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flycontrol.identify.yaw_plant import (
    Estimate,
    YawHistory,
    YawPlantFit,
    driving_noise,
    quick_estimate,
    simulate_yaw_rate,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class BootstrapIntervals:
    """Basic bootstrap intervals, 2 estimate - quantile, of damping and paddling."""

    damping: Estimate  #: beta / I [1/s]
    paddling: Estimate  #: gamma / I [1/s^2 per rad]
    draws: int
    block: int  #: wingbeats kept together
    seed: int


def block_bootstrap(
    history: YawHistory, fit: YawPlantFit, draws: int = 200, block: int = 5, seed: int = 20101020
) -> BootstrapIntervals:
    """Moving-block bootstrap of the driving noise, the yaw rate simulated anew from it and d_alpha kept as it is."""
    noise = driving_noise(history, fit)
    noise = noise - noise.mean()
    n = len(noise)
    rng = np.random.default_rng(seed)
    starts = rng.integers(0, n - block + 1, size=(draws, -(-n // block)))
    picks = (starts[..., None] + np.arange(block)).reshape(draws, -1)[:, :n]
    again = np.array(
        [quick_estimate(replace(history, yaw_rate=simulate_yaw_rate(history, fit, noise[pick]))) for pick in picks]
    )
    quantiles = np.quantile(again, [0.975, 0.025], axis=0)
    return BootstrapIntervals(
        damping=_basic(fit.damping.value, *quantiles[:, 0]),
        paddling=_basic(fit.paddling_or_none, *quantiles[:, 1]),
        draws=draws,
        block=block,
        seed=seed,
    )


def _basic(value: float, high_quantile: float, low_quantile: float) -> Estimate:
    return Estimate(value=value, low=float(2 * value - high_quantile), high=float(2 * value - low_quantile))

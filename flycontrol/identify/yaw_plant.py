"""beta/I and gamma/I of Eq. 3 from yaw rate and paddling, wingbeat by wingbeat, with noise that remembers.

Over the wingbeat from t_k to t_k + T_k the plant psi'' = -b psi' + g d_alpha + c + n - u goes exactly from one yaw rate
to the next when d_alpha, the unknown torque n and the known coupling u are held at their means over the wingbeat:

    r_{k+1} = e^{-b T_k} r_k + f_k (g d_k + c + n_k - u_k),  f_k = (1 - e^{-b T_k}) / b,  n_k = rho n_{k-1} + e_k.

The yaw rate at a wingbeat's start is settled before e_k acts, so the likelihood of the e_k is not biased by feedback
from yaw to wings, nor by torque that the model does not know; a regression of r' on the wingbeat's own mean of r is.
The posterior is a grid over (a = e^{-b T}, rho) of Student t distributions for g and c, and its quantiles are the
intervals: they carry the uncertainty of rho too. Priors: flat on rho, g and c, 1/sigma^2 on the variance, and on a
flat in sqrt(1 - a^2), the share of the yaw rate's spread that each wingbeat renews (in arccosh a where it grows). A
prior flat in a overrates b in short, noisy records, where its 95 % intervals cover as little as 77 %; this one covers
92-99 % there (tests/identify/test_yaw_plant.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import stdtr

from flycontrol.errors import InvalidInputError

FloatArray = NDArray[np.float64]

FEWEST_WINGBEATS = 8  #: five unknowns and something to judge them by
PERSISTENCE = (0.01, 1.6)  #: a = e^{-b T}: from gone within a wingbeat to growing by 1.6
NOISE_CORRELATION = (-0.95, 0.99)  #: rho
FINE = (120, 40)  #: cells of the fine grid over a and rho; twice as many move no interval by 1 % of its width
LEVELS = (0.025, 0.5, 0.975)
STEADIEST = 1e-9  #: range of d_alpha up to which it does not vary, but for rounding [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class YawHistory:
    """Yaw rate at the n + 1 reversals and what acted over each of the n wingbeats between them."""

    yaw_rate: FloatArray  #: (n + 1,) about the stroke-plane normal [rad/s]
    d_alpha: FloatArray  #: (n,) [rad]
    durations: FloatArray  #: (n,) [s]
    coupling: FloatArray  #: (n,) known part u of -psi'', 0 for Eq. 3 as it stands [rad/s^2]

    def __post_init__(self) -> None:
        n = len(self.d_alpha)
        if not (len(self.yaw_rate) == n + 1 and len(self.durations) == len(self.coupling) == n):
            raise InvalidInputError("A yaw history needs n wingbeats and the yaw rate at their n + 1 reversals.")
        if n < FEWEST_WINGBEATS:
            raise InvalidInputError(
                f"{n} wingbeats are too few to identify yaw damping and paddling; {FEWEST_WINGBEATS} are needed."
            )

    @property
    def paddles(self) -> bool:
        """Whether d_alpha varies at all; where it does not, gamma cannot be told from the offset c."""
        return bool(np.ptp(self.d_alpha) > STEADIEST)

    @property
    def regressors(self) -> FloatArray:
        """(n, 2) d_alpha and 1, or (n, 1) ones where d_alpha does not vary."""
        ones = np.ones_like(self.d_alpha)
        return np.column_stack([self.d_alpha, ones]) if self.paddles else ones[:, None]

    @property
    def acceleration(self) -> FloatArray:
        """(n,) mean of psi'' over each wingbeat [rad/s^2]."""
        return np.diff(self.yaw_rate) / self.durations


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """Median of the posterior with its central 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def excludes_zero(self) -> bool:
        """The interval lies on one side of zero."""
        return self.low > 0 or self.high < 0


@dataclass(frozen=True, slots=True, kw_only=True)
class YawPlantFit:
    """Eq. 3 in ratios to the inertia, with 95 % intervals, and how much of the yaw motion it explains."""

    damping: Estimate  #: b = beta / I [1/s]
    paddling: Estimate | None  #: g = gamma / I [1/s^2 per rad]; None where d_alpha does not vary
    turn_gain: Estimate | None  #: gamma / beta [1/s]; None without gamma, or unbounded since beta may be zero
    offset: Estimate  #: c [rad/s^2]
    intercept: float  #: c that makes the modelled acceleration's mean the measured one, for the curves below [rad/s^2]
    noise_correlation: Estimate  #: rho from one wingbeat to the next [1]
    acceleration: FloatArray  #: (n,) measured, mean over each wingbeat [rad/s^2]
    modelled_acceleration: FloatArray  #: (n,) -b psi' + g d_alpha + c - u at the estimates [rad/s^2]
    yaw_rate: FloatArray  #: (n + 1,) measured at the reversals [rad/s]
    simulated_yaw_rate: FloatArray  #: (n + 1,) from the first rate by d_alpha alone [rad/s]
    r2_acceleration: float  #: share of the acceleration's variance explained at the estimates
    r2_acceleration_best: float  #: the most that any b, g and c could explain
    r2_simulated: float  #: share of the yaw rate's variance that the simulation explains

    @property
    def paddling_or_none(self) -> float:
        """g for a simulation [1/s^2 per rad]: 0 where it is not known, since a steady d_alpha is in the offset."""
        return 0.0 if self.paddling is None else self.paddling.value


def fit_yaw_plant(history: YawHistory) -> YawPlantFit:
    """Posterior medians and 95 % intervals of b, g, c and rho.  Review, Eq. 3."""
    posterior = _posterior(history)
    damping = posterior.of_damping()
    paddling = posterior.of_linear(lambda p: (p.mean[..., 0], p.sd[..., 0])) if history.paddles else None
    offset = posterior.of_linear(lambda p: (p.mean[..., -1], p.sd[..., -1]))
    g = 0.0 if paddling is None else paddling.value
    slope = _modelled_acceleration(history, damping.value, g, 0.0)
    per_offset = _modelled_acceleration(history, damping.value, g, 1.0) - slope
    intercept = float(np.mean(history.acceleration - slope) / np.mean(per_offset))
    at = (damping.value, g, intercept)
    simulated = _simulate(history, *at)
    modelled = _modelled_acceleration(history, *at)
    return YawPlantFit(
        damping=damping,
        paddling=paddling,
        turn_gain=posterior.of_turn_gain() if history.paddles and damping.excludes_zero else None,
        offset=offset,
        intercept=intercept,
        noise_correlation=posterior.of_correlation(),
        acceleration=history.acceleration,
        modelled_acceleration=modelled,
        yaw_rate=history.yaw_rate,
        simulated_yaw_rate=simulated,
        r2_acceleration=explained(history.acceleration, modelled),
        r2_acceleration_best=_best_r2(history),
        r2_simulated=explained(history.yaw_rate, simulated),
    )


def quick_estimate(history: YawHistory) -> tuple[float, float]:
    """b and g from the coarse grid alone, for resampling: median of b [1/s], mean of g [1/s^2 per rad]."""
    posterior = _on_grid(history, np.linspace(*PERSISTENCE, 81), np.linspace(*NOISE_CORRELATION, 26))
    g = float(np.sum(posterior.weight * posterior.mean[..., 0])) if history.paddles else 0.0
    return posterior.of_damping().value, g


def driving_noise(history: YawHistory, fit: YawPlantFit) -> FloatArray:
    """n_k at the estimates: what b, g and the intercept leave of each wingbeat's driving acceleration [rad/s^2]."""
    decay = np.exp(-fit.damping.value * history.durations)
    gain = (1.0 - decay) / fit.damping.value
    driving = (history.yaw_rate[1:] - decay * history.yaw_rate[:-1]) / gain + history.coupling
    return driving - fit.paddling_or_none * history.d_alpha - fit.intercept


def simulate_yaw_rate(history: YawHistory, fit: YawPlantFit, noise: FloatArray) -> FloatArray:
    """(n + 1,) yaw rate from the first one by d_alpha, the intercept and a given noise (n,) [rad/s]."""
    drive = fit.paddling_or_none * history.d_alpha + fit.intercept + noise - history.coupling
    return _driven(history, fit.damping.value, drive)


def explained(measured: FloatArray, modelled: FloatArray) -> float:
    """R^2 = 1 - sum (measured - modelled)^2 / sum (measured - mean)^2; below 0 when the mean would do better."""
    return float(1.0 - np.sum((measured - modelled) ** 2) / np.sum((measured - measured.mean()) ** 2))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Posterior:
    """Weights of the cells of a grid (b, rho), and location and scale of the t distributions of g and c in each."""

    b: FloatArray  # (i,), at the cells' middles
    b_edges: FloatArray  # (i + 1,), falling
    rho_edges: FloatArray  # (j + 1,)
    weight: FloatArray  # (i, j), sums to 1
    mean: FloatArray  # (i, j, 2), or (i, j, 1) of c alone
    sd: FloatArray  # likewise
    freedom: int

    def of_damping(self) -> Estimate:
        return _cell_quantiles(self.b_edges[::-1], self.weight.sum(axis=1)[::-1])

    def of_correlation(self) -> Estimate:
        return _cell_quantiles(self.rho_edges, self.weight.sum(axis=0))

    def of_turn_gain(self) -> Estimate:
        return self.of_linear(lambda p: (p.mean[..., 0] / p.b[:, None], p.sd[..., 0] / np.abs(p.b)[:, None]))

    def of_linear(self, location_and_scale: Callable[[_Posterior], tuple[FloatArray, FloatArray]]) -> Estimate:
        """Quantiles of a mixture of t distributions; grid points of weight below 1e-5 of the largest are left out."""
        keep = self.weight > 1e-5 * self.weight.max()
        location, scale = (v[keep] for v in location_and_scale(self))
        weight = self.weight[keep] / self.weight[keep].sum()

        def beyond(x: float, level: float) -> float:
            return float(np.sum(weight * stdtr(self.freedom, (x - location) / scale))) - level

        middle = float(np.sum(weight * location))
        spread = float(np.sqrt(np.sum(weight * (scale**2 + (location - middle) ** 2))))
        wide = (middle - 30 * spread, middle + 30 * spread)  # Chebyshev: at most 1/900 lies beyond
        roots = [brentq(beyond, *wide, args=(level,), xtol=1e-5 * spread) for level in LEVELS]
        low, median, high = np.array(roots, dtype=np.float64)
        return Estimate(value=float(median), low=float(low), high=float(high))


def _posterior(history: YawHistory) -> _Posterior:
    """Coarse cells over (a, rho), then fine ones where the weight is."""
    a = np.linspace(*PERSISTENCE, 161)
    rho = np.linspace(*NOISE_CORRELATION, 51)
    coarse = _on_grid(history, a, rho)
    return _on_grid(
        history, _zoomed(a, coarse.weight.sum(axis=1), FINE[0]), _zoomed(rho, coarse.weight.sum(axis=0), FINE[1])
    )


def _prior_mass(edges: FloatArray) -> FloatArray:
    """Prior of each cell: the step in -sqrt(1 - a^2) below 1 and in arccosh a above, between the cell's edges."""
    below = -np.sqrt(1.0 - np.minimum(edges, 1.0) ** 2)
    above = np.arccosh(np.maximum(edges, 1.0))
    return np.diff(below + above)


def _zoomed(edges: FloatArray, weight: FloatArray, cells: int) -> FloatArray:
    """Edges of finer cells over those whose weight is above a millionth of the largest."""
    inside = np.flatnonzero(weight > 1e-6 * weight.max())
    return np.linspace(edges[inside[0]], edges[inside[-1] + 1], cells + 1)


def _on_grid(history: YawHistory, a_edges: FloatArray, rho_edges: FloatArray) -> _Posterior:
    period = float(history.durations.mean())
    a, rho = 0.5 * (a_edges[1:] + a_edges[:-1]), 0.5 * (rho_edges[1:] + rho_edges[:-1])
    b = -np.log(a) / period
    b = np.where(np.abs(b) < 1e-6, 1e-6, b)  # the limit, where (1 - e^{-bT}) / b = T
    decay = np.exp(-b[:, None] * history.durations)
    gain = (1.0 - decay) / b[:, None]
    driving = (history.yaw_rate[1:] - decay * history.yaw_rate[:-1]) / gain + history.coupling
    regressors = history.regressors
    jacobian = np.log(_prior_mass(a_edges)) - np.sum(np.log(gain[:, 1:]), axis=1)
    columns = [_whitened_fit(driving, regressors, float(r)) for r in rho]
    log_weight = np.stack([c[0] for c in columns], axis=1) + jacobian[:, None]
    weight = np.exp(log_weight - log_weight.max())
    return _Posterior(
        b=b,
        b_edges=-np.log(a_edges) / period,
        rho_edges=rho_edges,
        weight=weight / weight.sum(),
        mean=np.stack([c[1] for c in columns], axis=1),
        sd=np.stack([c[2] for c in columns], axis=1),
        freedom=len(history.d_alpha) - 1 - regressors.shape[1],
    )


def _whitened_fit(driving: FloatArray, regressors: FloatArray, rho: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Fit s_k - rho s_{k-1} = (X_k - rho X_{k-1}) (g, c) + e: log weight, means and scales of (g, c)."""
    s = driving[:, 1:] - rho * driving[:, :-1]
    X = regressors[1:] - rho * regressors[:-1]
    gram = X.T @ X
    inverse = np.linalg.inv(gram)
    coefficient = s @ X @ inverse
    residual = np.sum((s - coefficient @ X.T) ** 2, axis=1)
    freedom = len(X) - X.shape[1]
    log_weight = -0.5 * np.linalg.slogdet(gram)[1] - 0.5 * freedom * np.log(residual)
    sd = np.sqrt(residual[:, None] / freedom * np.diag(inverse))
    return log_weight, coefficient, sd


def _cell_quantiles(edges: FloatArray, weight: FloatArray) -> Estimate:
    """Quantiles of a density that is flat within each cell, edges rising."""
    mass = np.concatenate([[0.0], np.cumsum(weight)])
    low, middle, high = np.interp(np.array(LEVELS) * mass[-1], mass, edges)
    return Estimate(value=float(middle), low=float(low), high=float(high))


def _simulate(history: YawHistory, b: float, g: float, c: float) -> FloatArray:
    return _driven(history, b, g * history.d_alpha + c - history.coupling)


def _driven(history: YawHistory, b: float, drive: FloatArray) -> FloatArray:
    """r_{k+1} = e^{-b T_k} r_k + f_k drive_k from the first measured rate."""
    rate = [float(history.yaw_rate[0])]
    decay = np.exp(-b * history.durations)
    gain = (1.0 - decay) / b
    for k, acceleration in enumerate(drive):
        rate.append(float(decay[k] * rate[-1] + gain[k] * acceleration))
    return np.array(rate)


def _modelled_acceleration(history: YawHistory, b: float, g: float, c: float) -> FloatArray:
    """Mean of psi'' = -b psi' + g d_alpha + c - u over each wingbeat, from the measured rate at its start."""
    drive = g * history.d_alpha + c - history.coupling
    decay = np.exp(-b * history.durations)
    end = decay * history.yaw_rate[:-1] + (1.0 - decay) / b * drive
    return (end - history.yaw_rate[:-1]) / history.durations


def _best_r2(history: YawHistory) -> float:
    """Return the largest R^2 of the modelled acceleration: least squares for g and c at every b of the grid."""
    b = -np.log(np.linspace(*PERSISTENCE, 160)) / float(history.durations.mean())
    regressors = history.regressors
    best = -np.inf
    for each in b[np.abs(b) > 1e-6]:
        fixed = _modelled_acceleration(history, float(each), 0.0, 0.0)
        per_unit = (1.0 - np.exp(-each * history.durations)) / (each * history.durations)
        X = regressors * per_unit[:, None]
        coefficient = np.linalg.lstsq(X, history.acceleration - fixed, rcond=None)[0]
        best = max(best, explained(history.acceleration, fixed + X @ coefficient))
    return best

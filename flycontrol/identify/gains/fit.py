"""Gains, damping and delay from recordings of perturbed flies, with intervals.

>>> from flycontrol.identify.gains.fit import fit_gains
>>> found = fit_gains([trial])  # doctest: +SKIP
>>> found["delay"].value, found["delay"].low, found["delay"].high  # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.intervals import doubtful_profiles, estimates, without_meaning
from flycontrol.identify.gains.least_squares import (
    Loss,
    Minimum,
    NormalEquations,
    WeightedProblem,
    minimise,
    variance_of,
)
from flycontrol.identify.gains.model import GainModel
from flycontrol.identify.gains.noise import Noise, estimate, order_by_bic, white
from flycontrol.identify.gains.problem import Channel, FitProblem, fit_problem, standard_model
from flycontrol.identify.gains.profile import Profile
from flycontrol.identify.gains.result import FitResult
from flycontrol.identify.gains.saturation import without_unreached
from flycontrol.identify.gains.starts import starting_points
from flycontrol.identify.gains.status import nothing_there, status
from flycontrol.identify.gains.uncertainty import LocalUncertainty, local_uncertainty
from flycontrol.model.trial import Trial

FloatArray = NDArray[np.float64]
_LARGEST_ORDER = 4
_ROUNDS = 4  #: of noise and parameters in turn
_NEAR = 2.0  #: other starts are searched from too when the regression there is less than this much worse
_LOOSE = 0.03  #: relative error of the delay above which searches begin at all delays
_POOR = 4.0  #: and when the residuals' variance exceeds that of the samples' differences so many times


def fit_gains(
    trials: Sequence[Trial],
    model: GainModel | None = None,
    *,
    noise: str | int = "auto",
    loss: Loss = "linear",
    level: float = 0.95,
    start: FloatArray | None = None,
) -> FitResult:
    """Fit the yaw loop to trials.

    Parameters
    ----------
    model
        What is known and what is not; None: PD on the yaw angle, gains, delay and damping unknown, and the paddling
        gain where paddling was measured.
    noise
        "white", an autoregressive order, or "auto": the order by BIC, at most 4; coefficients by restricted likelihood.
    loss
        "linear", or "huber" where single samples may be far off.
    level
        Of the intervals.
    start
        Vector of unknowns (k,) to search from; None: from the data, from several delays.

    Raises
    ------
    InvalidInputError
        If the trials and the model do not fit each other.
    InvalidParameterError
        For an unknown kind of noise or loss, a level outside of (0, 1), or a start without a number for each unknown.
    """
    _refuse(noise, loss, level)
    weighted, minimum = _searched(trials, model, noise, loss, start)
    uncertainty = local_uncertainty(weighted, minimum)
    nothing = nothing_there(weighted, minimum, uncertainty)
    bent = {} if nothing else doubtful_profiles(weighted, minimum, uncertainty, level)
    lower = next((found.lower for found in bent.values() if found.lower is not None), None)
    if lower is not None:  # a ridge led further down than all searches
        weighted, minimum = _settled(weighted, minimise(weighted, lower), noise)
        uncertainty = local_uncertainty(weighted, minimum)
        bent = doubtful_profiles(weighted, minimum, uncertainty, level)
    return _result(weighted, minimum, uncertainty, bent, level)


def fit_without_profiles(
    trials: Sequence[Trial],
    model: GainModel | None = None,
    *,
    noise: str | int = "auto",
    loss: Loss = "linear",
    start: FloatArray | None = None,
) -> FitResult:
    """The same search, 95 % intervals by the covariance alone: for many fits whose minimum is what counts.

    Parameters and exceptions as of `fit_gains`.
    """
    _refuse(noise, loss, 0.95)
    weighted, minimum = _searched(trials, model, noise, loss, start)
    return _result(weighted, minimum, local_uncertainty(weighted, minimum), {}, 0.95)


def _searched(
    trials: Sequence[Trial], model: GainModel | None, noise: str | int, loss: Loss, start: FloatArray | None
) -> tuple[WeightedProblem, Minimum]:
    problem = fit_problem(trials, standard_model(trials) if model is None else model)
    guessed = [[white(_roughness(channel), 1.0) for channel in part.channels] for part in problem.parts]
    weighted = WeightedProblem(problem, guessed, loss)
    minimum = _best_minimum(weighted) if start is None else minimise(weighted, _start(problem, start))
    return _settled(weighted, minimum, noise)


def _settled(weighted: WeightedProblem, minimum: Minimum, noise: str | int) -> tuple[WeightedProblem, Minimum]:
    weighted, minimum = _with_noise(weighted, minimum, noise)
    return weighted, without_unreached(weighted, minimum)


def _result(
    weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty, bent: Mapping[str, Profile],
    level: float,
) -> FitResult:  # fmt: skip
    nothing = nothing_there(weighted, minimum, uncertainty)
    found = estimates(weighted, minimum, uncertainty, level, bent)
    useless = nothing or ("" if minimum.converged else "not converged")
    found = without_meaning(found, useless) if useless else found
    return FitResult(
        problem=weighted.problem, weighted=weighted, minimum=minimum, uncertainty=uncertainty, estimates=found,
        level=level, converged=minimum.converged, status=status(weighted, minimum, uncertainty, found, nothing),
    )  # fmt: skip


def _refuse(noise: str | int, loss: str, level: float) -> None:
    if not (noise in ("auto", "white") or (isinstance(noise, int) and 0 <= noise <= 12)):
        raise InvalidParameterError(f'noise must be "auto", "white" or an order from 0 to 12, got {noise!r}.')
    if loss not in ("linear", "huber"):
        raise InvalidParameterError(f'loss must be "linear" or "huber", got {loss!r}.')
    if not 0 < level < 1:
        raise InvalidParameterError(f"The level of intervals must lie between 0 and 1, got {level!r}.")


def _start(problem: FitProblem, start: FloatArray) -> FloatArray:
    x = np.asarray(start, dtype=np.float64)
    if x.shape != (len(problem.names),) or not np.isfinite(x).all():
        raise InvalidParameterError(
            f"start must have one finite number for each of the {len(problem.names)} unknowns, in the order "
            f"{', '.join(problem.names)}; got the shape {x.shape}{'' if np.isfinite(x).all() else ', not all finite'}."
        )
    return x


def _roughness(channel: Channel) -> float:
    """Standard deviation of white noise from second differences of the samples, robustly [rad]."""
    if len(channel.values) < 4:
        return 1.0
    bends = np.diff(channel.values, 2) / np.sqrt(6.0)
    return max(float(np.median(np.abs(bends)) / 0.6745), 1e-9)


def _best_minimum(weighted: WeightedProblem) -> Minimum:
    """The best of searches from several delays: all of them where the first leaves much, or the delay, undetermined."""
    starts = starting_points(weighted.problem)
    first = next(starts)
    best = minimise(weighted, first.x)
    soft = _soft(weighted, best)
    for other in starts:
        if not (soft or (other.lowest and other.residual < _NEAR * first.residual)):
            break
        found = minimise(weighted, other.x)
        if found.at.cost < best.at.cost and (found.converged or not best.converged):
            best = found
    return best


def _soft(weighted: WeightedProblem, found: Minimum) -> bool:
    """Whether other delays deserve a search: no convergence, a poor fit, or a delay known to 3 % at best."""
    problem = weighted.problem
    excess = found.at.cost / max(problem.samples - len(found.x), 1)
    if not found.converged or excess > _POOR:
        return True
    delays = [i for i, kind in enumerate(problem.kinds) if kind == "delay"]
    return any(excess * variance_of(found, i) > (_LOOSE * found.x[i]) ** 2 for i in delays)


def _with_noise(weighted: WeightedProblem, minimum: Minimum, kind: str | int) -> tuple[WeightedProblem, Minimum]:
    """Noise by restricted likelihood and parameters by least squares, in turn until neither moves."""
    problem, orders = weighted.problem, None
    for _ in range(_ROUNDS):
        noises, orders = _noises(weighted, minimum.x, kind, orders)
        before, weighted = weighted.noise[0][0], WeightedProblem(problem, noises, weighted.loss)
        if _only_the_size_changed(weighted, orders):
            return weighted, _rescaled(minimum, (before.deviation / noises[0][0].deviation) ** 2)
        found = minimise(weighted, minimum.x, scale=1.0)
        settled = found.steps == 0
        minimum = found
        if settled or not any(order for channels in orders for order in channels):
            break
    return weighted, minimum


def _only_the_size_changed(weighted: WeightedProblem, orders: list[list[int]]) -> bool:
    """White noise of a single channel weighs nothing against anything: the minimum stays where it is."""
    return orders == [[0]] and not weighted.problem.priors and weighted.loss == "linear"


def _rescaled(minimum: Minimum, factor: float) -> Minimum:
    at = minimum.at
    return replace(minimum, at=NormalEquations(at.cost * factor, at.gradient * factor, at.matrix * factor))


def _noises(
    weighted: WeightedProblem, x: FloatArray, kind: str | int, orders: list[list[int]] | None
) -> tuple[list[list[Noise]], list[list[int]]]:
    """Noise of each channel of each trial at x; the orders are chosen once."""
    found: list[list[Noise]] = []
    chosen: list[list[int]] = []
    for i, part in enumerate(weighted.problem.parts):
        predicted = part.predicted(x)
        found.append([])
        chosen.append([])
        for j, (rows, channel) in enumerate(zip(predicted, part.channels, strict=True)):
            rows[0] -= channel.values
            if weighted.loss == "huber":
                size = 2.5 * np.median(np.abs(rows[0])) / 0.6745
                rows[0] = np.clip(rows[0], -size, size)
            order = orders[i][j] if orders is not None else _order(rows[0], channel, kind)
            chosen[-1].append(order)
            found[-1].append(estimate(rows, channel.firsts, order))
    return found, chosen


def _order(residuals: FloatArray, channel: Channel, kind: str | int) -> int:
    if kind == "white":
        return 0
    return order_by_bic(residuals, channel.firsts, _LARGEST_ORDER) if kind == "auto" else int(kind)

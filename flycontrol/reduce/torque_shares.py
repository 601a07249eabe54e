"""Shares of stroke, deviation and pitch in a turn's yaw torque, with intervals over its wingbeats.

A turn is condensed into one number v for each of the eight versions of its wing motion; v is linear in the wingbeats'
torques N_i, so that its effects are condensed the same way:

    mean:    v = (1/n) sum of N_i
    slope:   v = sum of (N_i - <N>) (R_i - <R>) / sum of (R_i - <R>)^2

Blocks of L out of n wingbeats scatter too little about their mean: what is drawn is moved away from v by the factor
sqrt(n / (n - L)) t / z, t and z Student's (n - 1 degrees of freedom) and the normal 97.5 % quantile.

R_i is the torque that the body's motion needs. Noise of tracked wings is in N and hardly in R: it leaves the slope as
it is, and so do wrong zeros of the wing angles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri, stdtrit

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.model.collapsed_wingbeats import CollapsedWingbeats
from flycontrol.model.resampling import wrapped_blocks
from flycontrol.model.stroke import ANGLES, Angle
from flycontrol.model.symmetrised import VERSIONS
from flycontrol.reduce.factorial import Factorial
from flycontrol.reduce.symmetrised_torque import torques_of_stroke

FloatArray = NDArray[np.float64]

SEED = 20101020
BLOCK = 3  #: wingbeats kept together
DRAWS = 400
FEWEST = 4  #: wingbeats that have an interval


@dataclass(frozen=True, slots=True, kw_only=True)
class Interval:
    """A value with its 95 % interval, from quantiles of the bootstrap."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueShares:
    """What each angle contributes; the unit is that of v, shares are parts of `total`."""

    wingbeats: int
    symmetric: Interval  #: v of mirror-symmetric wings: of the body's own motion
    total: Interval  #: v of all asymmetries together
    effects: Mapping[Angle, Interval]  #: Shapley's, unit of v
    alone: Mapping[Angle, Interval]  #: share with this angle alone kept
    all_but_one: Mapping[Angle, Interval]  #: share lost with this angle alone symmetrised
    shapley: Mapping[Angle, Interval]  #: share, mean over all orders; they add up to 1
    interaction: Interval  #: 1 less the shares alone
    bounded: bool  #: whether the total differs from zero; if not, shares have no bounds

    @property
    def status(self) -> str:
        """What may be said of the shares, as a sentence."""
        if not self.bounded:
            return "The asymmetric torque cannot be told from none, so that its shares have no bounds."
        return f"Shares of {self.wingbeats} wingbeats add up with an interaction of {self.interaction.value:+.1%}."


def shares_of_mean(torques: ArrayLike, block: int = BLOCK, draws: int = DRAWS, seed: int = SEED) -> TorqueShares:
    """Shares of the mean torque of n wingbeats.

    Parameters
    ----------
    torques : (n, 8) by wingbeat and version [N m]
    block : wingbeats that the bootstrap keeps together
    draws : of the bootstrap
    seed : of the bootstrap

    Raises
    ------
    InvalidInputError
        Torques have another shape, gaps, too few wingbeats, or nothing to share.
    InvalidParameterError
        Block or draws are no whole numbers of at least 1.
    """
    by_wingbeat = _by_version(torques)
    n = len(by_wingbeat)
    picks = _picks(n, block, draws, np.random.default_rng(seed))
    mean = by_wingbeat.mean(axis=0)
    return torque_shares(mean, _widened(mean, by_wingbeat[picks].mean(axis=1), n, block), n)


def shares_of_slope(
    torques: Sequence[ArrayLike],
    required: Sequence[ArrayLike],
    block: int = BLOCK,
    draws: int = DRAWS,
    seed: int = SEED,
) -> TorqueShares:
    """Shares of the slope of supplied on required torque, flights pooled, means of each flight taken out.

    Parameters
    ----------
    torques : (n, 8) by wingbeat and version for each flight [N m]
    required : (n,) for each flight [N m]
    block : wingbeats that the bootstrap keeps together, within a flight
    draws : of the bootstrap
    seed : of the bootstrap

    Raises
    ------
    InvalidInputError
        There is no flight, torques are not as many as those required, have gaps, too few wingbeats, or nothing to
        share; or the torque required does not change.
    InvalidParameterError
        Block or draws are no whole numbers of at least 1.
    """
    flights = _flights(torques, required)
    rng = np.random.default_rng(seed)
    picks = [_picks(len(R), block, draws, rng) for _, R in flights]
    drawn = [_sums(N[i], R[i]) for (N, R), i in zip(flights, picks, strict=True)]
    as_is = [_sums(N[None], R[None]) for N, R in flights]
    slopes, slope = (np.sum([p for p, _ in s], axis=0) / np.sum([q for _, q in s], axis=0) for s in (drawn, as_is))
    n = sum(len(R) for _, R in flights)
    return torque_shares(slope[0], _widened(slope[0], slopes, n, block), n)


def shares_of_collapsed(
    fly: FlappingFly,
    wingbeats: CollapsedWingbeats,
    quiet: CollapsedWingbeats | None = None,
    block: int = BLOCK,
    draws: int = DRAWS,
    seed: int = SEED,
) -> TorqueShares:
    """Shares of the torque of a turn's mean wingbeat on a held body; the bootstrap draws wingbeats and collapses again.

    Parameters
    ----------
    fly : its air and shape
    wingbeats : of the turn
    quiet : wingbeats of straight flight whose torques are taken away, version by version, if zeros of the wings' angles
        are in doubt
    block : wingbeats that the bootstrap keeps together
    draws : of the bootstrap
    seed : of the bootstrap
    """
    rng = np.random.default_rng(seed)
    values, drawn = _collapsed(fly, wingbeats, block, draws, rng)
    if quiet is not None:
        quiet_values, quiet_drawn = _collapsed(fly, quiet, block, draws, rng)
        values, drawn = values - quiet_values, drawn - quiet_drawn
    return torque_shares(values, drawn, wingbeats.count)


def torque_shares(values: FloatArray, draws: FloatArray, wingbeats: int) -> TorqueShares:
    """Shares from the eight values (8,) and those of the bootstrap's draws (d, 8).

    Raises
    ------
    InvalidInputError
        The wings as measured do no more than symmetrised ones.
    """
    plain, drawn = Factorial(values=values), Factorial(values=draws)
    if plain.total == 0:
        raise InvalidInputError(
            "There is no torque to share: with all asymmetries it is exactly what it is with none; give the wingbeats "
            "of a turn."
        )
    total = _interval(plain.total, drawn.total)
    bounded = total.low > 0 or total.high < 0

    def share(part: FloatArray, parts: FloatArray) -> Interval:
        if not bounded:
            return Interval(value=float(part / plain.total), low=-np.inf, high=np.inf)
        return _interval(part / plain.total, parts / drawn.total)

    return TorqueShares(
        wingbeats=wingbeats,
        symmetric=_interval(plain.symmetric, drawn.symmetric),
        total=total,
        effects=_by_angle(_interval, plain.shapley, drawn.shapley),
        alone=_by_angle(share, plain.alone, drawn.alone),
        all_but_one=_by_angle(share, plain.all_but_one, drawn.all_but_one),
        shapley=_by_angle(share, plain.shapley, drawn.shapley),
        interaction=share(plain.interaction, drawn.interaction),
        bounded=bounded,
    )


def _by_angle(
    interval: Callable[[FloatArray, FloatArray], Interval], part: FloatArray, parts: FloatArray
) -> dict[Angle, Interval]:
    return {angle: interval(part[k], parts[:, k]) for k, angle in enumerate(ANGLES)}


def _interval(value: FloatArray, draws: FloatArray) -> Interval:
    low, high = np.quantile(draws, [0.025, 0.975])
    return Interval(value=float(value), low=float(low), high=float(high))


def _by_version(torques: ArrayLike) -> FloatArray:
    """(n, 8), without gaps."""
    array = np.asarray(torques, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != len(VERSIONS):
        raise InvalidInputError(
            f"Torques must have a row for each wingbeat and a column for each of the {len(VERSIONS)} versions, got "
            f"shape {array.shape}."
        )
    _refuse_gaps(array)
    return array


def _flights(torques: Sequence[ArrayLike], required: Sequence[ArrayLike]) -> list[tuple[FloatArray, FloatArray]]:
    """Torques (n, 8) and those required (n,) of each flight."""
    if not len(torques) == len(required) > 0:
        raise InvalidInputError(
            "A slope needs at least one flight, and as many arrays of torques as of torques required, got "
            f"{len(torques)} and {len(required)}."
        )
    flights = [(_by_version(N), np.asarray(R, dtype=np.float64)) for N, R in zip(torques, required, strict=True)]
    for number, (N, R) in enumerate(flights):
        if R.shape != (len(N),):
            raise InvalidInputError(
                f"Flight {number} has torques of {len(N)} wingbeats and required torques of shape {R.shape}; give one "
                "of each a wingbeat."
            )
        _refuse_gaps(R)
    if all(np.ptp(R) == 0 for _, R in flights if len(R)):
        raise InvalidInputError(
            "A slope needs a required torque that changes from wingbeat to wingbeat, and this one is the same in all "
            "of every flight; take flights with turns."
        )
    return flights


def _refuse_gaps(torques: FloatArray) -> None:
    if not np.all(np.isfinite(torques)):
        raise InvalidInputError(
            f"Torques by wingbeat must be finite, got {np.count_nonzero(~np.isfinite(torques))} that are not; leave "
            "out the wingbeats without them."
        )


def _picks(n: int, block: int, draws: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Indices (draws, n); a short turn needs shorter blocks, or all draws would be alike."""
    for name, value in (("block", block), ("draws", draws)):
        if not (isinstance(value, int | np.integer) and value >= 1):
            raise InvalidParameterError(f"{name} of the bootstrap must be a whole number of at least 1, got {value!r}.")
    if n < FEWEST:
        raise InvalidInputError(f"Intervals over wingbeats need {FEWEST} of them or more, got {n}; take a longer turn.")
    return wrapped_blocks(n, _length(n, block), draws, rng)


def _length(n: int, block: int) -> int:
    return max(1, min(block, n // 3))


def _widened(values: FloatArray, draws: FloatArray, n: int, block: int) -> FloatArray:
    factor = np.sqrt(n / (n - _length(n, block))) * stdtrit(n - 1, 0.975) / ndtri(0.975)
    return values + factor * (draws - values)


def _sums(torques: FloatArray, required: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sums of (N - <N>) (R - <R>), (d, 8), and of (R - <R>)^2, (d, 1), of draws (d, n, 8) and (d, n)."""
    off = (required - required.mean(axis=1, keepdims=True))[..., None]
    return np.sum(off * torques, axis=1), np.sum(off**2, axis=1)


def _collapsed(
    fly: FlappingFly, wingbeats: CollapsedWingbeats, block: int, draws: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    picks = _picks(wingbeats.count, block, draws, rng)
    drawn = [torques_of_stroke(fly, wingbeats.drawn(pick).mean_stroke()) for pick in picks]
    values = torques_of_stroke(fly, wingbeats.mean_stroke())
    return values, _widened(values, np.stack(drawn), wingbeats.count, block)

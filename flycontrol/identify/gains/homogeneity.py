"""Do the flies share their gains? Likelihood ratio of separate gains against shared ones, noise the same in both.

    D = cost(shared) - sum of cost(alone),    D / c ~ F(q, q (q + 2) / (3 A)),    c = q + 2 A - 6 A / (q + 2),
    A = sum of (trace(R_i^2) + trace(R_i)^2) / (2 f_i),    R_i = 1 - (sum of C_j^-1)^-1 C_i^-1,

q the difference in unknowns; A, small where the noise is known well, allows for noise that was estimated with f_i
degrees of freedom in each fly (Welch 1951, Biometrika 38, 330-336; Johansen 1980, Biometrika 67, 85-92).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.stats
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.identify.gains.alone import LoneFit
from flycontrol.identify.gains.least_squares import Loss, WeightedProblem, minimise
from flycontrol.identify.gains.model import GainModel
from flycontrol.identify.gains.problem import fit_problem
from flycontrol.model.trial import Trial

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Homogeneity:
    """Whether flies, or recordings, share the unknowns that a pooled fit shares."""

    kinds: tuple[str, ...]  #: the unknowns shared
    names: tuple[str, ...]  #: flies or recordings compared
    statistic: float  #: F
    unknowns: int  #: q, fewer when shared
    freedom: float  #: of the denominator
    p: float
    left_out: tuple[str, ...]  #: those that could not be fitted alone
    sentence: str


def homogeneity(
    trials: Sequence[Trial], model: GainModel, alone: Sequence[LoneFit], loss: Loss = "linear"
) -> Homogeneity:
    """Test whether the fits alone could have one set of shared unknowns.

    Parameters
    ----------
    trials, model, loss
        Those of the fits alone.
    alone
        From `fits_alone`.

    Raises
    ------
    InvalidInputError
        If fewer than two fits are usable, or the model shares nothing.
    """
    usable = [fit for fit in alone if fit.usable]
    if not alone or not alone[0].kinds:
        raise InvalidInputError("Nothing is shared in this model, so there is nothing that fits could differ in.")
    if len(usable) < 2:
        raise InvalidInputError(f"A test whether flies differ needs two that could be fitted, got {len(usable)}.")
    cost, free = _shared(trials, model, usable, loss)
    D = max(cost - sum(fit.cost for fit in usable), 0.0)
    q = sum(fit.free for fit in usable) - free
    A = _correction(usable)
    c, freedom = q + 2 * A - 6 * A / (q + 2), q * (q + 2) / (3 * A)
    p = float(scipy.stats.f.sf(D / c, q, freedom))
    left_out = tuple(fit.name for fit in alone if not fit.usable)
    kinds = usable[0].kinds
    return Homogeneity(
        kinds=kinds, names=tuple(fit.name for fit in usable), statistic=D / c, unknowns=q, freedom=freedom, p=p,
        left_out=left_out, sentence=_sentence(kinds, len(usable), p, left_out),
    )  # fmt: skip


def _shared(trials: Sequence[Trial], model: GainModel, usable: Sequence[LoneFit], loss: Loss) -> tuple[float, int]:
    """Least cost with shared unknowns and the noise of the fits alone; how many unknowns the data determine."""
    noise = {name: channels for fit in usable for name, channels in zip(fit.trials, fit.noise, strict=True)}
    problem = fit_problem([trial for trial in trials if trial.name in noise], model)
    start = {name: value for fit in usable for name, value in fit.minimum.items()}
    start |= dict(zip(usable[0].kinds, common_values(usable)[0].tolist(), strict=True))
    weighted = WeightedProblem(problem, [noise[part.trial.name] for part in problem.parts], loss)
    found = minimise(weighted, np.array([start[name] for name in problem.names]), scale=1.0)
    return found.at.cost, len(problem.names) - int(found.held.sum())


def common_values(usable: Sequence[LoneFit]) -> tuple[FloatArray, FloatArray]:
    """Mean (k,) of the estimates, weighted by their inverse covariances, and its covariance (k, k)."""
    weights = [np.linalg.inv(fit.covariance) for fit in usable]
    covariance = np.linalg.inv(np.sum(weights, axis=0))
    pull = np.sum([W @ fit.values for W, fit in zip(weights, usable, strict=True)], axis=0)
    return covariance @ pull, covariance


def _correction(usable: Sequence[LoneFit]) -> float:
    weights = [np.linalg.inv(fit.covariance) for fit in usable]
    total = np.linalg.inv(np.sum(weights, axis=0))
    rest = [np.eye(len(total)) - total @ W for W in weights]
    sizes = [np.trace(R @ R) + np.trace(R) ** 2 for R in rest]
    return float(sum(s / (2 * np.median(fit.freedom)) for s, fit in zip(sizes, usable, strict=True)))


def _sentence(kinds: Sequence[str], count: int, p: float, left_out: Sequence[str]) -> str:
    what = " and ".join([", ".join(kinds[:-1]), kinds[-1]] if len(kinds) > 1 else kinds)
    verdict = (
        f"The {count} fits differ in {what} by more than their noise (p = {p:.2g}): pool them with care, "
        "and report the spread between them."
        if p < 0.05
        else f"The {count} fits may share {what}: they differ no more than their noise lets expect (p = {p:.2g})."
    )
    return verdict + (f" Not compared, since not determined alone: {', '.join(left_out)}." if left_out else "")

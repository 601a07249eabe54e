"""Leave one recording out: gains from the others predict it; only what is its own (impulse, heading) is fitted to it.

The error is counted in degrees and in units of the recording's noise: 1 is a perfect prediction, since the noise stays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.identify.gains.labour import HERE, Labour
from flycontrol.identify.gains.least_squares import Minimum, WeightedProblem, minimise
from flycontrol.identify.gains.model import GainModel
from flycontrol.identify.gains.noise import Noise
from flycontrol.identify.gains.problem import FitProblem, fit_problem
from flycontrol.identify.gains.result import FitResult
from flycontrol.jobs.packed import Result
from flycontrol.jobs.work import Work
from flycontrol.units import deg

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Prediction:
    """One recording, predicted from the others."""

    trial: str
    fly: str
    error: float  #: root mean square of measured less predicted yaw [rad]
    noise: float  #: standard deviation of the recording's noise [rad]
    in_noise: float  #: root mean square of prediction errors over those of the noise, both one sample ahead
    score: float  #: whitened sum of squares, minus twice the logarithm of the likelihood but for a constant
    samples: int
    from_others: Mapping[str, float]  #: what the others say of the parameters, in the units of `response.UNITS`
    converged: bool
    sentence: str


def leave_one_out(
    found: FitResult,
    *,
    noise: Sequence[Sequence[Noise]] | None = None,
    labour: Labour = HERE,
) -> tuple[Prediction, ...]:
    """Predict every recording of a pooled fit from the others, refitted without it.

    Parameters
    ----------
    found
        The pooled fit, where each refit starts.
    noise
        By recording, by channel, to weigh and to count errors by: that of fits alone, or of a more general model, does
        not take this model's faults for noise. None: that of the pooled fit.
    labour
        Processes, folder for finished parts, progress.

    Raises
    ------
    InvalidInputError
        If there is only one recording.
    """
    trials = found.problem.trials
    if len(trials) < 2:
        raise InvalidInputError("Leaving one recording out needs two of them at least; one alone has no others.")
    task = partial(
        _left_out, problem=found.problem, x=found.minimum.x, noise=found.weighted.noise if noise is None else noise,
        loss=found.weighted.loss,
    )  # fmt: skip
    work = Work(task=task, items=range(len(trials)), seed=0, chunk=1, name="recordings left out")
    results = labour.done(work)
    return tuple(
        Prediction(trial=trial.name, fly=trial.fly, **cast("dict[str, Any]", result))
        for trial, result in zip(trials, results, strict=True)
    )


def _left_out(
    i: int, rng: np.random.Generator, *, problem: FitProblem, x: FloatArray, noise: Sequence[Sequence[Noise]], loss: Any
) -> Result:
    del rng
    at = dict(zip(problem.names, x.tolist(), strict=True))
    rest = fit_problem([trial for j, trial in enumerate(problem.trials) if j != i], problem.model)
    others = minimise(
        WeightedProblem(rest, [n for j, n in enumerate(noise) if j != i], loss), _start(rest, at), scale=1.0
    )
    learnt = dict(zip(rest.names, others.x.tolist(), strict=True))
    own, fixed = _own_problem(problem, i, learnt)
    weighted = WeightedProblem(own, [noise[i]], loss)
    fitted = minimise(weighted, _start(own, at), scale=1.0)
    return _prediction(weighted, fitted, fixed) | {"converged": others.converged and fitted.converged}


def _start(problem: FitProblem, at: Mapping[str, float]) -> FloatArray:
    return np.array([at[name] for name in problem.names])


def _own_problem(problem: FitProblem, i: int, learnt: Mapping[str, float]) -> tuple[FitProblem, dict[str, float]]:
    """The recording by itself with all parameters fixed that the others know; those parameters."""
    model, part = problem.model, problem.parts[i]
    fixed = {problem.kinds[k]: learnt[problem.names[k]] for k in part.places if problem.names[k] in learnt}
    unknown = {name: setting for name, setting in model.unknown.items() if name not in fixed}
    return fit_problem([part.trial], GainModel(unknown=unknown, known=dict(model.known) | fixed)), fixed


def _prediction(weighted: WeightedProblem, fitted: Minimum, fixed: dict[str, float]) -> dict[str, Any]:
    part, (noises,) = weighted.problem.parts[0], weighted.noise
    residuals = part.channels[0].values - part.predicted(fitted.x, False)[0][0]
    score = sum(float(rows[0] @ rows[0]) for rows in weighted.rows(fitted.x, False)[0])
    samples = weighted.problem.samples
    error, own = float(np.sqrt(np.mean(residuals**2))), noises[0].standard_deviation
    in_noise = float(np.sqrt(score / max(samples - len(fitted.x), 1)))
    return {
        "error": error, "noise": own, "in_noise": in_noise, "score": score, "samples": samples, "from_others": fixed,
        "sentence": (
            f"{part.trial.name}: the others' gains predict it to {error / deg:.2g} deg; its noise is {own / deg:.2g} "
            f"deg, and errors one sample ahead are {in_noise:.3g} times the noise's."
        ),
    }  # fmt: skip

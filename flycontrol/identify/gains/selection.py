"""P against PD against PI against PID on the yaw angle: AICc, BIC and cross-validation.

    AICc = -2 log L + 2 k + 2 k (k + 1) / (n - k - 1),    BIC = -2 log L + k log n,

L the largest likelihood, k the unknowns with those of the noise, n the samples. All models get noise of one order,
that of the most general model: a fault of a poor model must not pass for coloured noise of an order that the others
have not. Cross-validation scores what a fit says of samples that it has not seen, in the noise of the most general
model: recordings left out one by one, or blocks of a single recording left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.blocks import Held, blocks_left_out
from flycontrol.identify.gains.fit import fit_without_profiles
from flycontrol.identify.gains.labour import HERE, Labour
from flycontrol.identify.gains.left_out import leave_one_out
from flycontrol.identify.gains.model import GAINS, Controller, GainModel
from flycontrol.identify.gains.noise import Noise
from flycontrol.identify.gains.problem import standard_model
from flycontrol.identify.gains.result import FitResult
from flycontrol.model.trial import Trial
from flycontrol.units import deg

FloatArray = NDArray[np.float64]
_CLOSE = 2.0  #: a criterion's difference below which models are called equal (Burnham & Anderson 2002)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ControllerRow:
    """One controller in the comparison."""

    controller: Controller
    unknowns: int  #: k, those of the noise included
    deviance: float  #: minus twice the logarithm of the largest likelihood
    aicc: float
    bic: float
    weight: float  #: exp(-aicc difference / 2), normalised over the controllers
    scores: FloatArray  #: whitened sum of squares of each recording, or block, left out
    error: float  #: root mean square error of the samples left out [rad]; NaN without cross-validation
    values: Mapping[str, float]  #: estimates of what all recordings share
    converged: bool
    status: str  #: the fit's sentence

    @property
    def cross_validation(self) -> float:
        """Sum of `scores`, the smaller the better; NaN without cross-validation."""
        return float(self.scores.sum()) if len(self.scores) else float("nan")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ControllerComparison:
    """A table of controllers, the verdicts of three criteria, and a sentence."""

    rows: tuple[ControllerRow, ...]
    samples: int  #: n
    order: int  #: of the noise, the same for all
    validation: str  #: how cross-validation leaves samples out; empty if it was not asked for
    by_aicc: Controller
    by_bic: Controller
    by_cross_validation: Controller | None
    sentence: str

    def __getitem__(self, controller: Controller) -> ControllerRow:
        """The row of one controller; InvalidParameterError if it was not compared."""
        for row in self.rows:
            if row.controller == controller:
                return row
        raise InvalidParameterError(
            f"{controller!r} was not compared; there are {', '.join(row.controller for row in self.rows)}."
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Validation:
    """How samples are left out."""

    block: float = 0.010  #: length of a block of a single recording [s]; longer than the noise is correlated
    folds: int = 5  #: every fold-th block is left out at once

    def __post_init__(self) -> None:
        if not (self.block > 0 and np.isfinite(self.block)):
            raise InvalidParameterError(f"Validation.block must be > 0 s, got {self.block!r}.")
        if self.folds < 2:
            raise InvalidParameterError(f"Validation.folds must be at least 2, got {self.folds!r}.")


def compare_controllers(
    trials: Sequence[Trial],
    model: GainModel | None = None,
    controllers: Sequence[Controller] = ("P", "PD", "PI", "PID"),
    *,
    noise: str | int = "auto",
    validation: Validation | None = Validation(),
    labour: Labour = HERE,
) -> ControllerComparison:
    """Fit the same recordings with several controllers and compare.

    Parameters
    ----------
    model
        What else is known and what not; its controller does not matter. None: the standard model.
    controllers
        The most general one last.
    noise
        As in `fit_gains`; "auto" takes the largest order that the most general controller's residuals have.
    validation
        How blocks of a single recording are left out; several recordings are left out one by one. None: no
        cross-validation.
    labour
        For leaving recordings out.

    Raises
    ------
    InvalidParameterError
        For an unknown controller, fewer than two, or one named twice.
    """
    _refuse(controllers)
    base = standard_model(trials) if model is None else model
    models = [base.with_controller(controller) for controller in controllers]
    general = fit_without_profiles(trials, models[-1], noise=noise)
    order = max(n.order for channels in general.noise for n in channels)
    if noise == "auto":
        general = fit_without_profiles(trials, models[-1], noise=order, start=general.minimum.x)
    found = [*(fit_without_profiles(trials, each, noise=order) for each in models[:-1]), general]
    held = _held(found, general.noise, validation, labour)
    return _comparison(found, held, order, _how(trials, validation))


def _refuse(controllers: Sequence[Controller]) -> None:
    unknown = [name for name in controllers if name not in GAINS]
    if unknown:
        raise InvalidParameterError(f"Unknown controller {unknown[0]!r}; there are {', '.join(GAINS)}.")
    if len(set(controllers)) < 2 or len(set(controllers)) < len(controllers):
        raise InvalidParameterError(f"A comparison needs two or more different controllers, got {list(controllers)!r}.")


def _held(
    found: Sequence[FitResult], noise: Sequence[Sequence[Noise]], validation: Validation | None, labour: Labour
) -> list[Held]:
    """For each fit the scores and errors of what was left out."""
    if validation is None:
        return [Held(np.zeros(0), float("nan"))] * len(found)
    if len(found[0].problem.trials) == 1:
        return [blocks_left_out(fit, noise, validation.block, validation.folds) for fit in found]
    held: list[Held] = []
    for fit in found:
        predictions = leave_one_out(fit, noise=noise, labour=labour.on(fit.controller))
        squares = sum(p.error**2 * p.samples for p in predictions) / sum(p.samples for p in predictions)
        held.append(Held(np.array([p.score for p in predictions]), float(np.sqrt(squares))))
    return held


def _how(trials: Sequence[Trial], validation: Validation | None) -> str:
    if validation is None:
        return ""
    if len(trials) > 1:
        return "each recording predicted from the others"
    return f"blocks of {validation.block * 1e3:g} ms predicted from the rest of the recording"


def _comparison(found: Sequence[FitResult], held: Sequence[Held], order: int, validation: str) -> ControllerComparison:
    rows = [_row(fit, left) for fit, left in zip(found, held, strict=True)]
    relative = np.exp(-0.5 * (np.array([row.aicc for row in rows]) - min(row.aicc for row in rows)))
    table = tuple(
        replace(row, weight=float(weight / relative.sum())) for row, weight in zip(rows, relative, strict=True)
    )
    by_aicc, by_bic = min(table, key=lambda row: row.aicc), min(table, key=lambda row: row.bic)
    by_validation = min(table, key=lambda row: row.cross_validation) if validation else None
    return ControllerComparison(
        rows=table, samples=found[0].problem.samples, order=order, validation=validation,
        by_aicc=by_aicc.controller, by_bic=by_bic.controller,
        by_cross_validation=by_validation.controller if by_validation else None,
        sentence=_sentence(table, by_aicc, by_bic, by_validation),
    )  # fmt: skip


def _row(fit: FitResult, held: Held) -> ControllerRow:
    """One controller; its weight waits for the others."""
    n = fit.problem.samples
    k = len(fit.problem.names) - int(fit.minimum.held.sum())
    k += sum(1 + noise.order for channels in fit.noise for noise in channels)
    small = 2 * k * (k + 1) / (n - k - 1) if n > k + 1 else float("inf")
    shared = [setting.shared == "all" for setting in fit.problem.settings]
    return ControllerRow(
        controller=fit.controller, unknowns=k, deviance=fit.deviance, aicc=fit.deviance + 2 * k + small,
        bic=fit.deviance + k * float(np.log(n)), weight=float("nan"), scores=held.scores, error=held.error,
        values={e.name: e.value for e, common in zip(fit.estimates, shared, strict=True) if common},
        converged=fit.converged, status=fit.status,
    )  # fmt: skip


def _sentence(
    table: Sequence[ControllerRow], by_aicc: ControllerRow, by_bic: ControllerRow, by_validation: ControllerRow | None
) -> str:
    chosen = {"AICc": by_aicc, "BIC": by_bic} | ({"cross-validation": by_validation} if by_validation else {})
    names = {row.controller for row in chosen.values()}
    if len(names) == 1:
        criteria = " and ".join([", ".join(list(chosen)[:-1]), list(chosen)[-1]])
        verdict = f"{by_aicc.controller} on the yaw angle describes these recordings best by {criteria}"
    else:
        verdict = "The criteria disagree: " + ", ".join(f"{row.controller} by {name}" for name, row in chosen.items())
    near = [row for row in table if row is not by_aicc and row.aicc - by_aicc.aicc < _CLOSE]
    rest = [row for row in table if row is not by_aicc and row not in near]
    if near:
        verdict += f"; by AICc {' and '.join(row.controller for row in near)} cannot be told from {by_aicc.controller}"
    if rest:
        verdict += "; " + ", ".join(f"{row.controller} is worse by {row.aicc - by_aicc.aicc:.1f}" for row in rest)
        verdict += " in AICc"
    return verdict + _errors(table) + "."


def _errors(table: Sequence[ControllerRow]) -> str:
    if not len(table[0].scores):
        return ""
    return "; samples left out are missed by " + ", ".join(
        f"{row.error / deg:.2g} deg ({row.controller})" for row in table
    )

"""Is there anything to explain: does the fly respond at all, did the perturbation move it at all?

    F = (cost without - cost with) / q  against Fisher's F(q, n - k),

the cost without gains (and, for the perturbation, without impulse) minimised over what is left, noise as estimated with
them. The delay counts among the q, since it means nothing without gains.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import scipy.special
from numpy.typing import NDArray

from flycontrol.identify.gains.least_squares import Minimum, WeightedProblem, minimise
from flycontrol.identify.gains.model import GAINS
from flycontrol.identify.gains.problem import fit_problem
from flycontrol.identify.gains.uncertainty import LocalUncertainty

FloatArray = NDArray[np.float64]
_PLAIN = 100.0  #: Wald's statistic per unknown above which no refit is needed to see it
_LOST = ("delay", "limit", "paddling_gain", "damping")  #: have no trace without gains, or without motion


@dataclass(frozen=True, slots=True, kw_only=True)
class Significance:
    """A test of unknowns against zero."""

    p: float  #: probability of as much improvement by chance
    improvement: float  #: of the cost
    unknowns: int  #: that brought it


def response_test(weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty) -> Significance | None:
    """All unknown gains against none; None if there are none."""
    return _test(weighted, minimum, uncertainty, GAINS["PID"], GAINS["PID"], lost=("delay", "limit", "paddling_gain"))


def perturbation_test(
    weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty
) -> Significance | None:
    """All unknown impulses against none, and then no gains either; None if there are none."""
    return _test(weighted, minimum, uncertainty, ("impulse",), (*GAINS["PID"], "impulse"), lost=_LOST)


def _test(
    weighted: WeightedProblem,
    minimum: Minimum,
    uncertainty: LocalUncertainty,
    asked: Iterable[str],
    zeroed: Iterable[str],
    lost: Iterable[str],
) -> Significance | None:
    kinds = weighted.problem.kinds
    places = [i for i, kind in enumerate(kinds) if kind in set(asked)]
    if not places:
        return None
    C = uncertainty.covariance[np.ix_(places, places)]
    if minimum.converged and np.isfinite(C).all():
        wald = float(minimum.x[places] @ np.linalg.lstsq(C, minimum.x[places], rcond=None)[0])
        if wald > _PLAIN * len(places):
            return Significance(p=0.0, improvement=wald, unknowns=len(places))
    without = [i for i, kind in enumerate(kinds) if kind in {*zeroed, *lost}]
    improvement = _cost_without(weighted, minimum, set(zeroed), set(lost)) - minimum.at.cost
    freedom = max(weighted.problem.samples - len(kinds), 1)
    p = 1.0 - scipy.special.fdtr(len(without), freedom, max(improvement, 0.0) / len(without))
    return Significance(p=float(p), improvement=float(improvement), unknowns=len(without))


def _cost_without(weighted: WeightedProblem, minimum: Minimum, zeroed: set[str], lost: set[str]) -> float:
    """Cost with some unknowns at zero and those that then leave no trace at their estimates."""
    problem = weighted.problem
    model = problem.model
    kept = dict(zip(problem.kinds, minimum.x.tolist(), strict=True))
    known = {name: 0.0 if name in zeroed else kept[name] for name in (zeroed | lost) & set(kept)}
    unknown = {name: it for name, it in model.unknown.items() if name not in known}
    smaller = fit_problem(problem.trials, replace(model, unknown=unknown, known=dict(model.known) | known))
    values = dict(zip(problem.names, minimum.x.tolist(), strict=True))
    start = np.array([values[name] for name in smaller.names])
    return minimise(WeightedProblem(smaller, weighted.noise, weighted.loss), start, scale=1.0).at.cost

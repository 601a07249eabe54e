"""What else may be wrong where a fit misses: the least cost with one more unknown, for each that could be freed.

A score test of something that was held asks only whether it explains what is left. A wrong controller, or a wrong value
of what was fixed, leaves what looks like a shifted onset; only a fit with each of them free tells which explains more.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from flycontrol.identify.gains.least_squares import Minimum, WeightedProblem, minimise
from flycontrol.identify.gains.model import GAINS, GainModel, standard_unknown
from flycontrol.identify.gains.problem import fit_problem

_OF_THE_LOOP = ("kp", "kd", "ki", "delay", "damping")
_USUAL_DELAY = 3 / 220.0  #: three wingbeats at 220 Hz (review, section 6) [s]
_CLEARLY = 6.6  #: of D: 1 % of a chi-squared variable with one degree of freedom is larger


@dataclass(frozen=True, slots=True, kw_only=True)
class Alternative:
    """One thing that was held, or left out of the controller."""

    kind: str
    gain: float  #: by which the cost falls if it is estimated too


def best_alternative(weighted: WeightedProblem, minimum: Minimum, held: Iterable[str] = ()) -> Alternative | None:
    """The gain or fixed parameter of the loop, or one `held` besides, whose estimate would explain most.

    None if all are estimated.
    """
    model = weighted.problem.model
    loop = [
        kind for kind in _OF_THE_LOOP if kind in model.known or (kind in GAINS["PID"] and _is_left_out(kind, model))
    ]
    found = [Alternative(kind=kind, gain=gain_of_freeing(weighted, minimum, kind)) for kind in (*loop, *held)]
    return max(found, key=lambda each: each.gain, default=None)


def clearly_better(one: float, other: float) -> bool:
    """Whether a fall of the cost exceeds another by more than chance."""
    return one > other + _CLEARLY


def gain_of_freeing(weighted: WeightedProblem, minimum: Minimum, kind: str) -> float:
    """By how much the cost falls where one more parameter is estimated, noise as it is."""
    problem = weighted.problem
    model = problem.model
    known = {name: value for name, value in model.known.items() if name != kind}
    wider = fit_problem(
        problem.trials, replace(model, unknown=dict(model.unknown) | {kind: standard_unknown(kind)}, known=known)
    )
    values = dict(zip(problem.names, minimum.x.tolist(), strict=True))
    start = [values.get(name, model.known.get(each, 0.0)) for name, each in zip(wider.names, wider.kinds, strict=True)]
    again = WeightedProblem(wider, weighted.noise, weighted.loss)
    usual = [_USUAL_DELAY if each == "delay" else value for each, value in zip(wider.kinds, start, strict=True)]
    costs = [minimise(again, np.array(x), scale=1.0).at.cost for x in (start, usual)]
    return minimum.at.cost - min(costs)


def _is_left_out(kind: str, model: GainModel) -> bool:
    return kind in GAINS["PID"] and kind not in model.unknown and kind not in model.known

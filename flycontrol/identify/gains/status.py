"""What came of a fit, in sentences: the first says whether its numbers can be used, the next what to mend."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flycontrol.identify.gains.data_limits import what_the_data_cannot_say
from flycontrol.identify.gains.least_squares import Minimum, WeightedProblem
from flycontrol.identify.gains.result import Estimate
from flycontrol.identify.gains.score import score_tests
from flycontrol.identify.gains.significance import perturbation_test, response_test
from flycontrol.identify.gains.uncertainty import LocalUncertainty

_LEVEL = 0.01  #: of tests; shared among the score tests
_BLIND = 0.1  #: weight in a combination without trace, from which an unknown is named


def status(
    weighted: WeightedProblem,
    minimum: Minimum,
    uncertainty: LocalUncertainty,
    estimates: Sequence[Estimate],
    nothing: str,
) -> str:
    """The sentences; `nothing` is what `nothing_there` said.

    An unknown counts as not identifiable if half its interval is wider than its use: than half the estimate for the
    delay, than the estimate for K_P and damping, than sqrt(K_P) for K_D, as much as changes the loop's damping ratio
    by a half.
    """
    first = (
        nothing
        or _not_converged(minimum)
        or _without_trace(weighted, uncertainty)
        or _useless(estimates)
        or _at_a_bound(estimates)
        or "converged: one minimum inside all bounds."
    )
    return " ".join([first, *_held_too_tightly(weighted, minimum, uncertainty)])


def nothing_there(weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty) -> str:
    """A sentence if the data cannot say anything, no perturbation is visible or no response found; otherwise empty."""
    limits = what_the_data_cannot_say(weighted.problem)
    if limits:
        return limits
    moved = perturbation_test(weighted, minimum, uncertainty)
    if moved is not None and moved.p > _LEVEL:
        return (
            f"no perturbation visible: noise alone explains the yaw as well (F test, p = {moved.p:.2g}); "
            "check the onset and the strength, or leave these recordings out."
        )
    response = response_test(weighted, minimum, uncertainty)
    if response is not None and response.p > _LEVEL:
        return (
            f"no response found: a fly without control explains the yaw as well (F test, p = {response.p:.2g}); "
            "longer recordings or stronger perturbations could show one."
        )
    return ""


def _not_converged(minimum: Minimum) -> str:
    if minimum.converged:
        return ""
    return f"not converged: the search stopped after {minimum.steps} steps; give starting values or fix a parameter."


def _without_trace(weighted: WeightedProblem, uncertainty: LocalUncertainty) -> str:
    if not len(uncertainty.unidentifiable):
        return ""
    weights = np.abs(uncertainty.unidentifiable).max(axis=0)
    lost = [name for name, weight in zip(weighted.problem.names, weights, strict=True) if weight > _BLIND]
    return f"not identifiable: {' and '.join(lost)} trade off without trace in these data; fix one or add recordings."


def _useless(estimates: Sequence[Estimate]) -> str:
    kp = next((e.value for e in estimates if e.kind == "kp"), np.inf)
    scale = {"kd": np.sqrt(abs(kp))}
    share = {"delay": 0.5, "kp": 1.0, "damping": 1.0}
    wide = [
        e
        for e in estimates
        if e.kind in {*share, *scale}
        and not 0.5 * (e.high - e.low) <= scale.get(e.kind, share.get(e.kind, 1.0) * abs(e.value))
    ]
    if not wide:
        return ""
    said = [f"{e.name} from {e.low:.4g} to {e.high:.4g} {e.unit}" for e in wide]
    reason = next((f" ({e.name}: {e.open_because})" for e in wide if e.open_because), "")
    return (
        f"not identifiable: the intervals are too wide for use, {', '.join(said)}{reason}; fix one or add recordings."
    )


def _at_a_bound(estimates: Sequence[Estimate]) -> str:
    held = [e.name for e in estimates if e.at_bound]
    if not held:
        return ""
    return f"at a bound: {' and '.join(held)}; the data pull further, so widen the bound or doubt the model."


def _held_too_tightly(weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty) -> list[str]:
    """The most significant score test that passes, the level shared among all of them; of a recording fitted alone.

    Where several share gains, differences between the flies would pass for a shifted onset.
    """
    if not minimum.converged or len(weighted.problem.parts) > 1:
        return []
    tests = score_tests(weighted, minimum, uncertainty)
    passed = [test for test in tests if test.p * len(tests) < _LEVEL]
    return [test.sentence for test in passed[:1]]

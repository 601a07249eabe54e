"""What came of a fit, in sentences: the first says whether its numbers can be used, the next what to mend."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flycontrol.identify.gains.alternatives import best_alternative, clearly_better, gain_of_freeing
from flycontrol.identify.gains.data_limits import what_the_data_cannot_say
from flycontrol.identify.gains.least_squares import Minimum, WeightedProblem
from flycontrol.identify.gains.model import GAINS, Unknown, standard_unknown
from flycontrol.identify.gains.result import Estimate
from flycontrol.identify.gains.score import ScoreTest, score_tests
from flycontrol.identify.gains.significance import perturbation_test, response_test
from flycontrol.identify.gains.spoken import spoken, spoken_range
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
    by a half. What lies at a bound is said before, since widening the bound may mend the rest.
    """
    bound = _at_a_bound(weighted, minimum, estimates)
    vague = _without_trace(weighted, uncertainty) or _useless(weighted, estimates)
    first = nothing or _not_converged(minimum) or " ".join(said for said in (bound, vague) if said)
    rest = [*_never_saturated(estimates), *_held_too_tightly(weighted, minimum, uncertainty)]
    return " ".join([first or "converged: one minimum inside all bounds.", *rest])


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
    return (
        f"not converged: the search stopped after {minimum.steps} steps, so the estimates mean nothing; fix what is "
        "known, or bound it where it can lie."
    )


def _without_trace(weighted: WeightedProblem, uncertainty: LocalUncertainty) -> str:
    if not len(uncertainty.unidentifiable):
        return ""
    weights = np.abs(uncertainty.unidentifiable).max(axis=0)
    lost = [name for name, weight in zip(weighted.problem.names, weights, strict=True) if weight > _BLIND]
    said = f"{' and '.join(lost)} trade off" if len(lost) > 1 else f"{lost[0]} is"
    return f"not identifiable: {said} without trace in these data; fix one or add recordings."


def _useless(weighted: WeightedProblem, estimates: Sequence[Estimate]) -> str:
    kp = next((e.value for e in estimates if e.kind == "kp"), np.inf)
    scale = {"kd": np.sqrt(abs(kp))}
    share = {"delay": 0.5, "kp": 1.0, "damping": 1.0}
    wide = [
        e
        for e, setting in zip(estimates, weighted.problem.settings, strict=True)
        if e.kind in {*share, *scale}
        and not _is_cut(e)
        and not _half_width(e, setting) <= scale.get(e.kind, share.get(e.kind, 1.0) * abs(e.value))
    ]
    if not wide:
        return ""
    said = [f"{e.name} {spoken_range(e.low, e.high, e.unit)}" for e in wide]
    reason = next((f" ({e.name}: {e.open_because})" for e in wide if e.open_because), "")
    return (
        f"not identifiable: the intervals are too wide for use, {', '.join(said)}{reason}; fix one or add recordings."
    )


def _is_cut(e: Estimate) -> bool:
    """Whether an estimate lies at a bound, and the data end its interval on the other side."""
    return e.at_bound and bool(np.isfinite(e.low) or np.isfinite(e.high))


def _half_width(e: Estimate, setting: Unknown) -> float:
    """Of an interval; what the user ruled out by a bound does not count as open."""
    standard = standard_unknown(e.kind)
    low = max(e.low, setting.low) if setting.low != standard.low else e.low
    high = min(e.high, setting.high) if setting.high != standard.high else e.high
    return 0.5 * (high - low)


def _at_a_bound(weighted: WeightedProblem, minimum: Minimum, estimates: Sequence[Estimate]) -> str:
    said: list[str] = []
    for i, (e, setting) in enumerate(zip(estimates, weighted.problem.settings, strict=True)):
        if not e.at_bound:
            continue
        standard, upper = standard_unknown(e.kind), minimum.x[i] >= setting.high
        side, end = ("upper", setting.high) if upper else ("lower", setting.low)
        own = end != (standard.high if upper else standard.low)
        whose, mend = ("your", "widen it, or doubt the model") if own else ("the", "doubt the model")
        said.append(f"the best {e.name} lies at {whose} {side} bound of {spoken(end, e.unit)}; {mend}")
    return f"at a bound: {'; '.join(said)}." if said else ""


def _never_saturated(estimates: Sequence[Estimate]) -> list[str]:
    return [
        f"{e.name} is not determined: the torque never saturates in these data, so it is at least "
        f"{spoken(e.low, e.unit, 2)}; leave it out."
        for e in estimates
        if e.kind == "limit" and np.isinf(e.value)
    ]


def _held_too_tightly(weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty) -> list[str]:
    """The most significant score test that passes, the level shared among all of them; of a recording fitted alone.

    Where several share gains, differences between the flies would pass for a shifted onset.
    """
    if not minimum.converged or len(weighted.problem.parts) > 1:
        return []
    tests = score_tests(weighted, minimum, uncertainty)
    passed = [test for test in tests if test.p * len(tests) < _LEVEL]
    return [
        _explained(weighted, minimum, test, [each.kind for each in tests if each is not test]) for test in passed[:1]
    ]


def _explained(weighted: WeightedProblem, minimum: Minimum, test: ScoreTest, others: Sequence[str]) -> str:
    """What the test found, unless a gain, or something else that is held, explains as much when it is freed."""
    other = best_alternative(weighted, minimum, others)
    if other is None:
        return test.sentence
    own = gain_of_freeing(weighted, minimum, test.kind)
    if clearly_better(own, other.gain):
        return f"{test.sentence} It removes more of the misfit than {other.kind} would."
    doubt = f"{test.trial}: either {test.what} or the model is wrong (score test, p = {test.p:.2g})"
    mend = f"choose a controller that has {other.kind}" if other.kind in GAINS["PID"] else f"estimate {other.kind}"
    if clearly_better(other.gain, own):
        return f"{doubt}; a free {other.kind} removes more of the misfit than {test.kind}, so {mend} first."
    return f"{doubt}; a free {other.kind} removes as much of the misfit, so {mend} or estimate {test.kind}."

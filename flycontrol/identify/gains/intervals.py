"""Estimates with intervals: by the covariance where the likelihood is a parabola, by its profile where it is not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import scipy.special
from numpy.typing import NDArray

from flycontrol.identify.gains.least_squares import Minimum, WeightedProblem, minimise
from flycontrol.identify.gains.profile import Profile, profiles
from flycontrol.identify.gains.response import UNITS
from flycontrol.identify.gains.result import Estimate
from flycontrol.identify.gains.saturation import least_limit, unreached
from flycontrol.identify.gains.uncertainty import LocalUncertainty

FloatArray = NDArray[np.float64]
_BENT = 0.1  #: relative departure of sqrt(D) from a straight line at the ends, above which profiles are computed
_RIDGE_STEPS = 2  #: from the tangent to the ridge
_MOVED = 0.1  #: of the half width, by which an end must move for the profile to replace the linear interval
_LINEAR = ("heading", "initial_yaw", "initial_rate", "impulse")  #: in which yaw is linear, or nearly so


def doubtful_profiles(
    weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty, level: float
) -> dict[str, Profile]:
    """Profiles of all unknowns if the likelihood bends within linear intervals or an unknown lies at its bound."""
    names = _doubtful(weighted, minimum, uncertainty, level) if minimum.converged else []
    return profiles(weighted, minimum, uncertainty, names, level)


def estimates(
    weighted: WeightedProblem,
    minimum: Minimum,
    uncertainty: LocalUncertainty,
    level: float,
    bent: Mapping[str, Profile],
) -> tuple[Estimate, ...]:
    """Every unknown with its interval: linear, unless its profile among `bent` says otherwise."""
    found = [_linear(weighted, minimum, uncertainty, level, i) for i in range(len(minimum.x))]
    return tuple(_profiled(e, bent[e.name]) if e.name in bent and _differs(e, bent[e.name]) else e for e in found)


def without_meaning(found: tuple[Estimate, ...], reason: str) -> tuple[Estimate, ...]:
    """The same where nothing was found: what describes the fly's control has no error and intervals without ends."""
    nothing = {"low": -np.inf, "high": np.inf, "standard_error": np.inf, "open_because": reason.partition(":")[0]}
    return tuple(e if e.kind in _LINEAR else replace(e, **nothing) for e in found)


def _linear(
    weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty, level: float, i: int
) -> Estimate:
    problem = weighted.problem
    if minimum.held[i] and not at_bound(weighted, minimum)[i]:
        return _unreached(weighted, minimum, uncertainty, level, i)
    error = float(np.sqrt(uncertainty.covariance[i, i]))
    width = float(scipy.special.stdtrit(uncertainty.freedom[i], 0.5 + level / 2)) * error
    bias = _bias(weighted, minimum, uncertainty, width, i)
    value = float(np.clip(minimum.x[i] - bias, problem.low[i], problem.high[i]))  # to the last bit
    kind, blind = problem.kinds[i], bool((np.abs(uncertainty.unidentifiable[:, i]) > 0.1).any())
    return Estimate(
        name=problem.names[i], kind=kind, unit=UNITS[kind], value=value, standard_error=error,
        low=value - width, high=value + width, freedom=float(uncertainty.freedom[i]),
        bias=bias, at_bound=bool(minimum.held[i]),
        open_because="other unknowns make up for it without trace in these data" if blind else "",
    )  # fmt: skip


def _bias(weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty, width: float, i: int) -> float:
    """What is taken off: no more than leads to a bound, and nothing where it would leave the interval.

    There, and where it would turn the sign of what the prediction is divided by, the expansion that it begins means
    nothing.
    """
    x, problem, bias = float(minimum.x[i]), weighted.problem, float(uncertainty.bias[i])
    reach = min(width, abs(x)) if i in problem.divisors else width
    if not abs(bias) <= reach:
        return 0.0
    return float(np.clip(bias, x - problem.high[i], x - problem.low[i]))


def _unreached(
    weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty, level: float, i: int
) -> Estimate:
    """A torque limit without effect: none is the best, and one end of its interval is known."""
    t = float(scipy.special.stdtrit(uncertainty.freedom[i], 0.5 + level / 2))
    kind = weighted.problem.kinds[i]
    return Estimate(
        name=weighted.problem.names[i], kind=kind, unit=UNITS[kind], value=np.inf, standard_error=np.inf,
        low=least_limit(weighted, minimum, i, t), high=np.inf, freedom=float(uncertainty.freedom[i]), bias=0.0,
        at_bound=False, method="profile", open_because="the torque never saturates in these data",
    )  # fmt: skip


def at_bound(weighted: WeightedProblem, minimum: Minimum) -> NDArray[np.bool_]:
    """Unknowns (k,) that a bound holds; a torque limit that is never reached is held, but by no bound."""
    problem, x = weighted.problem, minimum.x
    return minimum.held & ((x <= problem.low) | (x >= problem.high)) & ~unreached(weighted, x)


def _doubtful(weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty, level: float) -> list[str]:
    """All unknowns whose intervals may be false: none if sqrt(D) is straight between the ends of linear intervals."""
    problem = weighted.problem
    if len(uncertainty.unidentifiable):
        return []  # a valley without end: profiles would only walk along it
    bound = at_bound(weighted, minimum)
    seen = [i for i in range(len(problem.names)) if bound[i] or not minimum.held[i]]
    asked = [i for i in seen if problem.kinds[i] not in _LINEAR]
    if bound.any() or any(_bends(weighted, minimum, uncertainty, level, i) for i in asked):
        return [problem.names[i] for i in (seen if len(problem.parts) == 1 else asked)]
    return []


def _bends(weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty, level: float, i: int) -> bool:
    """Whether D differs from t^2 at an end of a linear interval, or the end is out of bounds.

    First on the ridge's tangent, where D is larger than on the ridge if that itself bends; then near the ridge.
    """
    problem, C = weighted.problem, uncertainty.covariance
    t = float(scipy.special.stdtrit(uncertainty.freedom[i], 0.5 + level / 2))
    for sign in (-1, 1):
        x = minimum.x + sign * t * C[:, i] / np.sqrt(C[i, i])
        if ((x < problem.low) | (x > problem.high)).any():
            return True
        if _is_bent(weighted.cost(x) - minimum.at.cost, t):
            ridge = minimise(weighted, x, most_steps=_RIDGE_STEPS, scale=1.0, fixed=(i,))
            if _is_bent(ridge.at.cost - minimum.at.cost, t):
                return True
    return False


def _is_bent(D: float, t: float) -> bool:
    return abs(np.sqrt(max(D, 0.0)) / t - 1.0) > _BENT


def _differs(estimate: Estimate, found: Profile) -> bool:
    width = 0.5 * (estimate.high - estimate.low)
    if not np.isfinite(width):
        return True
    centre = estimate.value + estimate.bias  # the linear interval around the same point as the profile
    return bool(max(abs(found.low - (centre - width)), abs(found.high - (centre + width))) > _MOVED * width)


def _profiled(estimate: Estimate, found: Profile) -> Estimate:
    value = float(np.clip(estimate.value, found.low, found.high))
    return replace(
        estimate, value=value, low=found.low, high=found.high, method="profile", open_because=found.open_because
    )

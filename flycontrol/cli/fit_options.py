"""What `flycontrol fit` is asked for: from texts with units, as in --fix damping="69 1/s", to a model."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flycontrol.errors import InvalidInputError

if TYPE_CHECKING:
    from flycontrol.identify.gains.apart import Shared
    from flycontrol.identify.gains.model import Controller, GainModel, Prior, Unknown
    from flycontrol.io.quantities import Kind

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_PRIOR = re.compile(rf"\s*({_NUMBER})\s*(?:\+-|\+/-|±)\s*({_NUMBER})\s*(.*)", re.DOTALL)
_ZERO = re.compile(r"[+-]?0*\.?0*")


@dataclass(frozen=True, slots=True, kw_only=True)
class FitRequest:
    """The options that say what is known and what is asked, as the user wrote them."""

    controller: str = "PD"
    fix: Sequence[str] = ()  #: "damping=69 1/s"
    estimate: Sequence[str] = ()  #: "onset_shift"
    prior: Sequence[str] = ()  #: "damping=69 +- 5 1/s"
    bound: Sequence[str] = ()  #: "delay=5 ms .. 30 ms"


def requested_model(request: FitRequest, *, paddling: bool) -> GainModel:
    """Build the model that the options describe.

    Parameters
    ----------
    paddling
        Paddling was measured: its gain is estimated unless it is fixed.

    Raises
    ------
    InvalidInputError, InvalidParameterError
        Which option, what it needs, what it got.
    """
    from flycontrol.identify.gains.model import GAINS, gain_model

    controller = _controller(request.controller)
    fixed = {name: _quantity(name, text, "--fix") for name, text in _pairs(request.fix, "--fix").items()}
    estimate = [_known(name, "--estimate") for name in request.estimate]
    if paddling and "paddling_gain" not in (*fixed, *estimate):
        estimate.append("paddling_gain")
    settings = _settings(request, gain_model(controller, estimate=estimate, fixed=fixed))
    gains = set(GAINS["PID"]) - set(GAINS[controller])
    foreign = next((name for name in (*fixed, *settings) if name in gains), None)
    if foreign is not None:
        raise InvalidInputError(f"A {controller} controller has no {foreign}; choose another --controller.")
    return gain_model(controller, estimate=estimate, fixed=fixed, settings=settings)


def _controller(name: str) -> Controller:
    from flycontrol.identify.gains.model import GAINS

    for known in GAINS:
        if name.upper() == known:
            return known
    raise InvalidInputError(f"--controller must be one of {', '.join(GAINS)}, got '{name}'.")


def _settings(request: FitRequest, model: GainModel) -> dict[str, Unknown]:
    """Standard unknowns with the bounds, priors and sharing that were asked for."""
    from dataclasses import replace

    bounds, priors = _pairs(request.bound, "--bound"), _pairs(request.prior, "--prior")
    settings: dict[str, Unknown] = {}
    for name in (*bounds, *priors):
        if name not in model.unknown:
            option = "--bound" if name in bounds else "--prior"
            why = "it is fixed" if name in model.known else "it is not estimated"
            raise InvalidInputError(f"{option} is given for {name}, but {why}; add --estimate {name}, or leave it out.")
    for name, unknown in model.unknown.items():
        if name in bounds:
            ends = {"low": unknown.low, "high": unknown.high} | _bounds(name, bounds[name])
            _refuse_bounds(name, bounds[name], ends)
            unknown = replace(unknown, **ends)  # noqa: PLW2901
        if name in priors:
            unknown = replace(unknown, prior=_prior(name, priors[name]))  # noqa: PLW2901
        settings[name] = unknown
    return settings


def requested_sharing(word: str) -> Shared:
    """Whose loop is the same; InvalidInputError for another word."""
    for known in ("auto", "all", "fly", "trial"):
        if word == known:
            return known
    raise InvalidInputError(f"--shared must be auto, all, fly or trial, got '{word}'.")


def _refuse_bounds(name: str, text: str, ends: dict[str, float]) -> None:
    if not ends["low"] < ends["high"]:
        raise InvalidInputError(
            f'--bound {name} is "{text}", but the lower end must lie below the upper one; an end left out is that of '
            "the search."
        )


def _bounds(name: str, text: str) -> dict[str, float]:
    low, dots, high = text.partition("..")
    if not dots or not (low.strip() or high.strip()):
        raise InvalidInputError(f'--bound {name} needs two ends such as "5 ms .. 30 ms", got "{text}".')
    found: dict[str, float] = {}
    if low.strip():
        bare = re.fullmatch(_NUMBER, low.strip()) is not None
        unit = re.sub(rf"^\s*{_NUMBER}", "", high) if bare else ""
        found["low"] = _quantity(name, low.strip() + unit, "--bound")
    if high.strip():
        found["high"] = _quantity(name, high, "--bound")
    return found


def _prior(name: str, text: str) -> Prior:
    from flycontrol.identify.gains.model import Prior

    parts = _PRIOR.fullmatch(text)
    if parts is None:
        raise InvalidInputError(f'--prior {name} needs a mean and a deviation such as "69 +- 5 1/s", got "{text}".')
    mean, deviation = (_quantity(name, f"{number} {parts[3]}".strip(), "--prior") for number in parts.group(1, 2))
    if not deviation > 0:
        raise InvalidInputError(f'--prior {name} needs a deviation > 0, got "{text}".')
    return Prior(mean=mean, deviation=deviation)


def _pairs(texts: Sequence[str], option: str) -> dict[str, str]:
    """Name and text of each NAME=VALUE."""
    found: dict[str, str] = {}
    for text in texts:
        name, sign, value = text.partition("=")
        name = _known(name.strip(), option) if sign else name
        if not sign or not value.strip():
            raise InvalidInputError(f'{option} needs NAME=VALUE such as damping="69 1/s", got "{text}".')
        if name in found:
            raise InvalidInputError(f"{option} is given twice for {name}; leave one out.")
        found[name] = value.strip()
    return found


def _known(name: str, option: str) -> str:
    from flycontrol.identify.gains.response import NAMES

    if name not in NAMES:
        raise InvalidInputError(f"{option} names an unknown parameter, '{name}'; there are {', '.join(NAMES)}.")
    return name


def _quantity(name: str, text: str, option: str) -> float:
    """In SI units; a bare 0 is 0 in any unit."""
    from flycontrol.io.quantities import read_quantity

    if _ZERO.fullmatch(text) and any(digit == "0" for digit in text):
        return 0.0
    return read_quantity(text, *_kinds(name), key=name, where=option).value


def _kinds(name: str) -> tuple[Kind, ...]:
    from flycontrol.io import quantities as q

    rate = q.Kind("a rate", "1/s", "69 1/s")  # in Hz, cycles a second, it would be read differently
    cubed = q.Kind("a cubed rate", "1/s^3", "6e4 1/s^3")
    return {
        "kp": (q.RATE_SQUARED,),
        "kd": (rate,),
        "ki": (cubed,),
        "delay": (q.TIME,),
        "damping": (rate,),
        "limit": (q.RATE_SQUARED, q.ANGULAR_ACCELERATION),
        "impulse": (q.ANGULAR_VELOCITY,),
        "onset_shift": (q.TIME,),
        "initial_yaw": (q.ANGLE,),
        "initial_rate": (q.ANGULAR_VELOCITY,),
        "heading": (q.ANGLE,),
        "paddling_gain": (q.Kind("a squared rate per angle", "1/s^2/rad", "4e4 1/s^2/rad"), q.RATE_SQUARED),
    }[name]

"""What a fit takes for known and what it asks: parameters, fixed or unknown, shared or one for each trial."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import Literal

import numpy as np

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.response import NAMES, UNITS
from flycontrol.units import ms

Sharing = Literal["all", "fly", "trial"]
Controller = Literal["P", "PD", "PI", "PID"]

#: Gains that a controller on the yaw angle has.
GAINS: dict[Controller, tuple[str, ...]] = {
    "P": ("kp",),
    "PD": ("kp", "kd"),
    "PI": ("kp", "ki"),
    "PID": ("kp", "kd", "ki"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Prior:
    """What is known beforehand, as a normal distribution."""

    mean: float
    deviation: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.mean) and self.deviation > 0 and np.isfinite(self.deviation)):
            raise InvalidParameterError(
                f"A prior needs a finite mean and a deviation > 0, got {self.mean!r} and {self.deviation!r}."
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Unknown:
    """A parameter to be estimated, in the unit of `response.UNITS`."""

    start: float | None = None  #: where the search begins; None: from the data
    low: float = -np.inf
    high: float = np.inf
    prior: Prior | None = None
    shared: Sharing = "all"  #: one value for all trials, for those of each fly, or for each trial

    def __post_init__(self) -> None:
        if not self.low < self.high:
            raise InvalidParameterError(f"The lower bound {self.low!r} must lie below the upper one {self.high!r}.")
        if self.start is not None and not self.low <= self.start <= self.high:
            raise InvalidParameterError(
                f"The start {self.start!r} lies outside of the bounds {self.low!r} to {self.high!r}."
            )


_STANDARD: dict[str, Unknown] = {
    "kp": Unknown(low=-1e5, high=1e5),  # thirty times the published fly's: beyond it a search is astray
    "kd": Unknown(low=-1e3, high=1e3),
    "ki": Unknown(low=-1e7, high=1e7),
    "delay": Unknown(low=1 * ms, high=60 * ms),
    "damping": Unknown(low=0.0, high=2e3),
    "limit": Unknown(low=1.0, high=1e7),  # a thousand times what recoveries need
    "paddling_gain": Unknown(),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class GainModel:
    """psi'' = -b psi' - (kp psi + kd psi' + ki integral of psi)(t - T) + N_ext / I, what is known of it and what not.

    A parameter that is left out is zero (no saturation for the limit). The controller acts on the yaw angle.
    """

    unknown: Mapping[str, Unknown]
    known: Mapping[str, float] = field(default_factory=dict[str, float])

    def __post_init__(self) -> None:
        for name in (*self.unknown, *self.known):
            if name not in UNITS:
                raise InvalidParameterError(f"Unknown parameter {name!r}; there are {', '.join(NAMES)}.")
        both = set(self.unknown) & set(self.known)
        if both:
            raise InvalidParameterError(f"{sorted(both)[0]} is both fixed and to be estimated; choose one.")
        for name, value in self.known.items():
            if not (isinstance(value, Real) and np.isfinite(value)):  # float() of a CasADi symbol would be NaN
                raise InvalidParameterError(f"{name} must be a finite number of {UNITS[name]}, got {value!r}.")
        if "delay" not in self.unknown and not self.known.get("delay", 0.0) > 0:
            raise InvalidParameterError("The delay must be estimated, or fixed at a value > 0 s.")

    @property
    def controller(self) -> Controller:
        """P, PD, PI or PID by the gains that are not zero."""
        has = {name for name in ("kd", "ki") if name in self.unknown or self.known.get(name, 0.0)}
        return "PID" if len(has) == 2 else "PD" if "kd" in has else "PI" if "ki" in has else "P"

    def with_controller(self, controller: Controller) -> GainModel:
        """The same model with another controller; gains that it has and this model lacks become unknown."""
        gains = GAINS[controller]
        unknown = {name: it for name, it in self.unknown.items() if name not in GAINS["PID"] or name in gains}
        known = {name: value for name, value in self.known.items() if name not in GAINS["PID"] or name in gains}
        missing = {name: _STANDARD[name] for name in gains if name not in unknown and name not in known}
        return replace(self, unknown=missing | unknown, known=known)


def standard_unknown(name: str) -> Unknown:
    """How a parameter is estimated unless something else is asked for."""
    if name not in UNITS:
        raise InvalidParameterError(f"Unknown parameter {name!r}; there are {', '.join(NAMES)}.")
    return _STANDARD[name] if name in _STANDARD else Unknown(shared="trial")


def gain_model(
    controller: Controller = "PD",
    *,
    estimate: Sequence[str] = (),
    fixed: Mapping[str, float] | None = None,
    settings: Mapping[str, Unknown] | None = None,
) -> GainModel:
    """The standard model: gains, delay, damping, and each trial's impulse, heading, initial yaw and rate unknown.

    Parameters
    ----------
    controller
        On the yaw angle.
    estimate
        Further parameters to estimate: onset_shift, limit, paddling_gain, ki.
    fixed
        Values of parameters that are not to be estimated, in the units of `response.UNITS`.
    settings
        Bounds, priors, starts and sharing that replace the standard ones, by name.

    Raises
    ------
    InvalidParameterError
        For an unknown name, or a parameter both fixed and to be estimated.
    """
    known = dict(fixed or {})
    for name in (*estimate, *(settings or {})):
        if name in known:
            raise InvalidParameterError(f"{name} is both fixed and to be estimated; choose one.")
    asked = [*GAINS[controller], "delay", "damping", "impulse", "heading", "initial_yaw", "initial_rate"]
    every: dict[str, None] = dict.fromkeys([*asked, *estimate, *(settings or {})])
    names = [name for name in every if name not in known]
    standard = {name: standard_unknown(name) for name in names}
    return GainModel(unknown={name: (settings or {}).get(name, standard[name]) for name in names}, known=known)

"""What a fit found: estimates with intervals, how they hang together, and a status that is a sentence."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.least_squares import Minimum, WeightedProblem
from flycontrol.identify.gains.model import Controller
from flycontrol.identify.gains.noise import Noise
from flycontrol.identify.gains.problem import FitProblem
from flycontrol.identify.gains.profile import Profile, profile
from flycontrol.identify.gains.response import UNITS
from flycontrol.identify.gains.spoken import spoken, spoken_range
from flycontrol.identify.gains.uncertainty import LocalUncertainty
from flycontrol.model.yaw import YawLoop

FloatArray = NDArray[np.float64]
IntervalMethod = Literal["linear", "profile"]
#: With which sentences of a status begin that forbid the use of the estimates.
_USELESS = ("not converged:", "not identifiable:", "no perturbation visible", "no response found")


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """One unknown, corrected for the bias that the model's curvature causes."""

    name: str  #: "kp", or "impulse[trial 3]"
    kind: str  #: "kp", "impulse"
    unit: str
    value: float  #: infinite for a torque limit that is never reached
    standard_error: float  #: infinite where the data say nothing, or at a bound
    low: float  #: of the interval
    high: float
    freedom: float  #: degrees of freedom of the interval
    bias: float  #: taken off the least-squares value
    at_bound: bool
    method: IntervalMethod = "linear"  #: what gave the interval
    open_because: str = ""  #: why a side of the interval is infinite

    @property
    def undetermined(self) -> bool:
        """Whether the data say nothing of it: the value is one of many, and no error or end goes with it."""
        return not self.at_bound and all(math.isinf(it) for it in (self.low, self.high, self.standard_error))


def spoken_estimate(e: Estimate) -> str:
    """An estimate with its interval in everyday units: "13.6 ms (from 13.1 to 14.1 ms)"; alone "of any size"."""
    ends = spoken_range(e.low, e.high, e.unit)
    return ends if e.undetermined else f"{spoken(e.value, e.unit)} ({ends})"


@dataclass(frozen=True, eq=False)
class FitResult:
    """A fit of the yaw loop to perturbed trials."""

    problem: FitProblem
    weighted: WeightedProblem  #: with the noise found
    minimum: Minimum
    uncertainty: LocalUncertainty
    estimates: tuple[Estimate, ...]
    level: float  #: of the intervals
    converged: bool
    status: str  #: a sentence

    def __repr__(self) -> str:
        return f"<FitResult: {self.status}>"

    def __str__(self) -> str:
        """The status, then every estimate with its interval."""
        wide = max(len(e.name) for e in self.estimates)
        lines = [f"{e.name:{wide}}  {spoken_estimate(e)}" for e in self.estimates]
        return "\n".join([self.status, f"{100 * self.level:g} % intervals:", *lines])

    def __getitem__(self, name: str) -> Estimate:
        """The estimate of that name; InvalidParameterError, a KeyError's sentence, if there is none."""
        for estimate in self.estimates:
            if estimate.name == name:
                return estimate
        raise InvalidParameterError(
            f"No unknown is named {name!r}; there are {', '.join(e.name for e in self.estimates)}."
        )

    @property
    def usable(self) -> bool:
        """Whether the status lets the estimates be used: converged, something found, intervals narrow enough."""
        return self.converged and not any(word in self.status for word in _USELESS)

    @property
    def found_nothing(self) -> bool:
        """Whether the data say nothing of the loop: its unknowns have intervals without ends."""
        loop = [e for e in self.estimates if e.kind in ("kp", "kd", "ki", "delay", "damping")]
        return bool(loop) and all(np.isinf(e.low) and np.isinf(e.high) for e in loop)

    @property
    def controller(self) -> Controller:
        """P, PD, PI or PID on the yaw angle."""
        return self.problem.model.controller

    @property
    def covariance(self) -> FloatArray:
        """(k, k) in the order of `estimates`."""
        return self.uncertainty.covariance

    @property
    def correlation(self) -> FloatArray:
        """(k, k); NaN where a variance is infinite."""
        C = self.covariance
        deviation = np.sqrt(np.diag(C))
        with np.errstate(invalid="ignore"):
            return C / deviation / deviation[:, None]

    @property
    def noise(self) -> tuple[tuple[Noise, ...], ...]:
        """Of each trial, of each of its channels: yaw, then paddling."""
        return tuple(tuple(channels) for channels in self.weighted.noise)

    def value(self, kind: str) -> float:
        """A parameter that all trials share, estimated or fixed, in the unit of `response.UNITS`."""
        known = self.problem.model.known
        if kind in known:
            return float(known[kind])
        if kind not in UNITS:
            raise InvalidParameterError(f"Unknown parameter {kind!r}; there are {', '.join(UNITS)}.")
        return self[kind].value if kind in self.problem.names else 0.0

    def loop(self) -> YawLoop:
        """The fitted loop, for an inertia of one."""
        values = {name: self.value(name) for name in ("kp", "kd", "ki", "delay")}
        return YawLoop.from_rates(b=self.value("damping"), **values)

    def profile(self, name: str) -> Profile:
        """The profile likelihood of an unknown, at the level of the intervals."""
        return profile(self.weighted, self.minimum, self.uncertainty, name, self.level)

    def residuals(self) -> list[list[FloatArray]]:
        """Measured less predicted at the least-squares values, by trial, by channel (n,) [rad]."""
        return [
            [
                channel.values - rows[0]
                for channel, rows in zip(part.channels, part.predicted(self.minimum.x, False), strict=True)
            ]
            for part in self.problem.parts
        ]

    @property
    def deviance(self) -> float:
        """Minus twice the logarithm of the likelihood at the minimum, constants of the noise included."""
        total = self.minimum.at.cost
        for part, noises in zip(self.problem.parts, self.weighted.noise, strict=True):
            for channel, noise in zip(part.channels, noises, strict=True):
                n = len(channel.values)
                total += n * np.log(2 * np.pi * noise.deviation**2) + _start_terms(noise, len(channel.firsts))
        return float(total)


def _start_terms(noise: Noise, stretches: int) -> float:
    """Log determinant of the noise's correlation: every stretch begins with samples that are predicted less well."""
    orders = np.arange(1, noise.order + 1)
    return float(-stretches * np.sum(orders * np.log1p(-(noise.pacf**2))))

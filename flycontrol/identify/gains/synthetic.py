"""A synthetic experiment whose truth is known: several flies, pulses of several strengths, noise as cameras have it.

Measured yaw is heading + psi + ripple of the wingbeat + tracking noise, part of it correlated over a millisecond; some
samples are missing. Paddling is known once a wingbeat, at the middle of the forward stroke.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.signal
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.response import yaw_response
from flycontrol.jobs.work import generator
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg, ms

FloatArray = NDArray[np.float64]

#: Means over flies, in the units of `response.UNITS`; the gains are the package's nominal ones, certainty C.
POPULATION: dict[str, float] = {
    "kp": 3050.0, "kd": 45.0, "delay": 13.6 * ms, "damping": 69.0, "paddling_gain": 4e4,
}  # fmt: skip
#: Spread between flies, as a fraction of the mean.
SPREAD: dict[str, float] = {"kp": 0.08, "kd": 0.08, "delay": 0.03, "damping": 0.08, "paddling_gain": 0.08}
PULSE = Pulse(onset=0.0, duration=4.5 * ms)
IMPULSES = (10.0, -20.0, 35.0, -50.0)  #: angular impulse of each trial of a fly [rad/s]

_RATE = 8000.0  #: [1/s]
_START, _END = -10 * ms, 110 * ms
_WINGBEAT = 220.0  #: [1/s]
_WHITE, _COLOURED, _RIPPLE = 0.1 * deg, 0.2 * deg, 0.15 * deg
_CORRELATION_TIME = 1.2 * ms  #: 0.9 between samples
_PADDLING_NOISE = 0.25 * deg


@dataclass(frozen=True, slots=True, kw_only=True)
class SyntheticExperiment:
    """Trials and the truth behind them."""

    trials: tuple[Trial, ...]
    flies: dict[str, dict[str, float]]  #: parameters of each fly, in the units of `response.UNITS`
    impulses: dict[str, float]  #: angular impulse of each trial [rad/s]
    seed: int


def synthetic_experiment(seed: int = 0, flies: int = 5) -> SyntheticExperiment:
    """Simulate it; the same bytes for the same seed.

    Raises
    ------
    InvalidParameterError
        If there is no fly, or the seed is negative.
    """
    if flies < 1 or seed < 0:
        raise InvalidParameterError(f"A seed >= 0 and at least one fly are needed, got {seed} and {flies}.")
    trials: list[Trial] = []
    parameters: dict[str, dict[str, float]] = {}
    impulses: dict[str, float] = {}
    for k in range(flies):
        rng, fly = generator(seed, k), f"fly{k + 1}"
        parameters[fly] = {name: mean * (1 + SPREAD[name] * _spread(rng)) for name, mean in POPULATION.items()}
        frequency = _WINGBEAT * (1 + 0.03 * _spread(rng))
        for number, mean in enumerate(IMPULSES, start=1):
            name = f"{fly}_pulse{number}"
            impulses[name] = mean * (1 + 0.1 * _spread(rng))
            trials.append(_trial(name, fly, parameters[fly] | {"impulse": impulses[name]}, frequency, rng))
    return SyntheticExperiment(trials=tuple(trials), flies=parameters, impulses=impulses, seed=seed)


def _spread(rng: np.random.Generator) -> float:
    """A standard normal number, cut at two: no fly of another species among them."""
    return float(np.clip(rng.standard_normal(), -2, 2))


def _trial(name: str, fly: str, values: dict[str, float], frequency: float, rng: np.random.Generator) -> Trial:
    time = np.arange(round(_START * _RATE), round(_END * _RATE) + 1) / _RATE
    values = values | {"initial_rate": 0.3 * _spread(rng), "heading": rng.uniform(-np.pi, np.pi)}
    clean = yaw_response(values, time, PULSE, torque=True)
    assert clean.fly is not None
    phase = rng.uniform(0, 1)
    yaw = clean.yaw + _tracking_noise(len(time), rng) + _RIPPLE * np.sin(2 * np.pi * (frequency * time + phase))
    paddling = clean.fly / values["paddling_gain"] + _PADDLING_NOISE * rng.standard_normal(len(time))
    middle = np.diff(np.floor(frequency * time + phase), prepend=np.nan) != 1
    paddling[middle] = np.nan
    yaw[_missing(len(time), rng)] = np.nan
    return Trial(name=name, fly=fly, time=time, yaw=yaw, rate=_RATE, perturbation=PULSE, paddling=paddling)


def _tracking_noise(n: int, rng: np.random.Generator) -> FloatArray:
    """White noise of the digitised outline, and noise that lasts for some frames."""
    r = float(np.exp(-1 / (_RATE * _CORRELATION_TIME)))
    innovations = rng.standard_normal(n + 200)  # more than ten correlation times to forget the start
    coloured = scipy.signal.lfilter([np.sqrt(1 - r**2)], [1, -r], innovations)[200:]
    return _WHITE * rng.standard_normal(n) + _COLOURED * np.asarray(coloured)


def _missing(n: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    """One frame in a hundred, and up to three stretches of at most 2 ms in which a wing hides the body."""
    missing = rng.uniform(size=n) < 0.01
    for _ in range(rng.integers(0, 4)):
        first = int(rng.integers(0, n - 16))
        missing[first : first + int(rng.integers(2, 17))] = True
    return missing

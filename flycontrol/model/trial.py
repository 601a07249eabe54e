"""A trial: the yaw of one perturbed fly over time, and what perturbed it. What a fit of the reflex takes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError, InvalidParameterError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pulse:
    """N_ext / I = angular_impulse / duration from onset to onset + duration: a torque pulse of known shape."""

    onset: float  #: [s] on the trial's clock
    duration: float  #: [s]
    angular_impulse: float | None = None  #: integral of N_ext / I [rad/s]; None: to be estimated

    def __post_init__(self) -> None:
        _refuse_infinite("Pulse.onset", "s", self.onset)
        _refuse_infinite("Pulse.duration", "s", self.duration)
        _refuse_infinite("Pulse.angular_impulse", "rad/s", self.angular_impulse)
        if not self.duration > 0:
            raise InvalidParameterError(f"Pulse.duration must be > 0 s, got {self.duration!r}.")


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueTrace:
    """N_ext / I = angular_acceleration_per_unit * drive(t): a recorded coil current or torque."""

    time: FloatArray  #: (k,) strictly increasing, on the trial's clock [s]
    drive: FloatArray  #: (k,) in `unit`, zero outside the range of `time`
    unit: str  #: "A", "V", "N m"
    angular_acceleration_per_unit: float | None = None  #: [1/s^2 per unit]; None: to be estimated

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", _read_only(self.time))
        object.__setattr__(self, "drive", _read_only(self.drive))
        _refuse_other_shape("TorqueTrace.drive", self.drive, self.time)
        _refuse_clock("TorqueTrace", self.time)
        if not np.all(np.isfinite(self.drive)):
            raise InvalidParameterError("TorqueTrace.drive must be finite; leave missing samples out.")
        _refuse_infinite("TorqueTrace.angular_acceleration_per_unit", "1/s^2", self.angular_acceleration_per_unit)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One perturbed fly: its yaw angle over time and what perturbed it."""

    name: str  #: unique among the trials of an experiment
    fly: str = ""  #: trials of the same fly share it; left out, it is the name
    time: FloatArray  #: (n,) strictly increasing, gaps allowed [s]
    yaw: FloatArray  #: (n,) unwrapped, positive to the right, NaN where missing [rad]
    rate: float  #: nominal samples a second [1/s]
    perturbation: Pulse | TorqueTrace | None  #: None: unknown, onset and strength are to be estimated
    paddling: FloatArray | None = None  #: (n,) d_alpha, right wing alpha0 + d_alpha, NaN where missing [rad]
    source_sha256: str = ""  #: hash of the file's bytes
    notes: Mapping[str, str] = field(default_factory=dict[str, str])  #: what the mapping says of its conventions

    def __post_init__(self) -> None:
        if not self.name:
            raise InvalidInputError("A trial needs a name, got an empty one.")
        object.__setattr__(self, "fly", self.fly or self.name)
        if not (self.rate > 0 and math.isfinite(self.rate)):
            raise InvalidInputError(f"{self.name}: the sampling rate must be > 0 1/s, got {self.rate!r}.")
        object.__setattr__(self, "time", _read_only(self.time))
        _refuse_clock(self.name, self.time)
        object.__setattr__(self, "yaw", self._channel("yaw", self.yaw))
        if np.count_nonzero(np.isfinite(self.yaw)) < 2:
            raise InvalidInputError(f"{self.name}: yaw has fewer than two samples; a trial needs more.")
        if self.paddling is not None:
            object.__setattr__(self, "paddling", self._channel("paddling", self.paddling))

    def _channel(self, name: str, values: FloatArray) -> FloatArray:
        channel = _read_only(values)
        _refuse_other_shape(f"{self.name}: {name}", channel, self.time)
        if np.any(np.isinf(channel)):
            raise InvalidInputError(f"{self.name}: {name} is infinite somewhere; mark what is missing with NaN.")
        return channel


def _read_only(values: FloatArray) -> FloatArray:
    copy = np.array(values, dtype=np.float64)
    copy.setflags(write=False)
    return copy


def _refuse_infinite(name: str, unit: str, value: float | None) -> None:
    if value is not None and not math.isfinite(value):
        raise InvalidParameterError(f"{name} must be a finite number of {unit}, got {value!r}.")


def _refuse_other_shape(name: str, values: FloatArray, time: FloatArray) -> None:
    if time.ndim != 1 or values.shape != time.shape:
        raise InvalidInputError(
            f"{name} has the shape {values.shape} where time has {time.shape}; one-dimensional arrays "
            "of one length are needed."
        )


def _refuse_clock(name: str, time: FloatArray) -> None:
    if time.ndim != 1 or time.size < 2 or not np.all(np.isfinite(time)):
        raise InvalidInputError(f"{name}: time needs two or more finite numbers in one dimension, got {time.shape}.")
    backward = np.flatnonzero(np.diff(time) <= 0)
    if backward.size:
        k = int(backward[0])
        raise InvalidInputError(f"{name}: time must increase, got {time[k + 1]:.9g} s after {time[k]:.9g} s.")

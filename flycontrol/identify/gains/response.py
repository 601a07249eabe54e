"""Yaw of one perturbed fly, exactly, and its derivatives with respect to every parameter.

    psi'' = -b psi' + N_ext/I - N(w(t)),   w(t) = (kp psi + kd psi' + ki integral of psi)(t - T)

with N(w) = w, or limit tanh(w / limit) where paddling saturates (review, Eq. 6-8, restoring gains positive; the
controller acts on the yaw angle). Before the recording the fly turned uniformly, psi = yaw + rate (t - start). Measured
yaw is heading + psi. The method of steps makes w known on panels no longer than the delay, cut at every kink (the
pulse's edges and all their images under the delay). There psi' = exp(-b t) (psi'(0) + integral of exp(b s) times the
torque), and integrals are those of interpolants at Chebyshev-Lobatto nodes. Derivatives obey the same equation, driven
by the response itself:

    s'' = -b s' + dN_ext/dp / I - N'(w) (kp s + kd s' + ki integral of s)(t - T) - N'(w) dw/dp,

where dw/dkp = psi(t - T), dw/dT = -w', and likewise; psi' is continuous, so the delay's derivative has no impulses.
The onset's derivative has them where the torque jumps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.kernels import march as kernels
from flycontrol.model.trial import Pulse, TorqueTrace

FloatArray = NDArray[np.float64]

#: Parameters of a trial in the order of the kernel, with their units.
UNITS: dict[str, str] = {
    "kp": "1/s^2",
    "kd": "1/s",
    "ki": "1/s^3",
    "delay": "s",
    "damping": "1/s",
    "limit": "1/s^2",
    "impulse": "rad/s",
    "onset_shift": "s",
    "initial_yaw": "rad",
    "initial_rate": "rad/s",
    "heading": "rad",
    "paddling_gain": "1/s^2 per rad",
}
NAMES: tuple[str, ...] = tuple(UNITS)
_RESTING: dict[str, float] = {"limit": np.inf, "paddling_gain": np.nan}


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """External acceleration N_ext / I for a unit impulse: straight pieces between knots, zero before the first."""

    knots: FloatArray  #: (k,) [s]
    levels: FloatArray  #: (k,) right of each knot [1/s]
    slopes: FloatArray  #: (k,) [1/s^2]
    majors: FloatArray  #: knots whose images under the delay are cut too [s]
    minors: FloatArray  #: the other knots [s]
    size: float  #: impulse of the drive as recorded, in its unit times seconds; 1 for a pulse

    @property
    def pieces(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """What the kernel takes."""
        return self.knots, self.levels, self.slopes


def pulse_drive(pulse: Pulse) -> Drive:
    """A rectangular pulse; the impulse is the integral of N_ext / I [rad/s]."""
    knots = np.array([pulse.onset, pulse.onset + pulse.duration])
    return Drive(knots, np.array([1.0 / pulse.duration, 0.0]), np.zeros(2), knots, np.zeros(0), 1.0)


def trace_drive(trace: TorqueTrace) -> Drive:
    """A recorded drive, straight between samples, divided by the integral of its size.

    Raises
    ------
    InvalidParameterError
        If the trace is zero throughout.
    """
    moving = np.flatnonzero(trace.drive)
    if len(moving) == 0:
        raise InvalidParameterError("The drive is zero throughout, so it perturbs nothing; leave the trace out.")
    first, last = max(moving[0] - 1, 0), min(moving[-1] + 1, len(trace.drive) - 1)
    time, drive = trace.time[first : last + 1], trace.drive[first : last + 1]
    size = float(np.sum(np.abs(drive[1:] + drive[:-1]) * np.diff(time)) / 2) or 1.0
    slopes = np.append(np.diff(drive) / np.diff(time), 0.0) / size
    levels = np.append(drive[:-1] / size, 0.0)
    corner = np.abs(np.diff(slopes, prepend=0.0)) * np.median(np.diff(time)) > 0.02 * np.abs(levels).max()
    corner[[0, -1]] = True
    return Drive(time, levels, slopes, time[corner], time[~corner], size)


def no_drive() -> Drive:
    """Nothing perturbs the fly."""
    return Drive(np.zeros(1), np.zeros(1), np.zeros(1), np.zeros(0), np.zeros(0), 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class YawResponse:
    """Yaw and the fly's torque at the times asked for, each with derivatives in the order of `names`."""

    yaw: FloatArray  #: measured yaw, heading + psi (n,) [rad]
    by_parameter: FloatArray  #: (m, n) d yaw / d parameter
    fly: FloatArray | None  #: N_fly / I (n,) [1/s^2]; None unless asked for
    fly_by_parameter: FloatArray | None  #: (m, n)
    names: tuple[str, ...]


def parameter_vector(values: Mapping[str, float]) -> FloatArray:
    """Values by name as the kernel takes them; what is left out is 0, no saturation.

    Raises
    ------
    InvalidParameterError
        For an unknown name, a value that is not a number, or a delay that is not > 0.
    """
    unknown = set(values) - set(NAMES)
    if unknown:
        raise InvalidParameterError(f"Unknown parameter {sorted(unknown)[0]!r}; there are {', '.join(NAMES)}.")
    p = np.array([float(values.get(name, _RESTING.get(name, 0.0))) for name in NAMES])
    for name, value in zip(NAMES, p, strict=True):
        if not np.isfinite(value) and name not in _RESTING:
            raise InvalidParameterError(f"{name} must be a finite number of {UNITS[name]}, got {value!r}.")
    if not p[kernels.DELAY] > 0:
        raise InvalidParameterError(f"delay must be > 0 s, got {p[kernels.DELAY]!r}.")
    return p


def yaw_response(
    values: Mapping[str, float],
    times: ArrayLike,
    perturbation: Pulse | TorqueTrace | None = None,
    *,
    derivatives: Sequence[str] = (),
    torque: bool = False,
) -> YawResponse:
    """Yaw of a perturbed fly at non-decreasing times [s], and its exact derivatives.

    Parameters
    ----------
    values
        Parameters by name, see `UNITS`; impulse is the angular impulse of the perturbation over the inertia.
    times
        Shape (n,); the first is the start, before which the fly turned uniformly, unless the perturbation began before.
    derivatives
        Names of the parameters to differentiate by.
    torque
        Give N_fly / I too.
    """
    p = parameter_vector(values)
    drive = drive_of(perturbation)
    at = np.ascontiguousarray(times, dtype=np.float64)
    active = np.array([NAMES.index(name) for name in derivatives], dtype=np.int64)
    yaw, fly = evaluate(p, active, drive, span_of(at, drive), at, torque)
    names = tuple(derivatives)
    return YawResponse(yaw[0], yaw[1:], *((fly[0], fly[1:]) if fly is not None else (None, None)), names)


def drive_of(perturbation: Pulse | TorqueTrace | None) -> Drive:
    """The external acceleration of a known perturbation for a unit impulse."""
    if perturbation is None:
        return no_drive()
    return pulse_drive(perturbation) if isinstance(perturbation, Pulse) else trace_drive(perturbation)


class Span(NamedTuple):
    """Of a simulation [s]."""

    start: float
    end: float


def span_of(times: FloatArray, drive: Drive) -> Span:
    """From the first time, or the drive's first edge if that is earlier, to the last time."""
    start = min([float(times[0]), *drive.majors[:1].tolist()])
    return Span(start, max(float(times[-1]), start + 1e-9))


def evaluate(
    p: FloatArray, active: NDArray[np.int64], drive: Drive, span: Span, times: FloatArray, torque: bool
) -> tuple[FloatArray, FloatArray | None]:
    """(1 + m, n) yaw with derivatives, and N_fly / I with derivatives if wanted, from the kernel."""
    edges, series, fly_series = kernels.march(
        p, active, span.start, span.end, drive.majors, drive.minors, drive.pieces, torque, kernels.RULE
    )
    yaw = np.empty((1 + len(active), len(times)))
    kernels.sampled(edges, series, times, yaw)
    yaw[0] += p[kernels.HEADING]
    yaw[1:][active == kernels.HEADING] = 1.0
    if not torque:
        return yaw, None
    fly = np.empty_like(yaw)
    kernels.sampled(edges, fly_series, times, fly)
    return yaw, fly

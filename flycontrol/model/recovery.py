"""Recovery of heading after a torque pulse: from its onset to the last entry of yaw into a band around zero."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.response import Response, response
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError, UnstableSystemError
from flycontrol.model.perturbation import TorquePulse
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg

_MOST_STEPS = 10_000  # delays or pulses, whichever is shorter, that a response is followed for
_SETTLED = 0.02  # a history this small against the band cannot leave it again unless the loop amplifies fiftyfold


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecoveryCurve:
    """Recovery time against the peak deflection of the same pulse at several strengths (Fig. 8c)."""

    peaks: FloatArray  #: peak deflection [rad], shape (k,)
    times: FloatArray  #: recovery time from pulse onset [s], shape (k,)
    jumps: FloatArray  #: peak deflections at which a later swing leaves the band and the time jumps [rad]
    swings: FloatArray  #: sizes of the successive extrema of yaw, as fractions of the peak
    tolerance: float  #: half width of the band [rad]


def pulse_response(system: DelayLTI, pulse: TorquePulse, end: float) -> Response:
    """Response of a loop's outputs to a torque pulse from rest, up to `end` [s]."""
    return response(system, end, [0.0, pulse.duration], [[pulse.torque], [0.0]])


def pulse_for_peak(loop: YawLoop, duration: float, peak: float) -> TorquePulse:
    """The pulse of this duration [s] whose largest deflection in this loop is `peak` [rad].

    Raises
    ------
    UnstableSystemError
        If the loop is unstable: its deflection has no largest value.
    """
    _require_stable(loop)
    unit = TorquePulse(duration=duration)
    reached, _ = settled_response(loop, unit, 1e-3).largest()
    return unit.times(peak / reached)


def recovery_time(loop: YawLoop, pulse: TorquePulse, tolerance: float = 2 * deg) -> float:
    """Time from pulse onset until yaw enters +-tolerance [rad] for the last time [s]; 0 if it never leaves the band.

    Raises
    ------
    UnstableSystemError
        If the loop is unstable: it never recovers.
    InvalidParameterError
        If the tolerance is not > 0.
    """
    if not tolerance > 0:
        raise InvalidParameterError(f"The tolerance of a recovery must be > 0 rad, got {tolerance!r}.")
    _require_stable(loop)
    whole = settled_response(loop, pulse, None, tolerance)
    return max(0.0, whole.last_time_outside(tolerance))


def recovery_curve(loop: YawLoop, duration: float, peaks: ArrayLike, tolerance: float = 2 * deg) -> RecoveryCurve:
    """Recovery time for each peak deflection [rad]; one response serves all, since the loop is linear.

    Raises
    ------
    UnstableSystemError
        If the loop is unstable.
    """
    _require_stable(loop)
    wanted = np.atleast_1d(np.asarray(peaks, dtype=np.float64))
    unit = TorquePulse(duration=duration)
    whole = settled_response(loop, unit, tolerance / wanted.max())
    reached, _ = whole.largest()
    times = [max(0.0, whole.last_time_outside(reached * tolerance / peak)) for peak in wanted]
    swings = _swings(whole) / reached
    later = swings[int(np.argmax(swings)) + 1 :]
    jumps = tolerance / later[later > tolerance / wanted.max()] if len(later) else later
    return RecoveryCurve(peaks=wanted, times=np.array(times), jumps=np.sort(jumps), swings=swings, tolerance=tolerance)


def settled_response(loop: YawLoop, pulse: TorquePulse, fraction: float | None, tolerance: float = 0.0) -> Response:
    """Pulse response long enough that yaw stays for good within `fraction` of its peak, or within `tolerance` [rad].

    The end is doubled until the yaw and scaled yaw rate of a whole delay stay within a fiftieth of the band.
    """
    system = loop.closed_loop()
    end = pulse.duration + 8 * max(loop.delay, pulse.duration)
    scale = np.sqrt(abs(loop.kp)) + loop.plant.damping_rate + abs(loop.kd) + np.cbrt(abs(loop.ki))
    step = min(loop.delay or pulse.duration, pulse.duration)
    while end < _MOST_STEPS * step:
        whole = pulse_response(system, pulse, end)
        band = tolerance if fraction is None else fraction * whole.largest()[0]
        last = whole.starts > end - max(loop.delay, pulse.duration)
        tail = whole.states[:-1][last]
        if np.abs(tail[:, 0]).max() <= _SETTLED * band and np.abs(tail[:, 1]).max() <= _SETTLED * band * scale:
            return whole
        end *= 2
    raise UnstableSystemError(
        f"Yaw has not settled after {end / 2:.3g} s, so no recovery is followed: the slowest mode of this loop is too "
        "near the boundary of stability, or its gains are far too small."
    )


def _swings(whole: Response) -> FloatArray:
    """Sizes |psi| of successive extrema of yaw: where the yaw rate, the second output, changes sign."""
    fine = np.unique(np.concatenate([whole.starts + f * whole.lengths for f in np.linspace(0, 1, 17)]))
    fine = fine[fine <= whole.end]
    rate = whole(fine)[1]
    k = np.flatnonzero(rate[1:] * rate[:-1] < 0)
    if len(k) == 0:
        return np.zeros(0)
    left, right, sign = fine[k], fine[k + 1], np.sign(rate[k])
    for _ in range(40):  # bisection of all brackets at once
        middle = (left + right) / 2
        before = whole(middle)[1] * sign > 0
        left, right = np.where(before, middle, left), np.where(before, right, middle)
    return np.abs(whole(right)[0])


def _require_stable(loop: YawLoop) -> None:
    abscissa = rightmost_roots(loop.closed_loop(), 1).abscissa
    if not abscissa < 0:
        raise UnstableSystemError(
            f"This loop is unstable (rightmost pole at {abscissa:+.4g} 1/s), so it never recovers; "
            "lower the gains or the delay."
        )

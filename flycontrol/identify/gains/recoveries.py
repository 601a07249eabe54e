"""Recovery time against strength, as measured and as the fitted loop predicts it (Fig. 8c).

Recovery ends with the last entry of yaw into the settled heading +-2 deg; the heading is the fit's. The yaw is smoothed
by a parabola in a sliding window, just wide enough that its standard error under the fitted noise is an eighth of the
band, so that noise makes no late exits. Where the smoothed yaw lies outside of the band by more than its error the fly
surely was outside; where it is less than its error inside, the fly may have been outside. The last such times bound the
recovery time. If the recording ends outside of the band, the fly has not recovered within it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.stats
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.problem import TrialPart
from flycontrol.identify.gains.response import NAMES
from flycontrol.identify.gains.result import FitResult
from flycontrol.identify.gains.smoothing import Smooth, smoothed
from flycontrol.units import deg, ms

FloatArray = NDArray[np.float64]
_SHARE = 0.125  #: standard error of the smoothed yaw, as a part of the band
_ONSET_SHIFT, _HEADING, _DELAY = (NAMES.index(name) for name in ("onset_shift", "heading", "delay"))


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredRecovery:
    """One recording: how far it was deflected and when it was back."""

    trial: str
    fly: str
    peak: float  #: largest deflection from the settled heading after the onset, its sign with it [rad]
    peak_error: float  #: its standard error [rad]
    heading: float  #: settled heading [rad]
    time: float  #: from onset to the last entry into the band [s]; 0 if it never left, infinite if it did not recover
    low: float  #: of the interval of `time` [s]
    high: float  #: infinite if the recording does not show that the fly is back
    recovered: bool
    sentence: str


def measured_recoveries(
    found: FitResult, tolerance: float = 2 * deg, level: float = 0.95
) -> tuple[MeasuredRecovery, ...]:
    """Recovery of every recording of a fit whose perturbation is known, by its samples.

    Parameters
    ----------
    tolerance
        Half width of the band around the settled heading [rad].
    level
        Of the intervals of recovery times.

    Raises
    ------
    InvalidParameterError
        If the tolerance is not > 0 or the level outside of (0, 1).
    """
    if not (tolerance > 0 and np.isfinite(tolerance)):
        raise InvalidParameterError(f"The tolerance of a recovery must be > 0 rad, got {tolerance!r}.")
    if not 0 < level < 1:
        raise InvalidParameterError(f"The level of intervals must lie between 0 and 1, got {level!r}.")
    return tuple(
        _measured(found, i, tolerance, level)
        for i, part in enumerate(found.problem.parts)
        if len(part.drive.majors) > 0
    )


def _measured(found: FitResult, i: int, tolerance: float, level: float) -> MeasuredRecovery:
    part, noise = found.problem.parts[i], found.noise[i][0]
    p = part.parameters(found.minimum.x)
    onset, heading = float(part.drive.majors[0] + p[_ONSET_SHIFT]), float(p[_HEADING])
    channel, before = part.channels[0], float(p[_DELAY]) / 2
    smooth = smoothed(channel.times, channel.values, noise, _SHARE * tolerance, before)
    after = smooth.times > onset
    if not after.any():
        raise InvalidParameterError(f"{part.trial.name}: the recording ends before the perturbation at {onset:.4g} s.")
    away = smooth.values[after] - heading
    error = np.hypot(smooth.errors[after], _heading_error(found, part))
    top = int(np.argmax(np.abs(away)))
    time, low, high = _entry(smooth.times[after] - onset, away, error, tolerance, (level, smooth))
    return MeasuredRecovery(
        trial=part.trial.name, fly=part.trial.fly, peak=float(away[top]), peak_error=float(error[top]), heading=heading,
        time=time, low=low, high=high, recovered=bool(np.isfinite(time)),
        sentence=_sentence(part.trial.name, float(away[top]), (time, low, high), float(smooth.times[-1]) - onset),
    )  # fmt: skip


def _heading_error(found: FitResult, part: TrialPart) -> float:
    """Standard error of the settled heading; 0 where it is known."""
    place = part.places[part.active == _HEADING]
    if not len(place):
        return 0.0
    variance = found.covariance[int(place[0]), int(place[0])]
    return float(np.sqrt(variance)) if np.isfinite(variance) else 0.0


def _entry(
    times: FloatArray, away: FloatArray, error: FloatArray, tolerance: float, certainty: tuple[float, Smooth]
) -> tuple[float, float, float]:
    """Last entry into the band and its interval, from the onset on [s]."""
    level, smooth = certainty
    each = (1 - level) / 2
    tries = max((times[-1] - times[0]) / smooth.window, 1.0)  # independent places at which noise may look like an exit
    surely, maybe = scipy.stats.norm.isf(each / tries), scipy.stats.norm.isf(each)
    size = np.abs(away)
    return (
        _last_above(times, size, tolerance),
        _last_above(times, size - surely * error, tolerance),
        _last_above(times, size + maybe * error, tolerance),
    )


def _last_above(times: FloatArray, size: FloatArray, tolerance: float) -> float:
    """When the size falls below the tolerance for the last time; 0 if never above, infinite if above at the end."""
    above = np.flatnonzero(size > tolerance)
    if not len(above):
        return 0.0
    k = int(above[-1])
    if k + 1 == len(times):
        return float("inf")
    return float(times[k] + (size[k] - tolerance) / (size[k] - size[k + 1]) * (times[k + 1] - times[k]))


def _sentence(name: str, peak: float, recovery: tuple[float, float, float], shown: float) -> str:
    time, low, high = recovery
    if not np.isfinite(time):
        return f"{name}: not recovered within the {shown / ms:.0f} ms that the recording shows after the onset."
    if time == 0:
        return f"{name}: never left the band."
    later = f"{high / ms:.1f} ms" if np.isfinite(high) else "after the recording's end"
    return f"{name}: {time / ms:.1f} ms ({low / ms:.1f} ms to {later}) from a peak of {abs(peak) / deg:.1f} deg."


def strongest(measured: Sequence[MeasuredRecovery]) -> float:
    """Largest peak deflection of all [rad]."""
    return max((abs(recovery.peak) for recovery in measured), default=0.0)

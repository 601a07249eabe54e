"""What a fit predicts for the recovery time at every strength, with the band that its uncertainty leaves (Fig. 8c).

Gains, damping and delay are drawn from Student's distribution with the fit's covariance; each draw is a loop with an
exact recovery curve. A draw that is unstable never recovers and counts as an infinite time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flycontrol.errors import InvalidInputError, InvalidParameterError, UnstableSystemError
from flycontrol.identify.gains.drawn_loops import drawn_loops, yaw_loops
from flycontrol.identify.gains.problem import FitProblem
from flycontrol.identify.gains.recoveries import MeasuredRecovery, measured_recoveries
from flycontrol.identify.gains.response import Drive
from flycontrol.identify.gains.result import FitResult
from flycontrol.model.recovery import recovery_curve
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg, ms

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecoveryBand:
    """Predicted recovery time against peak deflection."""

    peaks: FloatArray  #: (k,) [rad]
    times: FloatArray  #: (k,) of the estimates [s]
    low: FloatArray  #: (k,) of the band [s]
    high: FloatArray  #: (k,) infinite where too many draws are unstable [s]
    level: float  #: of the band
    draws: int
    unstable: int  #: draws that are
    duration: float  #: of the pulse [s]; for other perturbations that of the pulse of equal width
    tolerance: float  #: half width of the band around the heading [rad]
    seed: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecoveryAgainstStrength:
    """Fig. 8c: measured points beside the predicted band."""

    measured: tuple[MeasuredRecovery, ...]
    band: RecoveryBand  #: over a grid of strengths
    expected: RecoveryBand  #: at the measured peaks, in their order
    agreeing: int  #: recordings that show a recovery, whose interval meets the band
    sentence: str


def recovery_band(
    found: FitResult,
    peaks: ArrayLike,
    *,
    draws: int = 200,
    seed: int = 0,
    tolerance: float = 2 * deg,
    level: float = 0.95,
) -> RecoveryBand:
    """Recovery times that a fit predicts for peaks (k,) > 0 [rad].

    Raises
    ------
    InvalidInputError
        If the fitted loop is not determined or unstable, or nothing perturbed the flies.
    InvalidParameterError
        If a peak or the tolerance is not > 0.
    """
    wanted = np.atleast_1d(np.asarray(peaks, dtype=np.float64))
    if not (np.all(wanted > 0) and np.all(np.isfinite(wanted)) and tolerance > 0):
        raise InvalidParameterError(f"Peaks and tolerance must be > 0 rad, got {wanted.tolist()!r} and {tolerance!r}.")
    loops, duration = yaw_loops(drawn_loops(found, draws, seed)), pulse_width(found.problem)
    best = _times(found.loop(), duration, wanted, tolerance)
    if not np.all(np.isfinite(best)):
        raise InvalidInputError("The fitted loop is unstable, so it never recovers; doubt the fit before its band.")
    every = np.array([_times(each, duration, wanted, tolerance) for each in loops])
    rank = max(int((draws + 1) * (1 - level) / 2), 1)  # rounded outwards, so that few draws do not narrow the band
    low, high = np.sort(every, axis=0)[[rank - 1, draws - rank]]
    return RecoveryBand(
        peaks=wanted, times=best, low=low, high=high, level=level, draws=draws,
        unstable=int(np.isinf(every[:, 0]).sum()), duration=duration, tolerance=tolerance, seed=seed,
    )  # fmt: skip


def recovery_against_strength(
    found: FitResult, *, draws: int = 200, seed: int = 0, tolerance: float = 2 * deg, level: float = 0.95
) -> RecoveryAgainstStrength:
    """Measured recoveries of a fit's recordings beside the band that the fit predicts.

    Parameters and exceptions as of `recovery_band`.
    """
    measured = measured_recoveries(found, tolerance, level)
    if not measured:
        raise InvalidInputError("No recording has a known perturbation, so there is no onset to count from.")
    sizes = np.array([abs(recovery.peak) for recovery in measured])
    grid = np.linspace(1.02 * tolerance, max(1.2 * sizes.max(), 2 * tolerance), 80)
    both = recovery_band(
        found, np.concatenate([grid, sizes]), draws=draws, seed=seed, tolerance=tolerance, level=level
    )  # fmt: skip
    band, expected = (_part(both, which) for which in (slice(0, len(grid)), slice(len(grid), None)))
    agreeing = sum(
        recovery.recovered and recovery.low <= high and low <= recovery.high
        for recovery, low, high in zip(measured, expected.low, expected.high, strict=True)
    )
    return RecoveryAgainstStrength(
        measured=measured, band=band, expected=expected, agreeing=agreeing, sentence=_sentence(measured, agreeing)
    )


def pulse_width(problem: FitProblem) -> float:
    """Median of 1 / integral of u^2 for drives u of unit impulse: of a pulse its duration [s].

    Raises
    ------
    InvalidInputError
        If nothing perturbed the flies.
    """
    widths = [_width(part.drive) for part in problem.parts if len(part.drive.majors)]
    if not widths:
        raise InvalidInputError("No recording has a known perturbation, so there is no pulse to recover from.")
    return float(np.median(widths))


def _width(drive: Drive) -> float:
    h, u, s = np.diff(drive.knots), drive.levels[:-1], drive.slopes[:-1]
    return float(1.0 / np.sum(u**2 * h + u * s * h**2 + s**2 * h**3 / 3))


def _times(loop: YawLoop, duration: float, peaks: FloatArray, tolerance: float) -> FloatArray:
    try:
        return recovery_curve(loop, duration, peaks, tolerance).times
    except UnstableSystemError:
        return np.full(len(peaks), np.inf)


def _part(band: RecoveryBand, which: slice) -> RecoveryBand:
    return RecoveryBand(
        peaks=band.peaks[which], times=band.times[which], low=band.low[which], high=band.high[which], level=band.level,
        draws=band.draws, unstable=band.unstable, duration=band.duration, tolerance=band.tolerance, seed=band.seed,
    )  # fmt: skip


def _sentence(measured: tuple[MeasuredRecovery, ...], agreeing: int) -> str:
    back = [recovery.time for recovery in measured if recovery.recovered]
    if not back:
        return f"None of the {len(measured)} recordings shows a recovery."
    return (
        f"{len(back)} of {len(measured)} recordings show a recovery, after {min(back) / ms:.0f} to "
        f"{max(back) / ms:.0f} ms; {agreeing} of these agree with the band that the fit predicts."
    )

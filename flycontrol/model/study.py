"""Everything that a stability report shows of a yaw loop, computed once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flycontrol.delay.bracket import bracketed_root
from flycontrol.delay.locus import RootLocus
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import ComplexArray, FloatArray
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.model.gain_plane import DelaySlice, GainPlane, delay_slice, gain_plane
from flycontrol.model.gains import ChosenGains, PulseTask, fastest_pd, fastest_proportional, largest_stable_delay
from flycontrol.model.loci import delay_locus, gain_locus
from flycontrol.model.loop_shape import LoopShape, loop_shape
from flycontrol.model.recovery import RecoveryCurve, pulse_response, recovery_curve
from flycontrol.model.stability import StabilityResult, assess
from flycontrol.model.yaw import YawLoop, require_pd

_STRENGTHS = (0.25, 0.5, 1.0, 1.5, 2.0)  #: of the recoveries shown, in units of the nominal peak


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class YawRecoveries:
    """Yaw after the nominal pulse at several strengths."""

    time: FloatArray  #: [s], shape (k,)
    peaks: FloatArray  #: peak deflection of each [rad], shape (s,)
    yaw: FloatArray  #: exact [rad], shape (s, k)
    yaw_pade: FloatArray  #: with the Pade approximation [rad], shape (s, k)
    torque: FloatArray  #: the fly's torque over the inertia, exact [rad/s^2], shape (s, k)
    pade_order: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DampingRow:
    """What P and PD can do at one damping."""

    b: float  #: beta / I [1/s]
    proportional: ChosenGains
    derivative: ChosenGains  #: PD with a modulus margin of at least 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StabilityStudy:
    """A `StabilityResult` and what surrounds it. Parts that need a stable loop are None when it is not."""

    result: StabilityResult
    closed_form_largest_delay: float | None  #: T_max of the closed form for PD [s]; None where it does not apply
    shape: LoopShape
    gain_locus: RootLocus  #: over a factor on both gains
    delay_locus: RootLocus  #: over the delay [s]
    plane: GainPlane | None  #: all gains at this damping and delay; None without delay
    delay_slice: DelaySlice | None  #: a common factor on both gains against the delay; None where no delay is stable
    recoveries: YawRecoveries | None
    curve: RecoveryCurve | None
    pade_poles: dict[int, ComplexArray]  #: rightmost poles of the Pade loop by order [1/s]
    damping_table: list[DampingRow]
    deadline: float  #: the recovery time that P alone is held against [s]
    proportional_suffices_from: float | None  #: beta/I at which the best P alone just meets the deadline [1/s]


def study(
    loop: YawLoop,
    task: PulseTask,
    dampings: Sequence[float],
    *,
    deadline: float,
    pade_order: int = 4,
    progress: Progress = no_progress,
) -> StabilityStudy:
    """Study a loop.

    Parameters
    ----------
    task
        The nominal pulse.
    dampings
        Values of beta/I [1/s] at which the best P and the best PD are sought; the delay and the task stay.
    deadline
        Recovery time [s] that this loop and P alone are held against.
    """
    steps = len(dampings) + 5
    progress(0, steps, "exact poles, margins and recovery")
    result = assess(loop, task)
    shape = loop_shape(loop, pade_order)
    progress(1, steps, "root locus in the gain and in the delay")
    over_gain, over_delay = gain_locus(loop), delay_locus(loop)
    progress(2, steps, "stability chart")
    plane, slice_ = gain_plane(loop), delay_slice(loop)
    progress(3, steps, "recoveries")
    recoveries, curve = _recoveries(result, pade_order), _curve(result)
    table: list[DampingRow] = []
    for k, b in enumerate(dampings):
        progress(4 + k, steps, f"best P and PD at beta/I = {b:.0f} 1/s")
        table.append(_damping_row(b, loop.delay, task))
    progress(steps - 1, steps, "the damping at which P alone suffices")
    suffices = _proportional_suffices_from(loop.delay, task, deadline, dampings)
    progress(steps, steps, "done")
    return StabilityStudy(
        result=result, closed_form_largest_delay=_closed_form(loop), shape=shape, gain_locus=over_gain,
        delay_locus=over_delay, plane=plane, delay_slice=slice_, recoveries=recoveries, curve=curve,
        pade_poles=_pade_poles(loop), damping_table=table, deadline=deadline, proportional_suffices_from=suffices,
    )  # fmt: skip


def _closed_form(loop: YawLoop) -> float | None:
    require_pd(loop)
    b = loop.plant.damping_rate
    return largest_stable_delay(b, loop.kp, loop.kd) if loop.kp > 0 and b + loop.kd > 0 else None


def _pade_poles(loop: YawLoop) -> dict[int, ComplexArray]:
    """Of the orders that a reader would try; none without delay."""
    return {n: rightmost_roots(loop.pade_closed_loop(n)).roots for n in (1, 2, 4)} if loop.delay else {}


def _damping_row(b: float, delay: float, task: PulseTask) -> DampingRow:
    return DampingRow(
        b=b, proportional=fastest_proportional(b, delay, task), derivative=fastest_pd(b, delay, task, 0.5)
    )  # fmt: skip


def _curve(result: StabilityResult) -> RecoveryCurve | None:
    """Recovery time against strength; None of a loop that does not recover."""
    task = result.task
    if result.recovery_time is None:
        return None
    return recovery_curve(result.loop, task.duration, _curve_peaks(task), task.tolerance)


def _curve_peaks(task: PulseTask) -> FloatArray:
    """Peaks from just above the band to 2.25 times the nominal one, dense where recovery time rises sharply [rad]."""
    least, most = 1.001 * task.tolerance, 2.25 * task.peak
    bend = min(3.0 * task.tolerance, 0.5 * (least + most))
    return np.concatenate([np.geomspace(least, bend, 120), np.linspace(bend, most, 240)[1:]])


def _recoveries(result: StabilityResult, order: int) -> YawRecoveries | None:
    """After pulses of several strengths; None of a loop that does not recover."""
    if result.recovery_time is None:
        return None
    assert result.pulse is not None
    loop, task = result.loop, result.task
    peaks = task.peak * np.array(_STRENGTHS)
    end = max(0.1, 1.3 * result.recovery_time)
    time = np.linspace(0.0, end, 1201)
    exact = pulse_response(loop.closed_loop(), result.pulse, end)(time)
    approximate = pulse_response(loop.pade_closed_loop(order), result.pulse, end)(time)
    factor = (peaks / task.peak)[:, None]
    return YawRecoveries(
        time=time, peaks=peaks, yaw=factor * exact[0], yaw_pade=factor * approximate[0],
        torque=factor * exact[2] / loop.plant.inertia, pade_order=order,
    )  # fmt: skip


def _proportional_suffices_from(
    delay: float, task: PulseTask, deadline: float, dampings: Sequence[float]
) -> float | None:
    """The damping at which the best P alone just meets the deadline, searched up to four times the given range."""

    def excess(b: float) -> float:
        return fastest_proportional(b, delay, task).recovery_time - deadline

    low, high = 0.25 * min(dampings), 4.0 * max(dampings)
    if not excess(low) > 0 > excess(high):
        return None
    return bracketed_root(excess, low, high, tolerance=0.2)

"""What the intervals mean for the loop: margins, poles and recovery of fits that the data allow as well.

Draws of the shared unknowns, from Student's distribution with the covariance or from a bootstrap, are each a loop; the
quantiles of what these loops do are the intervals of the fly's margins, poles and recovery time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.delay.response import collocation_rule
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.errors import InvalidParameterError, UnstableSystemError
from flycontrol.identify.gains.bootstrap import Bootstrap
from flycontrol.identify.gains.drawn_loops import drawn_loops, loops_of, yaw_loops
from flycontrol.identify.gains.result import FitResult
from flycontrol.model import kernels
from flycontrol.model.gains import PulseTask, gain_crossover, largest_stable_delay, modulus_margins
from flycontrol.model.recovery import pulse_for_peak, recovery_time
from flycontrol.model.yaw import YawLoop

FloatArray = NDArray[np.float64]
_QUANTITIES = ("gain_margin", "phase_margin", "delay_margin", "modulus_margin", "recovery_time", "abscissa")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Consequences:
    """Loops drawn from a fit and what they do; NaN where a loop is unstable, except the abscissa."""

    loops: FloatArray  #: (b, 5) damping [1/s], kp [1/s^2], kd [1/s], delay [s], ki [1/s^3]: the fly's cloud
    gain_margin: FloatArray  #: (b,) smallest factor > 1 on both gains that destabilises
    phase_margin: FloatArray  #: (b,) [rad]
    delay_margin: FloatArray  #: (b,) [s]
    modulus_margin: FloatArray  #: (b,) min |1 + L|
    recovery_time: FloatArray  #: (b,) [s]; infinite if later than followed
    abscissa: FloatArray  #: (b,) real part of the rightmost pole [1/s]
    unstable: float  #: share of draws whose loop is unstable

    def interval(self, quantity: str, level: float = 0.95) -> tuple[float, float]:
        """Quantiles of one of the quantities over the stable loops (over all for the abscissa); NaN if there are none.

        Raises
        ------
        InvalidParameterError
            For an unknown quantity or a level outside of (0, 1).
        """
        if quantity not in _QUANTITIES or not 0 < level < 1:
            raise InvalidParameterError(
                f"An interval needs one of {', '.join(_QUANTITIES)} and a level in (0, 1), got {quantity!r}, {level!r}."
            )
        values = getattr(self, quantity)
        values = values[~np.isnan(values)]
        if not len(values):
            return float("nan"), float("nan")
        low, high = np.quantile(values, [0.5 - level / 2, 0.5 + level / 2], method="closest_observation")
        return float(low), float(high)


def consequences(
    found: FitResult, task: PulseTask, draws: int = 1000, *, seed: int = 0, boot: Bootstrap | None = None
) -> Consequences:
    """Carry a fit's uncertainty into what its loop does.

    Parameters
    ----------
    task
        The pulse, scaled in every loop to the same peak, and the band that recovery is measured by.
    boot
        Draws of a bootstrap to use instead of the covariance's; `draws` and `seed` are then not used.

    Raises
    ------
    InvalidInputError, InvalidParameterError
        As of `drawn_loops`.
    """
    loops = drawn_loops(found, draws, seed) if boot is None else loops_of(found, boot.draws - found.uncertainty.bias)
    abscissa = np.array([rightmost_roots(loop.closed_loop(), 1).abscissa for loop in yaw_loops(loops)])
    integrates = bool(loops[:, 4].any())
    stable = abscissa < 0 if integrates else _stable(loops)
    done = np.full((len(loops), 5), np.nan)
    done[stable] = (of_any_loop if integrates else of_pd_loops)(loops[stable], task)
    gain, phase, delay, modulus, recovery = done.T
    return Consequences(
        loops=loops, gain_margin=gain, phase_margin=phase, delay_margin=delay, modulus_margin=modulus,
        recovery_time=recovery, abscissa=abscissa, unstable=float(1 - stable.mean()),
    )  # fmt: skip


def of_pd_loops(loops: FloatArray, task: PulseTask) -> FloatArray:
    """Three margins, modulus margin and recovery (b, 5) of stable P or PD loops, by closed forms and kernels."""
    b, kp, kd, T, _ = loops.T
    rest = [
        (modulus_margins(b[i], kp[i : i + 1], kd[i : i + 1], T[i])[0], _recovery(loops[i, :4], task))
        for i in range(len(loops))
    ]
    return np.hstack([pd_margins(loops[:, :4]), np.array(rest).reshape(-1, 2)])


def of_any_loop(loops: FloatArray, task: PulseTask) -> FloatArray:
    """The same of stable loops with an integral term, by the general code."""
    return np.array([_margins_and_recovery(loop, task) for loop in yaw_loops(loops)]).reshape(-1, 5)


def _margins_and_recovery(loop: YawLoop, task: PulseTask) -> tuple[float, ...]:
    room = loop.margins()
    try:
        seconds = recovery_time(loop, pulse_for_peak(loop, task.duration, task.peak), task.tolerance)
    except UnstableSystemError:  # too slow to be followed
        seconds = np.inf
    return room.gain_margin, room.phase_margin, room.delay_margin, room.modulus_margin, seconds


def _stable(loops: FloatArray) -> NDArray[np.bool_]:
    return np.array([p > 0 and b + d > 0 and largest_stable_delay(b, p, d) > T for b, p, d, T, _ in loops])


def pd_margins(loops: FloatArray) -> FloatArray:
    """Gain margin, phase margin [rad] and delay margin [s] (b, 3) of stable PD loops (b, 4), in closed form.

    |L| falls with w, so the one gain crossover wc gives T_max - T and wc (T_max - T), and the first w > wc where
    atan(kd w / kp) - atan(w / b) - w T = -pi / 2 gives 1 / |L(jw)|; it lies below pi / T.
    """
    b, kp, kd, T = loops.T[:, :, None]
    wc = np.array([gain_crossover(*row[:3]) for row in loops])
    room = np.array([largest_stable_delay(*row[:3]) for row in loops]) - loops[:, 3]

    def phase(w: FloatArray) -> FloatArray:
        return np.arctan2(kd * w, kp) - np.arctan2(w, b) - w * T + np.pi / 2

    grid = wc[:, None] + (np.pi / T - wc[:, None]) * np.linspace(0.0, 1.0, 65)
    first = np.argmax(phase(grid) < 0, axis=1)[:, None]
    low, high = np.take_along_axis(grid, first - 1, 1), np.take_along_axis(grid, first, 1)
    for _ in range(50):
        middle = 0.5 * (low + high)
        below = phase(middle) > 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    gain = high * np.hypot(high, b) / np.hypot(kp, kd * high)
    return np.column_stack([gain[:, 0], wc * room, room])


def _recovery(values: FloatArray, task: PulseTask) -> float:
    b, kp, kd, delay = values.tolist()
    horizon = 4 * task.duration + 24 * delay + (10 / b if b > 0 else 0.0)
    ratio = task.tolerance / task.peak
    times = kernels.recovery_times(
        b, np.array([kp]), np.array([kd]), delay, task.duration, ratio, horizon, collocation_rule()
    )
    return float(times[0])

"""Gains by rule: fastest P, fastest PD, fastest decay, and the most robust gains that are still fast enough."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flycontrol.delay.bracket import bracketed_root
from flycontrol.delay.response import collocation_rule
from flycontrol.delay.system import FloatArray
from flycontrol.errors import InvalidParameterError
from flycontrol.model import kernels
from flycontrol.model.recovery import pulse_for_peak, recovery_time
from flycontrol.model.yaw import YawLoop

_SHRINK, _ROUNDS = 0.35, 9
_OFF = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class PulseTask:
    """What a controller is asked to do: recover into +-tolerance from a pulse of this duration scaled to a peak."""

    duration: float  #: [s]
    peak: float  #: [rad]
    tolerance: float  #: [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChosenGains:
    """Gains found by a rule, with what they achieve."""

    rule: str
    kp: float  #: K_P / I [1/s^2]
    kd: float  #: K_D / I [1/s]
    recovery_time: float  #: in the task [s]
    nearby: float  #: the longest recovery time with gains up to 1 % off [s]; inf: some are unstable or far slower
    modulus_margin: float  #: min |1 + L|


def gain_crossover(b: float, kp: float, kd: float) -> float:
    """wc^2 = ((kd^2 - b^2) + sqrt((kd^2 - b^2)^2 + 4 kp^2)) / 2: the only gain crossover of PD control [rad/s]."""
    excess = kd**2 - b**2
    size = np.hypot(excess, 2 * kp)
    # neither form cancels
    return float(np.sqrt((excess + size) / 2) if excess > 0 else abs(kp) * np.sqrt(2 / (size - excess)))


def largest_stable_delay(b: float, kp: float, kd: float) -> float:
    """T_max = (atan(kd wc / kp) + atan(b / wc)) / wc at the gain crossover wc, for kp > 0 and b + kd > 0 [s].

    Raises
    ------
    InvalidParameterError
        If kp <= 0 or b + kd <= 0: unstable even without delay.
    """
    if not (kp > 0 and b + kd > 0):
        raise InvalidParameterError(
            f"The closed form needs kp > 0 and b + kd > 0, got kp = {kp!r}, b + kd = {b + kd!r}."
        )
    wc = gain_crossover(b, kp, kd)
    return float((np.arctan2(kd * wc, kp) + np.arctan2(b, wc)) / wc)


def fastest_decay(b: float, delay: float) -> tuple[float, float, float]:
    """Gains with the fastest asymptotic decay, where three roots meet: kp [1/s^2], kd [1/s] and that root s0 [1/s].

    s0 = (-(bT + 4) + sqrt(b^2 T^2 + 8)) / (2T), kd = -exp(s0 T) (T (s0^2 + b s0) + 2 s0 + b),
    kp = -(s0^2 + b s0) exp(s0 T) - kd s0.
    """
    T = delay
    s0 = (-(b * T + 4) + np.sqrt(b * b * T * T + 8)) / (2 * T)
    kd = -np.exp(s0 * T) * (T * (s0**2 + b * s0) + 2 * s0 + b)
    kp = -(s0**2 + b * s0) * np.exp(s0 * T) - kd * s0
    return float(kp), float(kd), float(s0)


def fastest_proportional(b: float, delay: float, task: PulseTask) -> ChosenGains:
    """P alone on the yaw angle (kd = 0) with the shortest recovery in the task."""
    most = _largest_stable_proportional(b, delay)
    kp = np.geomspace(0.01 * min(b**2, most), 0.999 * most, 200)
    for _ in range(4):
        times = _recovery_sweep(b, kp, np.zeros_like(kp), delay, task)
        k = int(np.argmin(times))
        kp = np.linspace(kp[max(k - 2, 0)], kp[min(k + 2, len(kp) - 1)], 60)
    times = _recovery_sweep(b, kp, np.zeros_like(kp), delay, task)
    return _chosen("fastest P", b, delay, task, float(kp[np.argmin(times)]), 0.0)


def _largest_stable_proportional(b: float, delay: float) -> float:
    """K_P/I at which P alone loses stability: w tan(w T) = b, kp = w sqrt(w^2 + b^2) [1/s^2].

    Raises
    ------
    InvalidParameterError
        If b is not > 0: without damping no proportional gain is stable under a delay.
    """
    if not (b > 0 and delay > 0):
        raise InvalidParameterError(
            f"P alone has a largest stable gain only with damping and delay > 0, got {b!r} 1/s and {delay!r} s."
        )
    w = bracketed_root(lambda w: w * np.sin(w * delay) - b * np.cos(w * delay), 1e-9 / delay, np.pi / 2 / delay)
    return float(w * np.hypot(w, b))


def fastest_pd(b: float, delay: float, task: PulseTask, modulus_margin: float = 0.0) -> ChosenGains:
    """PD on the yaw angle with the shortest recovery in the task among gains with at least this modulus margin.

    Recovery time jumps where a later swing touches the band, so this is a search by shrinking grids, not by slopes.
    """

    def cost(kp: FloatArray, kd: FloatArray) -> FloatArray:
        times = _recovery_sweep(b, kp, kd, delay, task)
        if modulus_margin > 0:
            short = np.maximum(0.0, modulus_margin - modulus_margins(b, kp, kd, delay))
            times = np.where(short > 0, 1e3 * (1.0 + short), times)
        return times

    kp, kd = _shrinking_grid(cost, b, delay)
    rule = "fastest PD" + (f" with modulus margin >= {modulus_margin:g}" if modulus_margin > 0 else "")
    return _chosen(rule, b, delay, task, kp, kd)


def most_robust_pd(b: float, delay: float, task: PulseTask, deadline: float) -> ChosenGains:
    """PD with the largest modulus margin among gains that recover within `deadline` [s] in the task.

    Recovery takes longer the larger the peak, so the task's peak stands for every smaller one.
    """

    def cost(kp: FloatArray, kd: FloatArray) -> FloatArray:
        late = np.minimum(np.maximum(0.0, _recovery_sweep(b, kp, kd, delay, task) - deadline), 1e3)
        return np.where(late > 0, 10.0 + late, -modulus_margins(b, kp, kd, delay))

    kp, kd = _shrinking_grid(cost, b, delay)
    rule = f"largest modulus margin with recovery within {deadline * 1e3:g} ms"
    return _chosen(rule, b, delay, task, kp, kd)


def _shrinking_grid(
    cost: Callable[[FloatArray, FloatArray], FloatArray], b: float, delay: float
) -> tuple[float, float]:
    """Minimum of a cost over (kp, kd): a coarse grid over all stable gains, then ever smaller grids around the best."""
    scale = 1.0 / delay
    low = np.array([0.02 * (b * scale + scale**2), -0.5 * b])
    high = np.array([0.7 * (b * scale + scale**2), b + 2.0 * scale])
    best = (low + high) / 2
    half = (high - low) / 2
    size = 40
    for _ in range(_ROUNDS):
        kp = np.linspace(max(best[0] - half[0], 1e-3 * low[0]), best[0] + half[0], size)
        kd = np.linspace(best[1] - half[1], best[1] + half[1], size)
        grid_kp, grid_kd = (g.ravel() for g in np.meshgrid(kp, kd))
        k = int(np.argmin(cost(grid_kp, grid_kd)))
        best = np.array([grid_kp[k], grid_kd[k]])
        half = half * _SHRINK
        size = 13
    return float(best[0]), float(best[1])


def _recovery_sweep(b: float, kp: FloatArray, kd: FloatArray, delay: float, task: PulseTask) -> FloatArray:
    """Recovery times [s]; inf for unstable gains and for recoveries longer than a dozen delays and pulses."""
    times = np.full(len(kp), np.inf)
    stable = np.array(
        [p > 0 and b + d > 0 and delay < 0.97 * largest_stable_delay(b, p, d) for p, d in zip(kp, kd, strict=True)]
    )
    horizon = 4 * task.duration + 16 * delay + (10 / b if b > 0 else 0.0)
    ratio = task.tolerance / task.peak
    times[stable] = kernels.recovery_times(
        b, kp[stable], kd[stable], delay, task.duration, ratio, horizon, collocation_rule()
    )
    return times


def modulus_margins(b: float, kp: FloatArray, kd: FloatArray, delay: float) -> FloatArray:
    """min |1 + L| for many gains kp [1/s^2] and kd [1/s] of shape (k,), by a compiled sweep over frequency.

    It agrees with `YawLoop.margins` where the loop comes nearest to -1 between w T = 0.02 and 20.
    """
    grid = np.geomspace(0.02, 20.0, 160) / delay
    return kernels.modulus_margins(b, kp, kd, delay, grid)


def _chosen(rule: str, b: float, delay: float, task: PulseTask, kp: float, kd: float) -> ChosenGains:
    """What the gains achieve, by the general code and not by the sweep that found them."""
    loop = YawLoop.from_rates(b=b, kp=kp, kd=kd, delay=delay)
    pulse = pulse_for_peak(loop, task.duration, task.peak)
    return ChosenGains(
        rule=rule, kp=kp, kd=kd,
        recovery_time=recovery_time(loop, pulse, task.tolerance),
        nearby=_longest_nearby(b, kp, kd, delay, task),
        modulus_margin=loop.margins().modulus_margin,
    )  # fmt: skip


def _longest_nearby(b: float, kp: float, kd: float, delay: float, task: PulseTask) -> float:
    """How badly recovery suffers from gains 1 % off: optima lie on the edge of jumps, where a later swing leaves."""
    factors = np.linspace(1.0 - _OFF, 1.0 + _OFF, 9)
    kps, kds = (grid.ravel() for grid in np.meshgrid(kp * factors, kd * factors if kd else [0.0]))
    return float(_recovery_sweep(b, kps, kds, delay, task).max())

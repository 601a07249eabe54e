"""PD control with delay of a damped double integrator, written by hand, and the benchmark loop of the design."""

import mpmath
import numpy as np

from flycontrol.delay.system import DelayLTI, delay_lti

B, KP, KD, T = 20.0, 900.0, 55.0, 0.0136  # b [1/s], kp [1/s^2], kd [1/s], T [s]


def pd_closed(b: float = B, kp: float = KP, kd: float = KD, T: float = T) -> DelayLTI:
    """psi'' = -b psi' - kp psi(t - T) - kd psi'(t - T) + u, y = psi."""
    return delay_lti(
        A=[[0.0, 1.0], [0.0, -b]], B1=[[0.0], [1.0]], B2=[[0.0], [-1.0]], C1=[[1.0, 0.0]], C2=[[kp, kd]], tau=[T]
    )  # fmt: skip


def pd_open(b: float = B, kp: float = KP, kd: float = KD, T: float = T) -> DelayLTI:
    """L(s) = (kd s + kp) exp(-s T) / (s (s + b))."""
    return delay_lti(
        A=[[0.0, 1.0], [0.0, -b]], B1=[[0.0], [1.0]], C1=[[0.0, 0.0]], C2=[[kp, kd]], D12=[[1.0]], tau=[T]
    )  # fmt: skip


def crossover(b: float, kp: float, kd: float) -> float:
    """wc^2 = ((kd^2 - b^2) + sqrt((kd^2 - b^2)^2 + 4 kp^2)) / 2, without cancellation where b > kd."""
    excess = kd**2 - b**2
    root = np.hypot(excess, 2 * kp)
    return float(np.sqrt((excess + root) / 2 if excess > 0 else 2 * kp**2 / (root - excess)))


def largest_delay(b: float, kp: float, kd: float) -> float:
    """T_max = (atan(kd wc / kp) + atan(b / wc)) / wc."""
    wc = crossover(b, kp, kd)
    return float((np.arctan(kd * wc / kp) + np.arctan(b / wc)) / wc)


def newton_step(root: complex, b: float = B, kp: float = KP, kd: float = KD, T: float = T) -> float:
    """|f / f'| at a root for f = s^2 + b s + (kd s + kp) exp(-s T), in 40 digits: the distance to the true root."""
    with mpmath.workdps(40):
        s, lag = mpmath.mpc(root), mpmath.exp(-mpmath.mpc(root) * mpmath.mpf(T))
        f = s**2 + b * s + (kd * s + kp) * lag
        slope = 2 * s + b + (kd - T * (kd * s + kp)) * lag
        return float(abs(f / slope))

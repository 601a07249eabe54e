"""What delayed signals were before time 0, from the states' history: z = C2 x + D22 w, w_i(t) = z_i(t - tau_i)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from flycontrol.delay.piecewise import PiecewisePolynomial, fitted
from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError

#: t [s] < 0 -> states (n,)
StateHistory = Callable[[float], "FloatArray | Sequence[float]"]


def constant_history(system: DelayLTI, state: FloatArray) -> FloatArray:
    """Delayed signals (q,) of a state (n,) that never changed, input zero: z = (I - D22)^-1 C2 x."""
    signals = system.C2 @ state
    if system.D22.any():
        signals = np.linalg.solve(np.eye(system.n_delays) - system.D22, signals)
    return np.asarray(signals, dtype=np.float64)


def past_signals(system: DelayLTI, history: StateHistory, breaks: Sequence[float] = ()) -> PiecewisePolynomial:
    """Delayed signals z (q of them) from -max(tau) to 0, the input having been zero.

    Parameters
    ----------
    history
        States (n,) at a time t < 0 [s]; read back to the longest sum of delays in a chain.
    breaks
        Times < 0 [s] of the history's kinks and jumps.

    Raises
    ------
    InvalidParameterError
        If the history returns anything but n finite numbers or has a kink that is not among the breaks.
    """

    def state(t: float) -> FloatArray:
        x = np.asarray(history(t), dtype=np.float64)
        if x.shape != (system.n_states,) or not np.isfinite(x).all():
            raise InvalidParameterError(
                f"A history must return {system.n_states} finite states, got {x.tolist()!r} at {t:g} s."
            )
        return x

    def signal(channel: int, t: float) -> float:
        own = float(system.C2[channel] @ state(t))
        feeding = np.flatnonzero(system.D22[channel])  # nilpotent: the recursion ends
        return own + sum(float(system.D22[channel, i]) * signal(int(i), t - float(system.tau[i])) for i in feeding)

    def signals(t: float) -> list[float]:
        return [signal(channel, t) for channel in range(system.n_delays)]

    longest = float(system.tau.max(initial=0.0))
    marks = {float(mark) for mark in breaks}
    for _ in range(system.n_delays if system.D22.any() else 0):
        marks |= {mark + float(delay) for mark in marks for delay in system.tau}
    inside = sorted(mark for mark in marks if -longest * (1 - 1e-12) < mark < -1e-12 * longest)
    return fitted(signals, [-longest, *inside, 0.0])

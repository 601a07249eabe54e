"""An independent integrator of delay systems: the method of steps with SciPy's DOP853, restarted at every kink."""

from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from flycontrol.delay.system import DelayLTI


class MethodOfSteps:
    """Outputs of a retarded system after piecewise-constant input, from rest or from a constant history.

    Signals are looked up by the middle of the running segment, so that no value is ever taken from the wrong side of a
    kink.
    """

    def __init__(self, system: DelayLTI, end: float, edges=(0.0,), inputs=None, initial_state=None):
        self.system, self.edges = system, np.asarray(edges, float)
        self.inputs = np.zeros((len(self.edges), system.n_inputs)) if inputs is None else np.asarray(inputs, float)
        self.x0 = np.zeros(system.n_states) if initial_state is None else np.asarray(initial_state, float)
        gain = np.eye(system.n_delays) - system.D22
        self.history = np.linalg.solve(gain, system.C2 @ self.x0)  # w = z in a past that never changed
        kinks = _kinks(self.edges, system.tau, end)
        self.segments: list[tuple[float, float, object]] = []
        x = self.x0
        for start, stop in pairwise(kinks):
            x = self._integrate(start, stop, x)

    def _integrate(self, start, stop, x):
        middle = (start + stop) / 2
        s = self.system

        def slope(t, state):
            return s.A @ state + s.B1 @ self._input(middle) + s.B2 @ self._delayed(t, middle)

        # a step far below the tolerance's own choice keeps the dense output, of order 7, at rounding level too
        step = (stop - start) / np.ceil((stop - start) * 12 * (1 + np.abs(s.A).max()))
        found = solve_ivp(
            slope, (start, stop), x, method="DOP853", rtol=1e-12, atol=1e-14, max_step=step, dense_output=True
        )
        self.segments.append((start, stop, found.sol))
        return found.y[:, -1]

    def _input(self, middle):
        return self.inputs[np.searchsorted(self.edges, middle, side="right") - 1] if middle > 0 else 0 * self.inputs[0]

    def _state(self, t, middle):
        if middle < 0:
            return self.x0
        return next(sol for start, stop, sol in self.segments if start <= middle < stop)(t)

    def _delayed(self, t, middle):
        """w(t), channel by channel and recursively through D22."""
        s = self.system
        return np.array([self._signal(i, t - tau, middle - tau) for i, tau in enumerate(s.tau)])

    def _signal(self, i, t, middle):
        if middle < 0:
            return self.history[i]
        s = self.system
        direct = s.D22[i] @ self._delayed(t, middle) if s.D22[i].any() else 0.0
        return s.C2[i] @ self._state(t, middle) + s.D21[i] @ self._input(middle) + direct

    def __call__(self, times):
        """Outputs (p, k) at times [s] that lie on no kink."""
        s = self.system
        columns = []
        for t in times:
            start, stop, sol = next(seg for seg in self.segments if seg[0] <= t <= seg[1])
            middle = (start + stop) / 2
            columns.append(s.C1 @ sol(t) + s.D11 @ self._input(middle) + s.D12 @ self._delayed(t, middle))
        return np.array(columns).T


def _kinks(edges, tau, end):
    """Edges and all their images under sums of delays, 0 and the end."""
    found = {0.0, float(end), *[float(e) for e in edges]}
    newest = set(found) - {float(end)}
    while newest:
        newest = {t + d for t in newest for d in tau if t + d < end}
        found |= newest
    ordered = np.sort(list(found))
    return ordered[np.append(np.diff(ordered) > 1e-12 * end, True)]

"""A system made ready for questions about its frequency response: balanced, bounded, its poles on the axis known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flycontrol.delay.asymptote import Asymptote, asymptote
from flycontrol.delay.balance import balance, root_bound
from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.open_loop import OpenLoopPoles, open_loop_poles
from flycontrol.delay.panels import Blocks, Panels, joined, kernel_blocks, panels_along, transfer
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

_GAP = 1e-7  # of its frequency: what panels leave out on either side of a pole on the imaginary axis
_MOST_TURNS = 1e5  # radians of delay up to which panels are few enough


@dataclass(frozen=True, slots=True, eq=False)
class FrequencyDomain:
    """G(j w) of a system that may have poles on the imaginary axis."""

    system: DelayLTI  #: balanced
    blocks: Blocks
    far: Asymptote
    poles: OpenLoopPoles

    def values(self, omega: FloatArray) -> ComplexArray:
        """G at frequencies (k,) [rad/s], shape (k, p, m)."""
        return transfer(self.blocks, 1j * omega)[0]

    def affordable(self, top: float) -> bool:
        """Whether panels up to a frequency [rad/s] are few enough."""
        return top * float(self.system.tau.sum()) < _MOST_TURNS

    def affordable_top(self, top: float) -> float:
        """The same frequency, or the largest affordable one [rad/s]."""
        turns = top * float(self.system.tau.sum())
        return top if turns < _MOST_TURNS else top * _MOST_TURNS / turns

    def stretches(self, low: float, high: float) -> list[tuple[float, float]]:
        """The range from low to high [rad/s], without the near neighbourhood of poles on the imaginary axis."""
        ends = [low]
        for pole in self.poles.on_axis:
            gap = max(_GAP * pole.frequency, 1e3 * pole.spread)
            if low < pole.frequency - gap and pole.frequency + gap < high:
                ends += [pole.frequency - gap, pole.frequency + gap]
        ends.append(high)
        return list(zip(ends[::2], ends[1::2], strict=True))

    def panels(self, low: float, high: float, floor: float = 0.0) -> Panels:
        """Panels on every stretch from low to high [rad/s]; errors below `floor` are good enough."""
        stretches = self.stretches(low, high)
        return joined([panels_along(self.blocks, 1j * a, 1j * b, 0.1 * a, floor) for a, b in stretches])

    def lowest(self) -> float:
        """Where panels start [rad/s]: 0, or with an integrator, where |G| > 10 below every rate and keeps growing."""
        at_rest = [pole for pole in self.poles.on_axis if pole.frequency == 0]
        if not at_rest:
            return 0.0
        low = max(1e-9 * self.slowest_rate(), 1e3 * at_rest[0].spread)
        for _ in range(20):
            near, far = np.linalg.norm(self.values(low * np.array([1.0, 2.0])), axis=(1, 2))
            if near > 10.0 or near < 1.5 * far:  # the second: a zero cancels the integrator
                break
            low *= 1e-3
        return low

    def slowest_rate(self) -> float:
        """The smallest size of an eigenvalue of A that is not zero to rounding, or of an inverse delay [1/s]."""
        x = self.system
        radius = max(root_bound(x, 0.0), 1e-12)
        rates = np.abs(np.linalg.eigvals(x.A)) if x.n_states else np.zeros(0)
        slow = [*rates[rates > 1e-9 * radius], *(1.0 / x.tau)]
        return float(min(slow, default=radius))


def frequency_domain(system: Operand) -> FrequencyDomain:
    """Make a system ready.

    Raises
    ------
    NeutralSystemError
        If a delay feeds back into itself without passing a state, or inner loops defy a list of their poles.
    """
    balanced = balance(as_delay_lti(system))
    return FrequencyDomain(balanced, kernel_blocks(balanced), asymptote(balanced), open_loop_poles(balanced))

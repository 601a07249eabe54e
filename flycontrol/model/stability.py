"""What an engineer wants to know first of a yaw loop: is it stable, how far from not, how fast does it recover."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.delay.margins import Margins
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import ComplexArray, FloatArray
from flycontrol.errors import UnstableSystemError
from flycontrol.model.gains import PulseTask
from flycontrol.model.perturbation import TorquePulse
from flycontrol.model.recovery import pulse_for_peak, recovery_time
from flycontrol.model.yaw import YawLoop


@dataclass(frozen=True, slots=True, kw_only=True)
class Mode:
    """One real root, or one pair of complex roots, of the closed loop."""

    root: complex  #: the one with imag >= 0 [1/s]

    @property
    def time_constant(self) -> float:
        """Time in which the mode falls by a factor e [s]; negative when it grows, infinite when it does neither."""
        return -1.0 / self.root.real if self.root.real else float("inf")

    @property
    def frequency(self) -> float:
        """Oscillations a second [Hz]; zero for a real root."""
        return self.root.imag / (2 * np.pi)

    @property
    def damping_ratio(self) -> float:
        """-Re / |root|; 0 for a root at the origin."""
        return -self.root.real / abs(self.root) if self.root else 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StabilityResult:
    """Verdict on one loop. Margins and recovery are None for an unstable loop, and `reason` says why."""

    loop: YawLoop
    task: PulseTask
    stable: bool
    poles: ComplexArray  #: rightmost poles [1/s]
    pole_errors: FloatArray  #: estimated error of each [1/s]
    poles_status: str  #: "certified" if a count found no other so far right, else what is not certain
    margins: Margins | None
    pulse: TorquePulse | None  #: the pulse that deflects this loop to the task's peak
    recovery_time: float | None  #: [s]
    reason: str | None

    @property
    def modes(self) -> list[Mode]:
        """Modes of the listed poles, slowest decay first."""
        return [Mode(root=complex(root)) for root in self.poles if root.imag >= 0]


def assess(loop: YawLoop, task: PulseTask, count: int = 10) -> StabilityResult:
    """Exact poles, margins and recovery of a loop; an unstable loop is a result, not an error."""
    spectrum = rightmost_roots(loop.closed_loop(), count)
    stable = spectrum.abscissa < 0
    if not stable:
        reason = (
            f"The loop is unstable: its rightmost pole lies at {spectrum.abscissa:+.4g} 1/s, so margins and a recovery "
            "time do not exist."
        )
        return StabilityResult(
            loop=loop, task=task, stable=False, poles=spectrum.roots, pole_errors=spectrum.errors,
            poles_status=spectrum.status, margins=None, pulse=None, recovery_time=None, reason=reason,
        )  # fmt: skip
    try:
        pulse = pulse_for_peak(loop, task.duration, task.peak)
        seconds: float | None = recovery_time(loop, pulse, task.tolerance)
        reason = None
    except UnstableSystemError as too_slow:
        pulse, seconds, reason = None, None, str(too_slow)
    return StabilityResult(
        loop=loop, task=task, stable=True, poles=spectrum.roots, pole_errors=spectrum.errors,
        poles_status=spectrum.status, margins=loop.margins(), pulse=pulse, recovery_time=seconds, reason=reason,
    )  # fmt: skip

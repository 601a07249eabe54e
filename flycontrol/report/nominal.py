"""From a parameter file's numbers to what a study needs: the loop, its task, and dampings to compare P and PD at."""

from __future__ import annotations

import numpy as np

from flycontrol.model.gains import PulseTask
from flycontrol.model.parameters import Parameters
from flycontrol.model.yaw import PDController, YawLoop, YawPlant

_ROWS = 6  #: dampings over the published range
_SAME = 0.02  #: a damping this close to the fly's own is the fly's own


def yaw_loop(parameters: Parameters) -> YawLoop:
    """Build the loop that the parameters describe."""
    inertia = parameters.inertia.value
    return YawLoop(
        plant=YawPlant(inertia=inertia, damping=parameters.damping.value),
        controller=PDController(
            proportional=parameters.proportional_gain.value * inertia,
            derivative=parameters.derivative_gain.value * inertia,
        ),
        delay=parameters.delay.value,
    )


def pulse_task(parameters: Parameters) -> PulseTask:
    """Return the nominal pulse and what counts as recovered."""
    return PulseTask(
        duration=parameters.pulse_duration.value, peak=parameters.pulse_peak.value, tolerance=parameters.tolerance.value
    )


def dampings(parameters: Parameters) -> list[float]:
    """Values of beta/I [1/s] over the published range, the fly's own among them."""
    own = parameters.damping_rate
    span = np.linspace(parameters.damping_low.value, parameters.damping_high.value, _ROWS)
    others = [float(b) for b in span if abs(b - own) > _SAME * own]
    return sorted([*others, own]) if own > 0 else others

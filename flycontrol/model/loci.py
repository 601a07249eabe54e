"""Exact root loci of a yaw loop, in a common factor on its gains and in its delay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flycontrol.delay.locus import RootLocus, root_locus
from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.model.gains import largest_stable_delay
from flycontrol.model.yaw import PDController, YawLoop, require_pd
from flycontrol.units import ms

#: factors on the gains that a locus holds exactly, for a figure to name
MARKED_FACTORS = (0.25, 0.5, 0.75, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 20.0)
#: delays likewise [s]
MARKED_DELAYS = tuple(ms * t for t in (0.5, 1, 2, 3, 5, 7, 10, 15, 20, 25, 30, 40, 50, 70, 100, 150, 200, 300))

_COARSE, _FINE = 60, 200
_BESIDE = np.array([1e-5, 1e-4, 4e-4, 1e-3, 2e-3, 4e-3, 7e-3])  # of a collision's value: roots leave it like a root
_MOST_TURNS = 20.0  # delay times the loop's fastest rate up to which a locus goes


def gain_locus(loop: YawLoop) -> RootLocus:
    """Roots over a common factor on both gains, from 0.02 to 4, the loop's own 1 among the values."""
    require_pd(loop)

    def scaled(factor: float) -> DelayLTI:
        gains = PDController(
            proportional=factor * loop.controller.proportional, derivative=factor * loop.controller.derivative
        )
        return replace(loop, controller=gains).closed_loop()

    return _locus(scaled, (0.02, 4.0), [1.0, *MARKED_FACTORS])


def delay_locus(loop: YawLoop) -> RootLocus:
    """Roots over the delay, from a tenth to four times the loop's own, further where stability ends later."""
    require_pd(loop)
    own = max(loop.delay, 1e-3)
    low, high = 0.1 * own, 4.0 * own
    if loop.kp > 0 and loop.plant.damping_rate + loop.kd > 0:
        end = largest_stable_delay(loop.plant.damping_rate, loop.kp, loop.kd)
        rate = loop.plant.damping_rate + abs(loop.kd) + np.sqrt(loop.kp)
        low, high = min(low, 0.5 * end), max(high, min(1.3 * end, _MOST_TURNS / rate))
    return _locus(lambda delay: replace(loop, delay=delay).closed_loop(), (low, high), [loop.delay, *MARKED_DELAYS])


def _locus(system_at: Callable[[float], DelayLTI], ends: tuple[float, float], marked: list[float]) -> RootLocus:
    """A locus over a range with marked values on its grid, which is denser where two roots meet."""
    collisions = [met.value for met in root_locus(system_at, np.geomspace(*ends, _COARSE)).collisions]
    beside = [value * (1 + side * _BESIDE) for value in collisions for side in (-1.0, 1.0)]
    values = np.concatenate([np.geomspace(*ends, _FINE), marked, *beside])
    return root_locus(system_at, _apart(values[(values >= ends[0]) & (values <= ends[1])], np.array(marked)))


def _apart(values: FloatArray, kept: FloatArray) -> FloatArray:
    """Rising values without those that all but coincide with one that must stay."""
    near = (np.abs(values[:, None] / kept[kept > 0] - 1.0) < 1e-7).any(axis=1)
    inside = kept[(kept >= values.min()) & (kept <= values.max())]
    return np.unique(np.concatenate([values[~near], inside]))

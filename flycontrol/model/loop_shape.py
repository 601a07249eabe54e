"""The open loop of yaw over frequency: exact and by Pade, and how Nyquist's curve goes around -1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.delay.bracket import bracketed_root
from flycontrol.delay.frequency import FrequencyResponse, evaluate, frequency_response
from flycontrol.delay.margins import margins
from flycontrol.delay.nyquist import NyquistResponse, nyquist_response
from flycontrol.delay.pade import pade
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoopShape:
    """Open-loop frequency response, exact and with the Pade approximation."""

    exact: FrequencyResponse
    pade: ComplexArray  #: L(j w) with the delay approximated, on the same frequencies
    pade_order: int
    pade_errs_from: float  #: frequency at which Pade's phase is first off by 1 deg [rad/s]; inf: nowhere on the grid
    nyquist: NyquistResponse  #: certified number of encirclements of -1
    negative_crossings: FloatArray  #: L where it is real and negative, shape (k,)


def loop_shape(loop: YawLoop, order: int, turn: float = 0.05) -> LoopShape:
    """Evaluate the open loop up to 40 radians of delay, neighbours apart by less than `turn` in log L."""
    L = loop.open_loop()
    approximate = pade(L, order)
    exact = frequency_response(L, 1.0, 40.0 / max(loop.delay, 1e-3), turn=turn)
    by_pade = evaluate(approximate, exact.omega)
    return LoopShape(
        exact=exact,
        pade=by_pade,
        pade_order=order,
        pade_errs_from=_errs_from(L, approximate, exact.omega, by_pade / exact.value),
        nyquist=nyquist_response(L),
        negative_crossings=evaluate(L, margins(L).phase_crossovers).real,
    )


def _errs_from(L: DelayLTI, approximate: DelayLTI, omega: FloatArray, ratio: ComplexArray) -> float:
    """The frequency between two of the grid at which the phases of L and its approximation part by 1 deg."""
    off = np.abs(np.angle(ratio)) > 1 * deg
    if not off.any():
        return np.inf
    k = int(np.argmax(off))
    if k == 0:
        return float(omega[0])

    def excess(w: float) -> float:
        at = np.array([w])
        return float(np.abs(np.angle(evaluate(approximate, at)[0] / evaluate(L, at)[0]))) - 1 * deg

    return bracketed_root(excess, float(omega[k - 1]), float(omega[k]))

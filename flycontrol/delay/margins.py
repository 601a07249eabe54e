"""Gain, phase, delay and modulus margins of a loop with delay, each crossover bracketed and solved for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import fminbound

from flycontrol.delay.bracket import bracketed_root
from flycontrol.delay.frequency import FrequencyResponse, active_range, evaluate, frequency_response
from flycontrol.delay.system import DelayLTI, FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Margins:
    """Margins of a negative unit feedback around L. They mean robustness only if that loop is stable.

    A margin that does not exist is infinite (nothing of that kind brings the loop to the boundary).
    """

    gain_margin: float  #: smallest factor > 1 on the gain that reaches the boundary
    gain_reduction_margin: float  #: largest factor < 1 that does; 0 when none
    phase_margin: float  #: smallest phase lag at a gain crossover that reaches the boundary [rad]
    delay_margin: float  #: smallest further delay that reaches the boundary [s]
    modulus_margin: float  #: distance of L(jw) from -1, min |1 + L| = 1 / Ms
    gain_crossovers: FloatArray  #: every frequency with |L| = 1 [rad/s]
    phase_crossovers: FloatArray  #: every frequency with L real and negative and |L| above the floor [rad/s]
    modulus_frequency: float  #: where |1 + L| is smallest [rad/s]; inf when only approached
    floor: float  #: |L| under which phase crossovers are left out


def margins(loop: DelayLTI, floor: float = 0.01) -> Margins:
    """Margins of the loop that negative unit feedback closes around `loop`.

    Crossovers are sign changes on a response refined until log L moves by less than 0.1 between neighbours, then solved
    by Brent's method. Frequencies reach up to where a norm bound keeps |L| below 1, or |L| falls below `floor`.

    Raises
    ------
    InvalidParameterError
        If the loop has more than one input or output.
    """
    low, high = active_range(loop)
    response = frequency_response(loop, low, high / floor)
    gain = _gain_crossovers(loop, response)
    phase = _phase_crossovers(loop, response, floor)
    lags = (np.angle(evaluate(loop, gain)) + np.pi) % (2 * np.pi)  # lag still to spend until -1, in [0, 2 pi)
    gains = 1.0 / np.abs(evaluate(loop, phase)) if len(phase) else np.zeros(0)
    modulus, where = _modulus_margin(loop, response)
    return Margins(
        gain_margin=float(gains[gains > 1].min(initial=np.inf)),
        gain_reduction_margin=float(gains[gains < 1].max(initial=0.0)),
        phase_margin=float(lags.min(initial=np.inf)),
        delay_margin=float((lags / gain).min(initial=np.inf)) if len(gain) else np.inf,
        modulus_margin=modulus,
        gain_crossovers=gain,
        phase_crossovers=phase,
        modulus_frequency=where,
        floor=floor,
    )


def _gain_crossovers(loop: DelayLTI, response: FrequencyResponse) -> FloatArray:
    def excess(w: float) -> float:
        return float(np.log(np.abs(evaluate(loop, np.array([w]))[0])))

    value = np.log(np.abs(response.value))
    return np.array([_root(excess, response.omega, int(k)) for k in np.flatnonzero(value[1:] * value[:-1] <= 0)])


def _phase_crossovers(loop: DelayLTI, response: FrequencyResponse, floor: float) -> FloatArray:
    def quadrature(w: float) -> float:
        return float(evaluate(loop, np.array([w]))[0].imag)

    L = response.value
    crossing = (L.imag[1:] * L.imag[:-1] <= 0) & (L.real[1:] < 0) & (L.real[:-1] < 0)
    big = (np.abs(L[1:]) > 0.9 * floor) | (np.abs(L[:-1]) > 0.9 * floor)
    roots = np.array([_root(quadrature, response.omega, int(k)) for k in np.flatnonzero(crossing & big)])
    return roots[np.abs(evaluate(loop, roots)) > floor] if len(roots) else roots


def _root(function: Callable[[float], float], omega: FloatArray, k: int) -> float:
    return bracketed_root(function, float(omega[k]), float(omega[k + 1]))


def _modulus_margin(loop: DelayLTI, response: FrequencyResponse) -> tuple[float, float]:
    """The smallest |1 + L|: best grid point refined between its neighbours, or the limit at infinite frequency."""

    def distance(log_w: float) -> float:
        return float(abs(1.0 + evaluate(loop, np.exp(np.array([log_w])))[0]))

    grid = np.abs(1.0 + response.value)
    chain = np.linalg.inv(np.eye(loop.n_delays) - np.abs(loop.D22))
    delayed = np.abs(loop.D12) @ chain @ np.abs(loop.D21)
    best, where = float(abs(1.0 + loop.D11[0, 0]) - delayed[0, 0]), np.inf
    lowest = np.flatnonzero((grid[1:-1] <= grid[:-2]) & (grid[1:-1] <= grid[2:])) + 1
    for k in lowest[grid[lowest] < grid.min() * 1.05]:
        left, right = (float(np.log(response.omega[k + side])) for side in (-1, 1))
        log_w, *_ = fminbound(distance, left, right, xtol=1e-12, full_output=True)
        if distance(float(log_w)) < best:
            best, where = distance(float(log_w)), float(np.exp(log_w))
    return best, where

"""Compiled sweeps over gains of the yaw loop (Numba)."""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.delay.kernels.march import largest, last_time_outside, march


@numba.njit(cache=True)
def recovery_times(b, kp, kd, delay, duration, ratio, horizon, rule):
    """Recovery times [s] for gains kp, kd (k,): last entry into `ratio` times the peak; inf if later than horizon.

    The loop is psi'' = -b psi' - (kp psi + kd psi')(t - delay) + pulse, from rest.
    """
    times = np.empty(len(kp))
    A, B1, B2 = np.array([[0.0, 1.0], [0.0, -b]]), np.array([[0.0], [1.0]]), np.array([[0.0], [-1.0]])
    C1, D11, D12 = np.array([[1.0, 0.0]]), np.zeros((1, 1)), np.zeros((1, 1))
    D21, D22, tau = np.zeros((1, 1)), np.zeros((1, 1)), np.array([delay])
    edges, inputs = np.array([0.0, duration]), np.array([[1.0], [0.0]])
    x0, z0 = np.zeros(2), np.zeros(1)
    for k in range(len(kp)):
        C2 = np.array([[kp[k], kd[k]]])
        starts, lengths, series, _ = march(
            (A, B1, B2, C1, C2, D11, D12, D21, D22, tau), edges, inputs, x0, z0, horizon, rule
        )
        yaw = series[:, 0]
        peak, _ = largest(starts, lengths, yaw)
        times[k] = last_time_outside(starts, lengths, yaw, ratio * peak)
    return times


@numba.njit(cache=True)
def _distance(b, kp, kd, delay, w):
    """|1 + (kp + kd j w) exp(-j w T) / (j w (j w + b))|^2."""
    value = 1.0 + (kp + 1j * w * kd) * np.exp(-1j * w * delay) / (1j * w * (1j * w + b))
    return value.real * value.real + value.imag * value.imag


@numba.njit(cache=True)
def modulus_margins(b, kp, kd, delay, grid):
    """Modulus margins for gains kp, kd (k,): the nearest point to -1 on a grid of w, refined by golden section."""
    margins = np.empty(len(kp))
    turn = np.exp(-1j * grid * delay) / (1j * grid * (1j * grid + b))
    ratio = 0.6180339887498949
    for k in range(len(kp)):
        best, where = 1.0, -1
        for i in range(len(grid)):
            value = 1.0 + (kp[k] + 1j * grid[i] * kd[k]) * turn[i]
            distance = value.real * value.real + value.imag * value.imag
            if distance < best:
                best, where = distance, i
        if 0 < where < len(grid) - 1:
            low, high = grid[where - 1], grid[where + 1]
            for _ in range(40):
                left, right = high - ratio * (high - low), low + ratio * (high - low)
                if _distance(b, kp[k], kd[k], delay, left) < _distance(b, kp[k], kd[k], delay, right):
                    high = right
                else:
                    low = left
            best = min(best, _distance(b, kp[k], kd[k], delay, 0.5 * (low + high)))
        margins[k] = np.sqrt(best)
    return margins

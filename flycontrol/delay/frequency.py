"""Frequency response of a single-input single-output loop on a grid that follows its own turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.delay.balance import balance, root_bound
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError


@dataclass(frozen=True, slots=True, eq=False)
class FrequencyResponse:
    """L(j w) on rising frequencies."""

    omega: FloatArray  #: angular frequency [rad/s], shape (k,)
    value: ComplexArray  #: L(j omega), shape (k,)

    @property
    def magnitude(self) -> FloatArray:
        """|L|, shape (k,)."""
        return np.abs(self.value)

    @property
    def phase(self) -> FloatArray:
        """Continuous phase of L [rad], shape (k,), starting in (-pi, pi]."""
        return np.unwrap(np.angle(self.value))


def require_siso(system: DelayLTI) -> None:
    """Refuse anything but one input and one output.

    Raises
    ------
    InvalidParameterError
        With the numbers that arrived.
    """
    if (system.n_inputs, system.n_outputs) != (1, 1):
        raise InvalidParameterError(
            f"Margins need a loop with one input and one output, got {system.n_inputs} and {system.n_outputs}."
        )


def evaluate(system: DelayLTI, omega: FloatArray) -> ComplexArray:
    """L(j omega) of a single-input single-output system, shape of omega [rad/s]."""
    return system(1j * omega)[..., 0, 0]


def frequency_response(system: DelayLTI, low: float, high: float, turn: float = 0.1) -> FrequencyResponse:
    """L(j w) from `low` to `high` [rad/s], refined until log L moves by less than `turn` between neighbours.

    Raises
    ------
    InvalidParameterError
        If the system is not SISO or the range is empty.
    """
    require_siso(system)
    if not 0 < low < high:
        raise InvalidParameterError(f"A frequency range needs 0 < low < high rad/s, got {low!r} and {high!r}.")
    omega = np.geomspace(low, high, 60)
    value = evaluate(system, omega)
    for _ in range(30):
        gap = np.diff(omega)
        logs = np.log(np.where(value == 0, 1e-300, value))
        step = np.abs(logs[1:] - logs[:-1])
        step = np.where(step > np.pi, np.hypot(np.diff(logs.real), np.angle(np.exp(1j * np.diff(logs.imag)))), step)
        # a delay turns L by tau dw: without this bound a gap of a whole turn would look like no step at all
        rough = np.flatnonzero(((step > turn) | (gap * system.tau.sum() > 0.5)) & (gap > 1e-9 * omega[1:]))
        if len(rough) == 0 or len(omega) > 200_000:
            break
        middle = np.sqrt(omega[rough] * omega[rough + 1])
        omega = np.insert(omega, rough + 1, middle)
        value = np.insert(value, rough + 1, evaluate(system, middle))
    return FrequencyResponse(omega, value)


def active_range(system: DelayLTI) -> tuple[float, float]:
    """Frequencies [rad/s] between which |L| can cross 1: from far below every rate to where a bound has |L| < 1."""
    x = balance(system)
    radius = max(root_bound(x, 0.0), 1e-12)
    rates = np.abs(np.linalg.eigvals(x.A)) if x.n_states else np.zeros(0)
    slowest = min([r for r in rates if r > 1e-9 * radius] + [1.0 / t for t in x.tau] + [radius])
    growth = np.linalg.norm(x.B1) + np.linalg.norm(x.B2) * np.linalg.norm(x.D21)
    reading = np.linalg.norm(x.C1) + np.linalg.norm(x.D12) * np.linalg.norm(x.C2)
    return 1e-5 * slowest, 2.0 * radius + 2.0 * float(growth * reading)

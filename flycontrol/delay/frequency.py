"""Frequency response of a single-input single-output loop on a grid that follows its own turns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flycontrol.delay.balance import balance, root_bound
from flycontrol.delay.frequency_domain import FrequencyDomain, frequency_domain
from flycontrol.delay.panels import kernel_blocks, transfer
from flycontrol.delay.real import real_number
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand
    from flycontrol.delay.plots.style import AxesArray


@dataclass(frozen=True, slots=True, eq=False)
class FrequencyResponse:
    """L(j w) on rising frequencies: magnitude and phase of Bode's diagram, and of Nichols's with one over the other."""

    omega: FloatArray  #: angular frequency [rad/s], shape (k,)
    value: ComplexArray  #: L(j omega), shape (k,)

    @property
    def magnitude(self) -> FloatArray:
        """|L|, shape (k,)."""
        return np.abs(self.value)

    @property
    def decibels(self) -> FloatArray:
        """20 log10 |L| [dB], shape (k,)."""
        return 20.0 * np.log10(np.maximum(self.magnitude, 1e-300))

    @property
    def phase(self) -> FloatArray:
        """Continuous phase of L [rad], shape (k,), starting in (-pi, pi]."""
        return np.unwrap(np.angle(self.value))

    def plot(self, **options: Any) -> AxesArray:
        """Draw it; options and return value as in `bode_plot`."""
        from flycontrol.delay.plots import bode_plot

        return bode_plot(self, **options)


def require_siso(system: DelayLTI) -> None:
    """Refuse anything but one input and one output.

    Raises
    ------
    InvalidParameterError
        With the numbers that arrived.
    """
    if (system.n_inputs, system.n_outputs) != (1, 1):
        raise InvalidParameterError(
            "Needed is a system with one input and one output, got shape (outputs, inputs) = "
            f"{(system.n_outputs, system.n_inputs)}; multiply it by a row and a column that pick one of each."
        )


def evaluate(system: DelayLTI, omega: FloatArray) -> ComplexArray:
    """L(j omega) of a single-input single-output system, shape of omega [rad/s]; infinite at a pole on the axis."""
    points = 1j * np.asarray(omega, dtype=np.float64)
    return transfer(kernel_blocks(balance(system)), points.ravel())[0][:, 0, 0].reshape(points.shape)


def frequency_response(
    system: Operand, low: float | None = None, high: float | None = None, turn: float = 0.1
) -> FrequencyResponse:
    """L(j w) from `low` to `high` [rad/s], refined until log L moves by less than `turn` between neighbours.

    The grid starts from panels on which L is a polynomial, so that no resonance falls between its points. It leaves out
    poles on the imaginary axis. Limits left out are those of `active_range`.

    Raises
    ------
    InvalidParameterError
        If the system is not SISO, the range is empty or the turn is not > 0.
    """
    it = frequency_domain(system)
    require_siso(it.system)
    lowest, highest = _active(it)
    low = lowest if low is None else real_number(low, "The lowest frequency [rad/s]")
    high = highest if high is None else real_number(high, "The highest frequency [rad/s]")
    if not 0 < low < high:
        raise InvalidParameterError(f"A frequency range needs 0 < low < high rad/s, got {low!r} and {high!r}.")
    if not 0 < real_number(turn, "The turn between neighbours") < np.inf:
        raise InvalidParameterError(f"The turn between neighbours must be > 0 and finite, got {turn!r}.")
    between, pieces = it.stretches(low, high), it.panels(low, high)
    even = np.geomspace(low, high, 60)
    even = even[[any(a <= w <= b for a, b in between) for w in even]]
    centre, half = pieces.centre.imag, pieces.half.imag
    omega = np.unique(np.concatenate([even, centre - half, centre, centre + half]))
    omega = omega[np.append(True, np.diff(omega) > 1e-9 * omega[1:])]
    return _refined(it, omega, [b for _, b in between[:-1]], turn)


def _refined(it: FrequencyDomain, omega: FloatArray, poles: list[float], turn: float) -> FrequencyResponse:
    """Points added between neighbours apart by more than `turn`, but none across a pole."""
    value = it.values(omega)[:, 0, 0]
    for _ in range(40):
        nonzero = np.where(value == 0, 1e-150, value)
        step = np.abs(np.log(nonzero[1:] / nonzero[:-1]))
        gap = np.diff(omega)
        across = np.searchsorted(poles, omega[:-1] * (1 + 1e-9)) < np.searchsorted(poles, omega[1:] * (1 - 1e-9))
        rough = np.flatnonzero((step > turn) & (gap > 1e-9 * omega[1:]) & ~across)
        if len(rough) == 0 or len(omega) > 200_000:
            break
        middle = np.sqrt(omega[rough] * omega[rough + 1])
        omega = np.insert(omega, rough + 1, middle)
        value = np.insert(value, rough + 1, it.values(middle)[:, 0, 0])
    return FrequencyResponse(omega, value)


def active_range(system: DelayLTI) -> tuple[float, float]:
    """Frequencies [rad/s] between which |L| can cross 1: from far below every rate to where a bound has |L| < 1."""
    return _active(frequency_domain(system))


def _active(it: FrequencyDomain) -> tuple[float, float]:
    low = 1e-5 * it.slowest_rate()
    return low, max(2.0 * root_bound(it.system, 0.0), it.far.beyond(1.0), 10.0 * low)

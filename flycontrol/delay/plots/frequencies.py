"""Which frequencies a picture covers, and the responses over them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.frequency import FrequencyResponse, evaluate, frequency_response, require_siso
from flycontrol.delay.plots.comparison import Beside, Curve, curves, listed
from flycontrol.delay.system import DelayLTI
from flycontrol.errors import InvalidParameterError

_STILL = np.radians(1.0)  # change of phase along an asymptote
_MOST_TURNS = 30.0  # radians of delay: beyond, the phase is a wall


def frequency_curves(
    data: Any, omega: ArrayLike | None, omega_limits: Sequence[float] | None, beside: Beside
) -> list[Curve[FrequencyResponse]]:
    """Frequency responses of everything in `data` over one range.

    Parameters
    ----------
    omega
        Frequencies [rad/s]; when left out they follow the turns of each response.
    omega_limits
        Lowest and highest frequency [rad/s]; when left out, around all rates of the systems.

    Raises
    ------
    InvalidParameterError
        If a system has more than one input or output, or frequencies are not > 0 and rising.
    """
    if omega is not None:
        grid = _checked(omega)
        return curves(data, FrequencyResponse, lambda system: _at(system, grid), beside)
    systems = [as_delay_lti(item) for item in listed(data) if not isinstance(item, FrequencyResponse)]
    if omega_limits is None:
        ranges = [_range(system) for system in systems]
        ranges += [(item.omega[0], item.omega[-1]) for item in listed(data) if isinstance(item, FrequencyResponse)]
        low, high = min(low for low, _ in ranges), max(high for _, high in ranges)
    elif len(omega_limits) == 2:
        low, high = float(omega_limits[0]), float(omega_limits[1])
    else:
        raise InvalidParameterError(f"Limits of frequency are a lowest and a highest one, got {omega_limits!r}.")
    return curves(data, FrequencyResponse, lambda system: frequency_response(system, low, high), beside)


def frequencies_shown(responses: list[FrequencyResponse], *, asked: Any) -> tuple[float, float]:
    """First and last frequency of a picture [rad/s].

    Unless frequencies were asked for, of the asymptote at the start, where every phase stays within a degree, only the
    last decade.
    """
    low, high = float(responses[0].omega[0]), float(responses[0].omega[-1])
    if asked:
        return low, high
    turns = [_first_turn(response) for response in responses]
    return max(low, min(0.1 * min(turns), 0.1 * high)), high


def _first_turn(response: FrequencyResponse) -> float:
    moved = np.flatnonzero(np.abs(response.phase - response.phase[0]) > _STILL)
    return float(response.omega[moved[0]] if len(moved) else response.omega[0])


def _checked(omega: ArrayLike) -> Any:
    grid = np.asarray(omega, dtype=np.float64)
    if not (grid.ndim == 1 and len(grid) > 1 and grid[0] > 0 and (np.diff(grid) > 0).all() and np.isfinite(grid[-1])):
        raise InvalidParameterError(
            "Frequencies must be at least 2 finite ones, > 0 and rising [rad/s]; for a range alone give omega_limits."
        )
    return grid


def _at(system: DelayLTI, omega: Any) -> FrequencyResponse:
    require_siso(system)
    return FrequencyResponse(omega, evaluate(system, omega))


def _range(system: DelayLTI) -> tuple[float, float]:
    """From a tenth of the slowest rate to ten times the fastest, but not beyond some turns of the longest delay."""
    require_siso(system)
    rates = np.abs(np.linalg.eigvals(system.A)) if system.n_states else np.zeros(0)
    fastest = float(rates.max(initial=0.0))
    kept = [*rates[rates > 1e-9 * fastest], *(1.0 / system.tau)] or [1.0]
    low, high = 0.1 * float(min(kept)), 10.0 * float(max(kept))
    if system.n_delays:
        high = min(high, max(_MOST_TURNS / float(system.tau.max()), 100.0 * low))
    return low, high

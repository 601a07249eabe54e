"""What the step costs: the first wingbeat repeated with half the steps."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.kernels.march import LEFT, LEFT_RATE, QUATERNION, SAMPLE, SPIN, VELOCITY, march
from flycontrol.flight.multibody.constants import Constants
from flycontrol.flight.settings import MarchSettings
from flycontrol.model.trajectory import StepError

FloatArray = NDArray[np.float64]

_ORDER = 4


def coarse_end(
    start: FloatArray, drive: FloatArray, step: float, outside: FloatArray, constants: Constants
) -> FloatArray:
    """State (25,) after one wingbeat of steps 2 h.

    Parameters
    ----------
    start : (25,) state at its beginning, not changed
    drive : (2 n + 1, 2, 12) for steps of h
    step : h [s]
    outside : (n, 6)
    """
    y, half = start.copy(), every_second(outside)
    coarsely = np.ascontiguousarray(drive[::2])  # strides of another kind would compile the march once more
    march(y, coarsely, 2 * step, half, len(half), *constants.arguments, np.empty((1, SAMPLE)))
    return y


def every_second(outside: FloatArray) -> FloatArray:
    """(n / 2, ...) mean loads over two steps from (n, ...)."""
    return (outside[::2] + outside[1::2]) / 2


def step_error_between(coarse: FloatArray, fine: FloatArray, step: float, settings: MarchSettings) -> StepError:
    """|x(2 h) - x(h)| / 15; InvalidParameterError when it exceeds the tolerance.

    Parameters
    ----------
    coarse, fine : (25,) state after one wingbeat of steps 2 h and h, or (13,) its part of the body alone
    step : h [s]
    settings : steps a wingbeat, tolerance
    """
    error = halving_error(coarse, fine)
    refuse_coarse(error, step, settings)
    return error


def halving_error(coarse: FloatArray, fine: FloatArray) -> StepError:
    """|x(2 h) - x(h)| / 15 of states (25,) or (13,), however large."""
    apart = (coarse - fine) / (2**_ORDER - 1)
    return StepError(
        position=_length(apart[:QUATERNION]),
        velocity=_length(apart[VELOCITY:SPIN]),
        attitude=2 * _length(apart[QUATERNION:VELOCITY]),
        angular_velocity=_length(apart[SPIN:LEFT]),
        wing_angle=float(np.max(np.abs(apart[LEFT:LEFT_RATE]), initial=0.0)),
    )


def _length(vector: FloatArray) -> float:
    return float(np.linalg.norm(vector))


def refuse_coarse(error: StepError, step: float, settings: MarchSettings, wingbeat: int = 0) -> None:
    """InvalidParameterError where an error exceeds the tolerance.

    Angles count as they are: an error of the tolerance in radians over a wingbeat is too much.
    """
    largest = max(error.attitude, error.wing_angle)
    if largest <= settings.tolerance:
        return
    if not math.isfinite(largest):
        advice = "it diverges within one wingbeat; take many more steps, or check the fly"
    else:
        enough = settings.steps * (largest / settings.tolerance) ** (1 / _ORDER)
        advice = f"about {2 * math.ceil(0.6 * enough)} steps would do"
    raise InvalidParameterError(
        f"{settings.steps} steps a wingbeat ({step * 1e6:.3g} us each) leave an error of {largest:.2g} rad after one "
        f"wingbeat (number {wingbeat}, counted from 0), where {settings.tolerance:.2g} rad is asked for; {advice}."
    )

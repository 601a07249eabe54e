"""Real numbers, arrays of them and functions at the door of a call: what is none is refused in a sentence."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError


def real_number(value: Any, what: str) -> float:
    """The value as a float; NaN and infinity pass.

    Raises
    ------
    InvalidParameterError
        If it is not a real number.
    """
    if isinstance(value, int | float):
        return float(value)
    if isinstance(value, np.number | np.ndarray) and np.ndim(value) == 0 and value.dtype.kind in "iuf":
        return float(value)
    raise InvalidParameterError(f"{what} must be a real number, got {_shown(value)}.")


def real_array(values: Any, what: str, ndmin: int = 0) -> NDArray[np.float64]:
    """The values as a new array of float64.

    Raises
    ------
    InvalidParameterError
        If they are not real numbers, or their rows differ in length.
    """
    try:
        found = np.array(values, ndmin=ndmin)
    except ValueError as refusal:
        raise InvalidParameterError(
            f"{what} must be real numbers in rows equally long, got {_shown(values)}."
        ) from refusal
    if found.dtype.kind not in "biuf":
        raise InvalidParameterError(f"{what} must be real numbers, got {_shown(values)}.")
    return found.astype(np.float64)


def require_callable(function: Any, what: str) -> Callable[..., Any]:
    """The function.

    Raises
    ------
    InvalidParameterError
        If it cannot be called.
    """
    if not callable(function):
        raise InvalidParameterError(f"{what} must be a function, got {_shown(function)}.")
    return function


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."

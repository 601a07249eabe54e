"""One evaluation of compiled right-hand sides in Python, where reading outside an array is an error and not a crash."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from flycontrol.delay.system import FloatArray
from flycontrol.errors import InvalidParameterError

_PARTS = ("x", "w", "u", "p")


def require_right_hand_sides(
    slope: Callable[..., Any], delayed: Callable[..., Any], state: FloatArray, inputs: int, p: FloatArray, delays: int
) -> None:
    """Try the Python originals of f (n,) and h (q,) at time 0, w being first zero and then what h returns.

    Raises
    ------
    InvalidParameterError
        If one does not take (t, x, w, u, p), reads outside these, fails, or returns anything but its array.
    """
    u = np.zeros(inputs)
    z = _tried("delayed", delayed, (state, np.zeros(delays), u, p), delays, "one a delay")
    _tried("slope", slope, (state, z, u, p), len(state), "one a state")


def _tried(
    name: str, function: Callable[..., Any], arguments: tuple[FloatArray, ...], many: int, each: str
) -> FloatArray:
    taken = len(inspect.signature(function).parameters)
    if taken != 5:
        raise InvalidParameterError(f"`{name}` must take five arguments (t, x, w, u, p), got a function of {taken}.")
    try:
        with np.errstate(all="ignore"):
            value = function(0.0, *[argument.copy() for argument in arguments])
    except IndexError as outside:
        there_are = ", ".join(f"{len(a)} in {part}" for part, a in zip(_PARTS, arguments, strict=True))
        raise InvalidParameterError(
            f"`{name}` reads outside its arguments ({outside}): there are {there_are}; give the parameters, inputs, "
            "delays and states that it reads."
        ) from outside
    except Exception as failure:  # whatever a user's function does
        raise InvalidParameterError(
            f"`{name}` fails at the start, at t = 0 with x = {arguments[0].tolist()!r}: {type(failure).__name__}: "
            f"{failure}."
        ) from failure
    if not (isinstance(value, np.ndarray) and value.shape == (many,) and value.dtype == np.float64):
        got = f"{value.dtype} of shape {value.shape}" if isinstance(value, np.ndarray) else type(value).__name__
        raise InvalidParameterError(f"`{name}` must return a float64 array of shape {(many,)}, {each}, got {got}.")
    return value

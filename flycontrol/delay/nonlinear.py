"""Time response of nonlinear delay systems by the collocation of the linear ones, iterated.

On each panel x' = J x + (f - J x) is solved for x with the last iterate on the right, J being the Jacobian at the
panel's start: the linear system's collocation, which is what this reduces to, in one iteration, when f is linear.
Panels end at every kink: input edges, kinks of the past, and their images under up to eight delays, after which a kink
is one of the ninth derivative. No panel is longer than the shortest delay. Its length follows from the last Legendre
coefficients of x' (degrees 8 and 9), integrated, against atol + rtol |x|.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.history import StateHistory
from flycontrol.delay.kernels import march as linear_kernels
from flycontrol.delay.kernels import nonlinear as kernels
from flycontrol.delay.panel_march import Past, past_of, steady_inputs
from flycontrol.delay.piecewise import PiecewisePolynomial, fitted
from flycontrol.delay.real import real_array, real_number
from flycontrol.delay.response import Response, collocation_rule
from flycontrol.delay.system import FloatArray
from flycontrol.delay.trial import require_right_hand_sides
from flycontrol.errors import InvalidParameterError

_KINK_ORDER = 8
_MOST_PANELS = 1_000_000

#: An njit function or a cfunc (t, x, w, u, p) -> float64 array.
Compiled = Any


def nonlinear_response(  # noqa: PLR0913 (an experiment has these parts)
    slope: Compiled,
    delayed: Compiled,
    tau: ArrayLike,
    end: float,
    initial_state: ArrayLike,
    *,
    inputs: PiecewisePolynomial | None = None,
    parameters: ArrayLike = (),
    history: StateHistory | None = None,
    breaks: Sequence[float] = (),
    rtol: float = 1e-10,
    atol: float = 1e-12,
) -> Response:
    """x' = f(t, x, w, u, p), z = h(t, x, w, u, p), w_i(t) = z_i(t - tau_i): the states from 0 to `end` [s].

    Parameters
    ----------
    slope, delayed
        f -> (n,) and h -> (q,), compiled: `numba.njit` functions, or `numba.cfunc` ones of five arguments (a float and
        four contiguous float64 arrays) that return such an array. f is smooth in x between kinks in time. Both are
        tried once in Python; compiled code does not notice when it reads outside an array later.
    tau
        Delays [s], shape (q,), each > 0.
    initial_state
        State (n,) at time 0, and before it unless there is a history.
    inputs
        Signals (m) from time 0 to the end; none when left out. Before time 0 they are taken as zero.
    parameters
        Handed to f and h as p, shape (k,).
    history
        States (n,) at times t < 0 [s]; h must then not depend on w.
    breaks
        Times < 0 [s] of the history's kinks and jumps.
    rtol, atol
        The part of x that the last two Legendre coefficients of x' hold on a panel stays below atol + rtol |x|.

    Returns
    -------
    The states as the outputs of a piecewise polynomial.

    Raises
    ------
    InvalidParameterError
        If arguments do not fit, f or h reads more than there is or returns another shape, or the state cannot be
        followed to the end: it escapes to infinity or f is not smooth.
    """
    lags, x0 = real_array(tau, "Delays [s]", 1), real_array(initial_state, "The initial state", 1)
    p = real_array(parameters, "Parameters", 1)
    end, rtol, atol = (
        real_number(value, what) for value, what in ((end, "The end of a response [s]"), (rtol, "rtol"), (atol, "atol"))
    )
    _require(lags, x0, end, rtol, atol)
    signal = _signal(inputs, end)
    u = np.zeros(signal.series.shape[1])
    require_right_hand_sides(_in_python(slope), _in_python(delayed), x0, len(u), p, len(lags))
    f, h = _first_class(slope), _first_class(delayed)
    if history is None or len(lags) == 0:
        past = _constant_past(h, lags, x0, u, p)
    else:
        past = _varying_past(h, lags, u, p, history, breaks)
    pieces = (signal.starts.copy(), signal.lengths.copy(), np.ascontiguousarray(signal.series))
    starts, lengths, series, states, reached = kernels.march(
        f, h, lags, _kinks(past, signal, lags, end), tuple(past), pieces, p, x0, collocation_rule(), float(rtol),
        float(atol), _MOST_PANELS,
    )  # fmt: skip
    _require_the_end(reached, end)
    return Response(starts, lengths, series, states)


def _require(tau: FloatArray, x0: FloatArray, end: float, rtol: float, atol: float) -> None:
    if not ((tau > 0).all() and np.isfinite(tau).all() and tau.ndim == 1):
        raise InvalidParameterError(f"Delays must be > 0 s, got {tau.tolist()!r}.")
    if not (end > 0 and np.isfinite(end)):
        raise InvalidParameterError(f"The end of a response must be > 0 s, got {end!r}.")
    if not (x0.ndim == 1 and np.isfinite(x0).all()):
        raise InvalidParameterError(f"The initial state must be finite numbers (n,), got {x0.tolist()!r}.")
    if not (rtol >= 1e-13 and atol > 0):
        raise InvalidParameterError(f"Tolerances must be rtol >= 1e-13 and atol > 0, got {rtol!r} and {atol!r}.")


def _require_the_end(reached: float, end: float) -> None:
    if reached < end * (1 - 1e-12):
        raise InvalidParameterError(
            f"The state cannot be followed beyond {reached:.6g} s: it escapes to infinity or the right-hand side is "
            "not smooth there; end earlier, or smooth the right-hand side."
        )


def _signal(inputs: PiecewisePolynomial | None, end: float) -> PiecewisePolynomial:
    """Inputs that cover the response, (0) of them when left out."""
    signal = steady_inputs(np.zeros(0), end) if inputs is None else inputs
    if signal.starts[0] > 0 or signal.end < end * (1 - 1e-12):
        raise InvalidParameterError(f"Inputs must cover 0..{end:g} s, got {signal.starts[0]:g}..{signal.end:g} s.")
    return signal


def _kinks(past: Past, signal: PiecewisePolynomial, tau: FloatArray, end: float) -> FloatArray:
    """Times from 0 on at which panels must end [s], rising."""
    edges = np.concatenate([past.starts[1:], [0.0], signal.starts[signal.starts > 0]])
    return np.unique(np.append(0.0, linear_kernels.breakpoints(edges, tau, float(end), _KINK_ORDER)))


def _constant_past(h: Compiled, tau: FloatArray, x0: FloatArray, u: FloatArray, p: FloatArray) -> Past:
    """Delayed signals of a state that never changed."""
    z = np.zeros(len(tau))
    for _ in range(len(tau) + 1):  # in a chain of delays each turn settles one more of them
        z = np.asarray(h(0.0, x0, z, u, p), dtype=np.float64)
    degree = len(collocation_rule()[0])
    return Past(*linear_kernels.constant_past(z, tau, degree))


def _varying_past(
    h: Compiled, tau: FloatArray, u: FloatArray, p: FloatArray, history: StateHistory, breaks: Sequence[float]
) -> Past:
    """Delayed signals of states that had a history."""
    unknown = np.full(len(tau), np.nan)

    def signals(t: float) -> FloatArray:
        z = np.asarray(h(t, np.array(history(t), dtype=np.float64), unknown, u, p), dtype=np.float64)
        if z.shape != tau.shape or not np.isfinite(z).all():
            raise InvalidParameterError(
                f"With a history, the delayed signals must be {len(tau)} finite numbers that do not depend on w, got "
                f"{z.tolist()!r} at {t:g} s."
            )
        return z

    longest = float(tau.max())
    inside = sorted(mark for mark in breaks if -longest * (1 - 1e-12) < mark < -1e-12 * longest)
    return past_of(fitted(signals, [-longest, *inside, 0.0]))


def _in_python(function: Compiled) -> Callable[..., Any]:
    found = kernels.in_python(function)
    if found is None:
        raise InvalidParameterError(
            f"Right-hand sides must be compiled by numba.njit or numba.cfunc, got {type(function).__name__}; "
            "decorate it."
        )
    return found


def _first_class(function: Compiled) -> Compiled:
    found = kernels.first_class(function)
    if isinstance(found, str):
        raise InvalidParameterError(
            "A right-hand side (t, x, w, u, p) must return a float64 array for a float and four float64 arrays; Numba "
            f"says: {found}"
        )
    return found

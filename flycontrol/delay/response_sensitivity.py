"""Derivatives of a response with respect to parameters and delays, from the sensitivity equations on the same panels.

With a dot for d/dparameter, w_i(t) = z_i(t - tau_i) has dw_i = dz_i(t - tau_i) - tau_i. z_i'(t - tau_i), and the
derivatives obey a delay system with the same A, B2, C2, D22 and delays, driven by the signals of the response itself:

    dx' = A dx + B2 dw + (dA x + dB1 u + dB2 w),  likewise dy and dz.

Where z_i jumps at t, dw_i holds an impulse -tau_i. [z_i] at t + tau_i, and so dx jumps there by B2 times it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike

from flycontrol.delay.history import StateHistory
from flycontrol.delay.kernels import march as kernels
from flycontrol.delay.panel_march import March, Past, march_panels, past_of
from flycontrol.delay.piecewise import PiecewisePolynomial, fitted
from flycontrol.delay.response import Response, collocation_rule
from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.delay.timeresponse import experiment_march
from flycontrol.errors import InvalidParameterError


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BlockDerivatives:
    """d/dparameter of each block of a `DelayLTI` and of the initial state; what is left out does not depend on it."""

    A: ArrayLike | None = None
    B1: ArrayLike | None = None
    B2: ArrayLike | None = None
    C1: ArrayLike | None = None
    C2: ArrayLike | None = None
    D11: ArrayLike | None = None
    D12: ArrayLike | None = None
    D21: ArrayLike | None = None
    D22: ArrayLike | None = None
    tau: ArrayLike | None = None  #: shape (q,), 1 for the delay that is the parameter
    initial_state: ArrayLike | None = None  #: shape (n,); the constant past moves with it


@dataclass(frozen=True, slots=True, eq=False)
class ResponseSensitivity:
    """A response and its derivatives, each a piecewise polynomial; at a breakpoint they hold the right-hand value.

    The left-hand value is that of the panel before. Where the output itself jumps at a time that moves with the
    parameter, its derivative holds an impulse there, which a value cannot show: beside that time it is exact.
    """

    response: Response
    derivatives: tuple[Response, ...]  #: one for each parameter, outputs in output / parameter

    def __call__(self, times: ArrayLike) -> FloatArray:
        """Derivatives (k, p, len(times)) at non-decreasing times [s]."""
        return np.stack([derivative(times) for derivative in self.derivatives])


def delay_derivatives(system: DelayLTI) -> tuple[BlockDerivatives, ...]:
    """Each delay of a system as a parameter."""
    return tuple(BlockDerivatives(tau=unit) for unit in np.eye(system.n_delays))


def response_sensitivity(
    system: DelayLTI,
    parameters: Sequence[BlockDerivatives],
    inputs: PiecewisePolynomial,
    initial_state: ArrayLike | None = None,
    *,
    history: StateHistory | None = None,
    breaks: Sequence[float] = (),
) -> ResponseSensitivity:
    """Response to inputs over their range and its exact derivatives with respect to parameters.

    Parameters
    ----------
    parameters
        One entry a parameter; a parameter that moves a delay may move blocks too.
    inputs
        From time 0 to the end of the response; they do not depend on the parameters.
    initial_state, history, breaks
        As in `initial_response`.

    Raises
    ------
    InvalidParameterError
        If shapes do not fit, or a history that varies meets delays in a chain (D22), whose past moves with the delays.
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    start = history(0.0) if initial_state is None and history is not None else initial_state
    x0 = np.zeros(system.n_states) if start is None else np.array(start, dtype=np.float64)
    if history is not None and system.D22.any():
        raise InvalidParameterError(
            "With delays in a chain (D22 not zero), sensitivities need a constant past; merge the chained delays or "
            "leave the history out."
        )
    base = experiment_march(system, inputs.end, inputs, x0, history, breaks)
    slopes = _slopes(base)
    found: list[Response] = []
    for parameter in parameters:
        d = _filled(system, parameter)
        past = _past(system, d, base, x0, history)
        found.append(_derivative(system, d, base, slopes, past))
    return ResponseSensitivity(base.response, tuple(found))


class _Filled(dict[str, FloatArray]):
    """Derivatives by name, zeros where none were given."""


def _filled(system: DelayLTI, parameter: BlockDerivatives) -> _Filled:
    d = _Filled()
    for field in fields(parameter):
        shape = (system.n_states,) if field.name == "initial_state" else getattr(system, field.name).shape
        given = getattr(parameter, field.name)
        d[field.name] = np.zeros(shape) if given is None else np.array(given, dtype=np.float64)
        if d[field.name].shape != shape or not np.isfinite(d[field.name]).all():
            raise InvalidParameterError(
                f"BlockDerivatives.{field.name} must be finite with shape {shape}, got {d[field.name].tolist()!r}."
            )
    return d


def _past(system: DelayLTI, d: _Filled, base: March, x0: FloatArray, history: StateHistory | None) -> Past:
    """d/dparameter of the delayed signals before time 0."""
    if history is not None and system.n_delays:
        marks = np.append(base.past.starts, 0.0)
        moved = fitted(lambda t: d["C2"] @ np.asarray(history(t), dtype=np.float64), marks) if d["C2"].any() else None
        return Past(base.past.starts, base.past.lengths, 0 * base.past.series) if moved is None else past_of(moved)
    signals = base.past.series[0, :, 0]  # constant: z = w
    forcing = d["C2"] @ x0 + system.C2 @ d["initial_state"] + d["D22"] @ signals
    series = np.zeros_like(base.past.series)
    series[0, :, 0] = np.linalg.solve(np.eye(system.n_delays) - system.D22, forcing)
    return Past(base.past.starts, base.past.lengths, series)


def _slopes(base: March) -> FloatArray:
    """Legendre coefficients of z', past included, shape (H + P, q, s + 1)."""
    lengths = np.concatenate([base.past.lengths, base.lengths])
    slopes = np.zeros_like(base.z)
    if base.z.shape[1]:
        slopes[..., :-1] = legendre.legder(base.z, axis=2) * (2 / lengths)[:, None, None]
    return slopes


def _derivative(system: DelayLTI, d: _Filled, base: March, slopes: FloatArray, past: Past) -> Response:
    grid = (base.starts, base.lengths)
    whole = (np.concatenate([base.past.starts, base.starts]), np.concatenate([base.past.lengths, base.lengths]))
    first = len(base.past.starts)
    moved = kernels.delayed_series(*whole, first, system.tau.copy(), slopes, collocation_rule())
    g = -d["tau"][None, :, None] * moved  # what dw holds beside dz(t - tau)
    x = base.x.transpose(0, 2, 1)
    forcing = [
        d["A"] @ x + d["B1"] @ base.u + d["B2"] @ base.w + system.B2 @ g,
        d["C2"] @ x + d["D21"] @ base.u + d["D22"] @ base.w + system.D22 @ g,
        d["C1"] @ x + d["D11"] @ base.u + d["D12"] @ base.w + system.D12 @ g,
    ]
    jumps = kernels.moving_jumps(
        *whole, first, system.tau.copy(), d["tau"], base.z, system.B2.copy(), system.D22.copy()
    )
    driven = _driven(system)
    return march_panels(driven, grid, past, np.concatenate(forcing, axis=1), jumps, d["initial_state"]).response


def _driven(system: DelayLTI) -> DelayLTI:
    """The same system with an input for each state's slope, each delayed signal and each output."""
    n, q, p = system.n_states, system.n_delays, system.n_outputs
    unit = np.eye(n + q + p)
    return replace(system, B1=unit[:n].copy(), D21=unit[n : n + q].copy(), D11=unit[n + q :].copy(), input_names=())

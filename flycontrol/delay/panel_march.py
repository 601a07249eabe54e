"""One march over panels with everything that it leaves behind: what responses and their sensitivities are made from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flycontrol.delay.history import constant_history
from flycontrol.delay.kernels import march as kernels
from flycontrol.delay.piecewise import PiecewisePolynomial
from flycontrol.delay.response import Response, collocation_rule
from flycontrol.delay.system import DelayLTI, FloatArray, require_retarded
from flycontrol.errors import InvalidParameterError


class Past(NamedTuple):
    """Delayed signals before time 0 on H panels, in Legendre coefficients."""

    starts: FloatArray  #: (H,) [s]
    lengths: FloatArray  #: (H,) [s]
    series: FloatArray  #: (H, q, s + 1)


class March(NamedTuple):
    """States and signals on P panels; x, u, w, z in Legendre coefficients, z with the past's panels in front."""

    starts: FloatArray  #: (P,) [s]
    lengths: FloatArray  #: (P,) [s]
    past: Past
    y: FloatArray  #: Chebyshev coefficients of the outputs, shape (P, p, s + 1)
    states: FloatArray  #: at panel starts and at the end, shape (P + 1, n)
    u: FloatArray  #: (P, m, s + 1)
    x: FloatArray  #: (P, s + 1, n)
    w: FloatArray  #: (P, q, s + 1)
    z: FloatArray  #: (H + P, q, s + 1)

    @property
    def response(self) -> Response:
        """The outputs."""
        return Response(self.starts, self.lengths, self.y, self.states)

    @property
    def state_response(self) -> Response:
        """The states as outputs."""
        series = np.ascontiguousarray(np.einsum("ck,Pka->Pac", collocation_rule()[2], self.x))
        return Response(self.starts, self.lengths, series, self.states)


def kernel_blocks(system: DelayLTI) -> tuple[FloatArray, ...]:
    """Blocks as the kernels take them: copies, writeable and contiguous, so that one signature serves all callers."""
    s = system
    return tuple(
        np.array(block, order="C") for block in (s.A, s.B1, s.B2, s.C1, s.C2, s.D11, s.D12, s.D21, s.D22, s.tau)
    )


def grid_of(system: DelayLTI, end: float, inputs: PiecewisePolynomial, past: Past) -> tuple[FloatArray, FloatArray]:
    """Starts and lengths of panels over [0, end] s that no kink falls into."""
    edges = np.concatenate([past.starts[1:], [0.0], inputs.starts[inputs.starts > 0]])
    return kernels.grid_of(kernel_blocks(system), edges, end, collocation_rule())


def march_panels(
    system: DelayLTI, grid: tuple[FloatArray, FloatArray], past: Past, u: FloatArray, jumps: FloatArray, x0: FloatArray
) -> March:
    """March over given panels with inputs u (P, m, s + 1) and state jumps (P, n), none if it has no rows."""
    found = kernels.march_panels(kernel_blocks(system), grid, tuple(past), u, jumps, x0, collocation_rule())
    y, states, x, w, z = found
    return March(*grid, past, y, states, u, x, w, z)


def constant_past(system: DelayLTI, state: FloatArray) -> Past:
    """The past of a state (n,) that never changed."""
    degree = len(collocation_rule()[0])
    return Past(*kernels.constant_past(constant_history(system, state), system.tau.copy(), degree))


def past_of(signals: PiecewisePolynomial) -> Past:
    """Given signals as the past."""
    rule = collocation_rule()
    pieces = (signals.starts.copy(), signals.lengths.copy(), np.ascontiguousarray(signals.series))
    return Past(pieces[0], pieces[1], kernels.projected(pieces, rule, pieces[0], pieces[1]))


def inputs_on(inputs: PiecewisePolynomial, grid: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Legendre coefficients (P, m, s + 1) of the inputs on panels."""
    pieces = (inputs.starts.copy(), inputs.lengths.copy(), np.ascontiguousarray(inputs.series))
    return kernels.projected(pieces, collocation_rule(), *grid)


def steady_inputs(values: FloatArray, end: float) -> PiecewisePolynomial:
    """Inputs (m,) that stay as they are from 0 to the end [s]."""
    return PiecewisePolynomial(np.zeros(1), np.array([end]), values[None, :, None].copy())


def require_experiment(system: DelayLTI, end: float, inputs: PiecewisePolynomial, state: FloatArray) -> None:
    """Refuse ends, inputs and initial states that do not fit the system.

    Raises
    ------
    InvalidParameterError
        If anything does not fit.
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    if not (end > 0 and np.isfinite(end)):
        raise InvalidParameterError(f"The end of a response must be > 0 s, got {end!r}.")
    require_retarded(system)
    if inputs.series.shape[1] != system.n_inputs:
        raise InvalidParameterError(
            f"The system has {system.n_inputs} input(s), the signal {inputs.series.shape[1]}; give one row an input."
        )
    if inputs.starts[0] > 0 or inputs.end < end * (1 - 1e-12):
        raise InvalidParameterError(
            f"Inputs must cover 0..{end:g} s, got {inputs.starts[0]:g}..{inputs.end:g} s; extend them or end earlier."
        )
    if state.shape != (system.n_states,) or not np.isfinite(state).all():
        raise InvalidParameterError(
            f"The initial state must be {system.n_states} finite numbers, got {state.tolist()!r}."
        )

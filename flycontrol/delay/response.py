"""Time response of a delay system, exact to rounding: collocation on panels that start at every kink."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.history import constant_history
from flycontrol.delay.kernels import march as kernels
from flycontrol.delay.real import real_array, real_number
from flycontrol.delay.system import DelayLTI, FloatArray, require_retarded
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand
    from flycontrol.delay.plots.style import AxesArray

_GAUSS_NODES = 10
_REACH = 1.0  # longest panel times the fastest rate: the collocation error is then below 1e-12 of the state


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Response:
    """A time response as a piecewise polynomial; call it for values at any times of its range."""

    starts: FloatArray  #: start of each panel [s], shape (P,)
    lengths: FloatArray  #: length of each panel [s], shape (P,)
    series: FloatArray  #: Chebyshev coefficients of the outputs, shape (P, p, degree + 1)
    states: FloatArray  #: states at panel starts and at the end, shape (P + 1, n)

    def __repr__(self) -> str:
        return f"<Response: {self.series.shape[1]} signal(s) on {len(self.starts)} panels over 0..{self.end:.4g} s>"

    @property
    def end(self) -> float:
        """Last time of the response [s]."""
        return float(self.starts[-1] + self.lengths[-1])

    def __call__(self, times: ArrayLike) -> FloatArray:
        """Outputs (p, len(times)) at non-decreasing times [s].

        Raises
        ------
        InvalidParameterError
            If a time lies outside the range or the times fall.
        """
        t = real_array(times, "Times of a response [s]", 1)
        end = self.end
        if not (t[0] >= self.starts[0] - 1e-12 * end and t[-1] <= end * (1 + 1e-12) and (t[1:] >= t[:-1]).all()):
            raise InvalidParameterError(
                f"Times must rise within 0..{end:g} s, got {t.min():g}..{t.max():g} s; ask for a longer response."
            )
        return kernels.sample(self.starts, self.lengths, self.series, t)

    def last_time_outside(self, band: float, output: int = 0) -> float:
        """Last time at which |y| > band [s]; -1 if it never is, inf if it still is at the end of the response."""
        return float(kernels.last_time_outside(self.starts, self.lengths, self.series[:, output], float(band)))

    def largest(self, output: int = 0) -> tuple[float, float]:
        """Largest |y| and its time [s]."""
        value, time = kernels.largest(self.starts, self.lengths, self.series[:, output])
        return float(value), float(time)

    def plot(self, **options: Any) -> AxesArray:
        """Draw it; options and return value as in `time_response_plot`."""
        from flycontrol.delay.plots import time_response_plot

        return time_response_plot(self, **options)


def response(
    system: Operand,
    end: float,
    edges: ArrayLike = (0.0,),
    inputs: ArrayLike | None = None,
    initial_state: ArrayLike | None = None,
) -> Response:
    """Response from 0 to `end` [s] to a piecewise-constant input, started from rest or from a constant history.

    Parameters
    ----------
    end
        End of the response [s], > 0.
    edges
        Times [s] (k,) at which the input changes, rising from 0; they need no grid.
    inputs
        Input values (k, m) from each edge on; zero when left out.
    initial_state
        State (n,) at time 0, with the delayed signals as if it had been so for ever; zero when left out.

    Raises
    ------
    InvalidParameterError
        If shapes do not fit, edges do not rise from 0, or anything is not finite.
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    end = real_number(end, "The end of a response [s]")
    if not (end > 0 and np.isfinite(end)):
        raise InvalidParameterError(f"The end of a response must be > 0 s, got {end!r}.")
    plant = as_delay_lti(system)
    require_retarded(plant)
    steps = real_array(edges, "Input edges [s]", 1)
    values = np.zeros((len(steps), plant.n_inputs)) if inputs is None else real_array(inputs, "Inputs")
    if values.ndim == 1:
        values = values[:, None]
    if not (steps[0] == 0 and (steps[1:] > steps[:-1]).all()):
        raise InvalidParameterError(f"Input edges must rise from 0 s, got {steps.tolist()!r}.")
    if values.shape != (len(steps), plant.n_inputs) or not np.isfinite(values).all():
        raise InvalidParameterError(
            "Inputs must be finite with one row an edge and one column an input, shape "
            f"{(len(steps), plant.n_inputs)}, got shape {values.shape}."
        )
    if initial_state is None:
        return Response(*_march(plant, float(end), steps, values, np.zeros(plant.n_states), np.zeros(plant.n_delays)))
    x0 = real_array(initial_state, "The initial state")
    if x0.shape != (plant.n_states,) or not np.isfinite(x0).all():
        raise InvalidParameterError(f"The initial state must be {plant.n_states} finite numbers, got {x0.tolist()!r}.")
    return Response(*_march(plant, float(end), steps, values, x0, constant_history(plant, x0)))


def _march(
    system: DelayLTI, end: float, edges: FloatArray, inputs: FloatArray, x0: FloatArray, history: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    s = system
    # copies are writeable and contiguous, so that one compiled signature serves every caller
    C1, C2, tau = s.C1.copy(), s.C2.copy(), s.tau.copy()
    D11, D12, D21, D22 = s.D11.copy(), s.D12.copy(), s.D21.copy(), s.D22.copy()
    blocks = (s.A.copy(), s.B1.copy(), s.B2.copy(), C1, C2, D11, D12, D21, D22, tau)
    return kernels.march(blocks, edges, inputs, x0, history, end, collocation_rule())


@lru_cache(maxsize=1)
def collocation_rule() -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Gauss collocation: nodes in [0, 1], values to Legendre series, Legendre to Chebyshev series, reach.

    Values are those at the start of a panel and the s nodes; both series have s + 1 coefficients.
    """
    x, w = np.polynomial.legendre.leggauss(_GAUSS_NODES)
    s = _GAUSS_NODES
    degrees = np.arange(s)
    to_legendre = np.zeros((s + 1, s + 1))
    to_legendre[:s, 1:] = (degrees[:, None] + 0.5) * np.polynomial.legendre.legvander(x, s - 1).T * w
    to_legendre[s] = (-1.0) ** (s + 1) * ((-1.0) ** degrees @ to_legendre[:s])  # P_s vanishes at the nodes
    to_legendre[s, 0] += (-1.0) ** s
    to_chebyshev = np.zeros((s + 1, s + 1))
    for k in range(s + 1):
        to_chebyshev[: k + 1, k] = np.polynomial.chebyshev.poly2cheb(np.polynomial.legendre.leg2poly(np.eye(k + 1)[k]))
    return (x + 1) / 2, to_legendre, to_chebyshev, _REACH

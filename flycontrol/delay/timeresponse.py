"""Step, impulse, forced and initial responses, named and shaped as python-control's, exact between the samples too."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.history import StateHistory, past_signals
from flycontrol.delay.pade import pade, pade_state
from flycontrol.delay.panel_march import (
    March,
    constant_past,
    grid_of,
    inputs_on,
    march_panels,
    past_of,
    require_experiment,
    steady_inputs,
)
from flycontrol.delay.piecewise import PiecewisePolynomial, sampled
from flycontrol.delay.real import real_array, real_number, require_callable
from flycontrol.delay.response import Response
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand
    from flycontrol.delay.plots.style import AxesArray

_POINTS = 500
_SETTLED = 7.0  # time constants until exp(-7) = 1e-3 is left


@dataclass(frozen=True, slots=True, eq=False)
class Impulses:
    """Impulses in the outputs, which samples cannot show: weights[k] delta(t - times[k])."""

    times: FloatArray  #: [s], shape (k,)
    weights: FloatArray  #: [output s], shape (k, p)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class TimeResponse:
    """A sampled response with the exact ones behind it; where a signal jumps, samples hold the later value."""

    time: FloatArray  #: [s], shape (k,)
    outputs: FloatArray  #: (k,) with one input and one output, else (p, k), or (p, m, k) with a trace for each input
    states: FloatArray  #: (n, k), or (n, m, k) with a trace for each input
    exact: tuple[Response, ...]  #: the outputs as piecewise polynomials, one for each trace
    impulses: tuple[Impulses, ...] = ()  #: of an impulse response, one for each trace
    #: the same experiment on the [n/n] Pade approximation, by order; None where a history stands against it
    approximated: Callable[[int], TimeResponse] | None = None

    def __repr__(self) -> str:
        return (
            f"<TimeResponse: outputs {self.outputs.shape}, states {self.states.shape} at {len(self.time)} times over "
            f"0..{self.time[-1]:.4g} s>"
        )

    def plot(self, **options: Any) -> AxesArray:
        """Draw it; options and return value as in `time_response_plot`."""
        from flycontrol.delay.plots import time_response_plot

        return time_response_plot(self, **options)


def step_response(system: Operand, timepts: ArrayLike | None = None, initial_state: ArrayLike = 0.0) -> TimeResponse:
    """Responses to a unit step of one input after the other, from a state that had been constant.

    Parameters
    ----------
    timepts
        Times [s] (k,) rising from 0, or the end alone; when left out, until the slowest mode has settled.
    initial_state
        State (n,) at time 0 and before; a number stands for n of them.

    Raises
    ------
    InvalidParameterError
        If times or the state do not fit.
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    plant = as_delay_lti(system)
    t, x0 = _times(plant, timepts), _state(plant, initial_state)
    marches = [_march(plant, steady_inputs(unit, float(t[-1])), x0, t) for unit in np.eye(plant.n_inputs)]
    return replace(_traces(plant, t, marches), approximated=partial(_approximated, step_response, plant, x0, (t,)))


def impulse_response(system: Operand, timepts: ArrayLike | None = None) -> TimeResponse:
    """Responses from rest to a unit impulse of one input after the other: d/dt of the step responses.

    What an impulse leaves in the states is exact, also where it comes back through a delay; impulses of the outputs
    themselves (through direct paths) stand in `impulses`. Parameters and errors as in `step_response`.
    """
    plant = as_delay_lti(system)
    t, x0 = _times(plant, timepts), np.zeros(plant.n_states)
    still = steady_inputs(np.zeros(plant.n_inputs), float(t[-1]))
    require_experiment(plant, float(t[-1]), still, x0)
    past = constant_past(plant, x0)
    grid = grid_of(plant, float(t[-1]), still, past)
    u = inputs_on(still, grid)
    marches: list[March] = []
    impulses: list[Impulses] = []
    for column in range(plant.n_inputs):
        jumps, found = _impulse_jumps(plant, grid[0], column, float(t[-1]))
        marches.append(march_panels(plant, grid, past, u, jumps, x0))
        impulses.append(found)
    found = _traces(plant, t, marches, tuple(impulses))
    return replace(found, approximated=partial(_approximated, impulse_response, plant, None, (t,)))


def forced_response(
    system: Operand,
    timepts: ArrayLike | None = None,
    inputs: ArrayLike | PiecewisePolynomial = 0.0,
    initial_state: ArrayLike = 0.0,
    *,
    hold: Literal["linear", "zero"] = "linear",
) -> TimeResponse:
    """Response to inputs from a state that had been constant, the inputs having been zero before time 0.

    Parameters
    ----------
    timepts
        Times [s] (k,) rising from 0; with a piecewise polynomial the end alone will do, or its own end is taken.
    inputs
        Samples (m, k) or (k,) at those times, a constant number, or a `PiecewisePolynomial` from time 0 on.
    initial_state
        As in `step_response`.
    hold
        Whether samples are joined by lines, as in python-control, or held until the next.

    Raises
    ------
    InvalidParameterError
        If times, inputs or the state do not fit.
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    plant = as_delay_lti(system)
    x0 = _state(plant, initial_state)
    if isinstance(inputs, PiecewisePolynomial):
        t, signal = _times(plant, inputs.end if timepts is None else timepts), inputs
    elif callable(inputs):
        raise InvalidParameterError(
            "Inputs are samples, a number or a piecewise polynomial, got a function; hand it over as "
            "fitted(function, [0, end]), with every kink and jump among the breaks."
        )
    else:
        t = _times(plant, timepts)
        steady = np.ndim(inputs) == 0
        constant = np.full(plant.n_inputs, real_number(inputs, "A constant input")) if steady else np.zeros(0)
        signal = steady_inputs(constant, float(t[-1])) if steady else sampled(t, inputs, hold)
    found = _single(plant, t, _march(plant, signal, x0, t))
    return replace(found, approximated=partial(_approximated, forced_response, plant, x0, (t, signal)))


def initial_response(
    system: Operand,
    timepts: ArrayLike | None = None,
    initial_state: ArrayLike | None = None,
    *,
    history: StateHistory | None = None,
    breaks: Sequence[float] = (),
) -> TimeResponse:
    """Response without input to an initial state, constant before time 0 or with a history of its own.

    Parameters
    ----------
    timepts
        As in `step_response`.
    initial_state
        State (n,) at time 0, a number standing for n of them; with a history, history(0) when left out.
    history
        States (n,) at times t <= 0 [s].
    breaks
        Times < 0 [s] of the history's kinks and jumps.

    Raises
    ------
    InvalidParameterError
        If times, state or history do not fit.
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    plant = as_delay_lti(system)
    t = _times(plant, timepts)
    if history is not None:
        require_callable(history, "A history, t [s] -> states (n,),")
    start = history(0.0) if initial_state is None and history is not None else initial_state
    if start is None:
        raise InvalidParameterError(
            "An initial response needs an initial state or a history: from rest, and without input, nothing moves."
        )
    still = steady_inputs(np.zeros(plant.n_inputs), float(t[-1]))
    x0 = _state(plant, start)
    found = _single(plant, t, _march(plant, still, x0, t, history, breaks))
    if history is not None:
        return found
    return replace(found, approximated=partial(_approximated, initial_response, plant, x0, (t,)))


def _approximated(
    respond: Callable[..., TimeResponse],
    plant: DelayLTI,
    state: FloatArray | None,
    arguments: tuple[Any, ...],
    order: int,
) -> TimeResponse:
    """The same experiment on the [n/n] Pade approximation; its states beyond those of the plant rest at first."""
    start = {} if state is None else {"initial_state": pade_state(plant, order, state)}
    return respond(pade(plant, order), *arguments, **start)


def experiment_march(
    system: DelayLTI,
    end: float,
    inputs: PiecewisePolynomial,
    state: FloatArray,
    history: StateHistory | None = None,
    breaks: Sequence[float] = (),
) -> March:
    """March from 0 to the end [s] with all its signals; arguments as in the responses above."""
    require_experiment(system, end, inputs, state)
    if history is None or system.n_delays == 0:
        past = constant_past(system, state)
    else:
        past = past_of(past_signals(system, history, breaks))
    grid = grid_of(system, end, inputs, past)
    return march_panels(system, grid, past, inputs_on(inputs, grid), np.empty((0, system.n_states)), state)


def _march(
    plant: DelayLTI,
    inputs: PiecewisePolynomial,
    state: FloatArray,
    t: FloatArray,
    history: StateHistory | None = None,
    breaks: Sequence[float] = (),
) -> March:
    return experiment_march(plant, float(t[-1]), inputs, state, history, breaks)


def _impulse_jumps(plant: DelayLTI, starts: FloatArray, column: int, end: float) -> tuple[FloatArray, Impulses]:
    """State jumps (P, n) at panel starts after an impulse of one input, and the impulses of the outputs."""
    jumps = np.zeros((len(starts), plant.n_states))
    jumps[0] = plant.B1[:, column]
    times, weights = [0.0], [plant.D11[:, column]]
    waiting = [(0.0, plant.D21[:, column])]  # impulses of the delayed signals, on their way
    while waiting:
        sent, strength = waiting.pop()
        for i in np.flatnonzero(strength):
            t = sent + float(plant.tau[i])
            if t >= end * (1 - 1e-12):
                continue
            jumps[int(np.abs(starts - t).argmin())] += plant.B2[:, i] * strength[i]
            times.append(t)
            weights.append(plant.D12[:, i] * strength[i])
            if plant.D22[:, i].any():
                waiting.append((t, plant.D22[:, i] * strength[i]))
    shown = [k for k in np.argsort(times) if np.any(weights[k])]
    return jumps, Impulses(np.array(times)[shown], np.array(weights)[shown])


def _traces(plant: DelayLTI, t: FloatArray, marches: list[March], impulses: tuple[Impulses, ...] = ()) -> TimeResponse:
    exact = tuple(march.response for march in marches)
    outputs = np.stack([response(t) for response in exact], axis=1)
    states = np.stack([march.state_response(t) for march in marches], axis=1)
    if plant.n_inputs == 1:
        states = states[:, 0]
        outputs = outputs[0, 0] if plant.n_outputs == 1 else outputs
    return TimeResponse(t, outputs, states, exact, impulses)


def _single(plant: DelayLTI, t: FloatArray, march: March) -> TimeResponse:
    outputs = march.response(t)
    squeezed = outputs[0] if plant.n_outputs == 1 and plant.n_inputs == 1 else outputs
    return TimeResponse(t, squeezed, march.state_response(t), (march.response,))


def _times(plant: DelayLTI, timepts: ArrayLike | None) -> FloatArray:
    t = real_array(_settled_end(plant) if timepts is None else timepts, "Times of a response [s]")
    if t.ndim == 0:
        t = np.linspace(0.0, float(t), _POINTS) if t > 0 and np.isfinite(t) else np.zeros(0)
    if not (t.ndim == 1 and len(t) > 1 and t[0] == 0 and np.isfinite(t).all() and (np.diff(t) > 0).all()):
        raise InvalidParameterError(
            "Times of a response must be at least 2 finite ones rising from 0 s, or an end > 0 s; start at 0 and shift."
        )
    return t


def _settled_end(plant: DelayLTI) -> float:
    """Seven time constants of the slowest mode that decays or grows, after a passage through the longest chain."""
    passage = float(plant.tau.sum())
    if plant.n_states == 0:
        return 2.0 * passage or 1.0
    rates = np.abs(rightmost_roots(plant, 1).roots.real)
    scale = max(float(rates.max(initial=0.0)), 1e-3 * float(np.abs(plant.A).max()))
    return passage + (_SETTLED / scale if scale > 0 else 10.0 * (passage or 1.0))


def _state(plant: DelayLTI, state: ArrayLike) -> FloatArray:
    given = real_array(state, "The initial state")
    return np.full(plant.n_states, float(given)) if given.ndim == 0 else given

"""Delay systems written once in CasADi: exact linearisation and Pade augmentation of the same expressions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from flycontrol.delay.pade import pade_matrices
from flycontrol.delay.system import DelayLTI
from flycontrol.errors import InvalidParameterError


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicDelaySystem:
    """x' = f(x, w, u, p), y = g(x, w, u, p), z = h(x, w, u, p), w_i(t) = z_i(t - tau_i(p)).

    All fields are CasADi columns.
    """

    states: ca.SX  #: x (n, 1)
    delayed: ca.SX  #: w (q, 1)
    inputs: ca.SX  #: u (m, 1)
    parameters: ca.SX  #: p (k, 1)
    derivative: ca.SX  #: f (n, 1)
    outputs: ca.SX  #: g (p, 1)
    delayed_signals: ca.SX  #: h (q, 1)
    delays: ca.SX  #: tau (q, 1) [s]


def linearisation(system: SymbolicDelaySystem) -> ca.Function:
    """CasADi's own Jacobians: (x, w, u, p) -> A, B1, B2, C1, C2, D11, D12, D21, D22, tau of `DelayLTI`."""
    s = system
    rows = (s.derivative, s.outputs, s.delayed_signals)
    columns = (s.states, s.inputs, s.delayed)
    (A, B1, B2), (C1, D11, D12), (C2, D21, D22) = [[ca.jacobian(row, column) for column in columns] for row in rows]
    blocks = [A, B1, B2, C1, C2, D11, D12, D21, D22, s.delays]
    return ca.Function("linearisation", [s.states, s.delayed, s.inputs, s.parameters], [ca.densify(b) for b in blocks])


def linearised(blocks: ca.Function, parameters: Sequence[float]) -> DelayLTI:
    """The exact delay system at rest (x = w = u = 0) for parameter values, from a `linearisation`."""
    evaluated = blocks(0, 0, 0, ca.DM(list(parameters)))
    A, B1, B2, C1, C2, D11, D12, D21, D22, tau = (np.array(block, dtype=np.float64) for block in evaluated)
    return DelayLTI(A, B1, B2, C1, C2, D11, D12, D21, D22, tau.ravel())


def pade_augmented(system: SymbolicDelaySystem, order: int) -> SymbolicDelaySystem:
    """The same system with each delay channel replaced by its [order/order] Pade approximant, still symbolic.

    The approximant's time is scaled by the delay: x_p' = (A x_p + B z) / tau, w = C x_p + D z, with the ladder form of
    `pade_matrices`, so conditioning depends on neither the delay nor the order.

    Raises
    ------
    InvalidParameterError
        If order is not an integer >= 1, or a delayed signal depends on an undelayed path from w.
    """
    s, unit = system, pade_matrices(order)
    if ca.depends_on(s.delayed_signals, s.delayed):
        raise InvalidParameterError(
            "A delayed signal z depends directly on w; give that chain of delays a state first."
        )
    channels = [ca.SX.sym(f"pade_{i}", order) for i in range(s.delayed.numel())]
    w = ca.vertcat(*[ca.DM(unit.C).T @ x + unit.D * s.delayed_signals[i] for i, x in enumerate(channels)])
    rates = [(ca.DM(unit.A) @ x + ca.DM(unit.B) * s.delayed_signals[i]) / s.delays[i] for i, x in enumerate(channels)]
    nothing = ca.SX(0, 1)
    return SymbolicDelaySystem(
        states=ca.vertcat(s.states, *channels),
        delayed=ca.SX.sym("none", 0),
        inputs=s.inputs,
        parameters=s.parameters,
        derivative=ca.vertcat(ca.substitute(s.derivative, s.delayed, w), *rates),
        outputs=ca.substitute(s.outputs, s.delayed, w),
        delayed_signals=nothing,
        delays=nothing,
    )


def right_hand_side(system: SymbolicDelaySystem) -> ca.Function:
    """(x, w, u, p) -> x', y, z as a CasADi function, nonlinear terms included."""
    s = system
    return ca.Function(
        "system", [s.states, s.delayed, s.inputs, s.parameters], [s.derivative, s.outputs, s.delayed_signals]
    )

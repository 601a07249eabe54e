"""The yaw loop with a Pade approximant in place of its delay, shot from sample to sample in CasADi.

    x' = f(x, N_ext / I, p),   x = (psi, psi', integral of psi, states of the approximant)

f is the symbolic loop of `model.yaw`, augmented by `model.symbolic.pade_augmented`. Without saturation a step is the
matrix exponential, a Taylor polynomial squared; a saturated loop takes Runge-Kutta steps of order 4. Steps end at every
sample and every knot of the drive, so that none holds an edge. Before the start the fly turned uniformly: the
approximant then answers a demand that is a polynomial in time, x = -sum_k A^(-k-1) B T^k z^(k). Derivatives are
CasADi's own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from flycontrol.delay.pade import pade_matrices
from flycontrol.errors import InvalidInputError
from flycontrol.identify.gains.response import NAMES, Drive, Span
from flycontrol.model.symbolic import SymbolicDelaySystem, linearisation, pade_augmented, right_hand_side
from flycontrol.model.yaw import yaw_system

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
_TERMS = 13  #: of the Taylor polynomial of exp(M) with |M| < 1/2: what it leaves out is below 1e-15
_FINE = 0.25  #: fastest rate times a Runge-Kutta step
_LIMIT, _SHIFT = NAMES.index("limit"), NAMES.index("onset_shift")


@dataclass(frozen=True, slots=True, eq=False)
class PadeShooting:
    """Answers like `gains.response.evaluate`, the delay replaced by its [order/order] Pade approximant."""

    order: int
    graphs: dict[object, ca.Function] = field(default_factory=dict[object, ca.Function], repr=False)

    def __call__(
        self, p: FloatArray, active: IntArray, drive: Drive, span: Span, times: FloatArray, torque: bool
    ) -> tuple[FloatArray, FloatArray | None]:
        """(1 + m, n) yaw with derivatives, and N_fly / I with derivatives if wanted.

        Raises
        ------
        InvalidInputError
            If the onset is to be estimated: knots of the drive part the steps, so they stay where they are.
        """
        if _SHIFT in active or p[_SHIFT]:
            raise InvalidInputError("The Pade route takes the perturbation's times as known; leave onset_shift out.")
        grid = _grid(drive, span, times)
        saturated = bool(np.isfinite(p[_LIMIT]))
        level = (_substeps if saturated else _halvings)(self.order, p, grid.longest)
        shooting = _Shooting(self.order, saturated, level, torque)
        key = (shooting, len(active), times.tobytes())
        if key not in self.graphs:
            self.graphs[key] = _with_derivatives(shooting.outputs(grid), len(active))
        seeds = np.zeros((len(p), len(active)))
        seeds[active, np.arange(len(active))] = 1.0
        values, slopes = self.graphs[key](np.where(np.isfinite(p), p, 0.0), seeds)
        rows = np.column_stack([np.array(values), np.array(slopes)]).T
        parts = [np.ascontiguousarray(part) for part in np.split(rows, 2 if torque else 1, axis=1)]
        return parts[0], parts[1] if torque else None


@dataclass(frozen=True, slots=True, eq=False)
class _Grid:
    """Steps between samples and knots of the drive."""

    start: float
    lengths: FloatArray  #: (g,) different lengths of steps [s]
    which: IntArray  #: (k,) length of each step
    push: FloatArray  #: (2, k) drive at the left of each step, and its slope
    samples: IntArray  #: (n,) step after which each sample stands; 0 is the start

    @property
    def longest(self) -> float:
        return float(self.lengths.max())


def _grid(drive: Drive, span: Span, times: FloatArray) -> _Grid:
    knots, levels, slopes = drive.pieces
    inside = knots[(knots > span.start) & (knots < times[-1])]
    breaks = np.unique(np.concatenate([[span.start], inside, times]))
    steps = np.diff(breaks)
    _, which = np.unique(np.rint(steps / (1e-9 * steps.max())), return_inverse=True)
    lengths = np.bincount(which, weights=steps) / np.bincount(which)
    middle = breaks[:-1] + 0.5 * steps
    piece = np.searchsorted(knots, middle, side="right") - 1
    there = piece >= 0
    left = np.where(there, levels[piece] + slopes[piece] * (breaks[:-1] - knots[piece]), 0.0)
    push = np.array([left, np.where(there, slopes[piece], 0.0)])
    return _Grid(span.start, lengths, which.astype(np.int64), push, np.searchsorted(breaks, times).astype(np.int64))


def _rates(p: FloatArray) -> list[float]:
    """|b|, |kp|, |kd|, |ki| and the delay."""
    return [abs(float(p[NAMES.index(name)])) for name in ("damping", "kp", "kd", "ki", "delay")]


def _substeps(order: int, p: FloatArray, step: float) -> int:
    """Runge-Kutta steps in a step are 2 to this power."""
    b, kp, kd, ki, T = _rates(p)
    fastest = np.abs(np.linalg.eigvals(pade_matrices(order).A)).max() / T
    return max(0, int(np.ceil(np.log2((fastest + b + kd + kp**0.5 + ki ** (1 / 3)) * step / _FINE))))


def _halvings(order: int, p: FloatArray, step: float) -> int:
    """Halvings after which the norm of a step's matrix, time in delays, is below 1/2."""
    b, kp, kd, ki, T = _rates(p)
    unit = pade_matrices(order)
    demand = 1.0 + np.abs(unit.B).sum() + np.abs(unit.C).sum()
    rate = (np.linalg.norm(unit.A, 1) + 1.0) / T + b + demand * (kd + kp * T + ki * T**2)
    return max(0, int(np.ceil(np.log2(2.0 * rate * step))))


def _with_derivatives(outputs: Callable[[ca.MX], ca.MX], directions: int) -> ca.Function:
    """(p, seeds) -> outputs and their derivatives along the seeds' columns."""
    p, seeds = ca.MX.sym("p", len(NAMES)), ca.MX.sym("seeds", len(NAMES), directions)
    values = outputs(p)
    slopes = ca.jtimes(values, p, seeds) if directions else ca.MX(values.numel(), 0)
    return ca.Function("shooting", [p, seeds], [values, slopes])


@dataclass(frozen=True, slots=True)
class _Shooting:
    """Which loop is shot, and how finely."""

    order: int
    saturated: bool
    level: int  #: a step is halved so many times
    torque: bool  #: give N_fly / I too

    def outputs(self, grid: _Grid) -> Callable[[ca.MX], ca.MX]:
        """p (12,) -> yaw at the samples, and below it the fly's torque (n, 1) or (2 n, 1)."""

        def of(p: ca.MX) -> ca.MX:
            states = self._shot(p, grid)[:, grid.samples.tolist()]
            found = [states[0, :].T + p[NAMES.index("heading")]]
            if self.torque:
                system = right_hand_side(_loop(self.order, self.saturated))
                nothing, loop_parameters = ca.MX(0, 1), _loop_parameters(p, self.saturated)
                found.append(system.map(len(grid.samples))(states, nothing, 0, loop_parameters)[1][2, :].T)
            return ca.vertcat(*found)

        return of

    def _shot(self, p: ca.MX, grid: _Grid) -> ca.MX:
        """States (n, 1 + steps)."""
        push = p[NAMES.index("impulse")] * ca.DM(grid.push)
        first = _resting(p, self.order)
        step, extra = self._stepper(p, grid)
        states = step.mapaccum(len(grid.which))(first, push, *extra)
        return ca.horzcat(first, states)

    def _stepper(self, p: ca.MX, grid: _Grid) -> tuple[ca.Function, list[ca.DM | ca.MX]]:
        """One step x, (drive, slope), ... -> x, and what it takes beside those at each step."""
        loop_parameters, count = _loop_parameters(p, self.saturated), len(grid.which)
        if self.saturated:
            lengths = ca.DM(grid.lengths[grid.which]).T
            return _runge_kutta(self.order, 2**self.level), [
                lengths,
                ca.repmat(loop_parameters, 1, count),
            ]
        n = _loop(self.order, False).states.numel()
        transitions = _transition(self.order, self.level).map(len(grid.lengths))(
            ca.repmat(loop_parameters, 1, len(grid.lengths)), ca.DM(grid.lengths).T
        )
        columns = (grid.which[:, None] * (n + 2) + np.arange(n + 2)).ravel()
        return _linear_step(n), [transitions[:, columns.tolist()]]


@lru_cache(maxsize=16)
def _loop(order: int, saturated: bool) -> SymbolicDelaySystem:
    """The augmented loop for an inertia of one: parameters I, beta, K_P, K_D, T, (N_max,) ki."""
    plain = yaw_system(saturated=saturated)
    integral, ki = ca.SX.sym("integral"), ca.SX.sym("ki")
    extended = replace(
        plain,
        states=ca.vertcat(plain.states, integral),
        derivative=ca.vertcat(plain.derivative, plain.states[0]),
        parameters=ca.vertcat(plain.parameters, ki),
        delayed_signals=plain.delayed_signals + ki * integral,
    )
    return pade_augmented(extended, order)


def _loop_parameters(p: ca.MX, saturated: bool) -> ca.MX:
    names = ["damping", "kp", "kd", "delay", *(["limit"] if saturated else []), "ki"]
    return ca.vertcat(1.0, *[p[NAMES.index(name)] for name in names])


def _resting(p: ca.MX, order: int) -> ca.MX:
    """States at the start of a fly that has turned uniformly before."""
    kp, kd, ki, T, yaw, rate = (
        p[NAMES.index(n)] for n in ("kp", "kd", "ki", "delay", "initial_yaw", "initial_rate")
    )  # fmt: skip
    unit = pade_matrices(order)
    demand = [kp * yaw + kd * rate, kp * rate + ki * yaw, ki * rate]  # and its derivatives, the integral being 0
    states, column = ca.MX.zeros(order, 1), unit.B
    for k, z in enumerate(demand):
        column = np.linalg.solve(unit.A, column)
        states = states - ca.DM(column) * (T**k * z)
    return ca.vertcat(yaw, rate, 0.0, states)


@lru_cache(maxsize=32)
def _transition(order: int, level: int) -> ca.Function:
    """(loop parameters, length) -> exp of the loop with its drive and the drive's slope (n, n + 2)."""
    loop = _loop(order, False)
    n, k = loop.states.numel(), loop.parameters.numel()
    p, h = ca.MX.sym("p", k), ca.MX.sym("h")
    A, B = linearisation(loop)(ca.DM.zeros(n), ca.DM(0, 1), 0, p)[:2]
    T = p[4]
    size = ca.vertcat(1, 1 / T, T, *[T**-2] * order, T**-2, T**-3)  # in units of the delay nothing is large
    whole = ca.vertcat(ca.horzcat(A, B, ca.MX(n, 1)), ca.MX(2, n + 2))
    whole[n, n + 1] = 1.0
    scaled = ca.densify(whole * (h / 2**level) * ca.repmat(size.T, n + 2, 1) / ca.repmat(size, 1, n + 2))
    power = ca.MX.eye(n + 2)
    for term in range(_TERMS, 0, -1):
        power = ca.MX.eye(n + 2) + ca.mtimes(scaled, power) / term
    for _ in range(level):
        power = ca.mtimes(power, power)
    found = power * ca.repmat(size, 1, n + 2) / ca.repmat(size.T, n + 2, 1)
    return ca.Function("transition", [p, h], [ca.densify(found)[:n, :]])


def _linear_step(n: int) -> ca.Function:
    x, push, transition = ca.MX.sym("x", n), ca.MX.sym("push", 2), ca.MX.sym("transition", n, n + 2)
    return ca.Function("step", [x, push, transition], [ca.mtimes(transition, ca.vertcat(x, push))])


@lru_cache(maxsize=32)
def _runge_kutta(order: int, count: int) -> ca.Function:
    """x, (drive, slope), length, loop parameters -> x after so many steps of order 4."""
    one = _runge_kutta_step(order)
    x, push, h, p = (ca.MX.sym(one.name_in(i), one.size1_in(i)) for i in range(4))
    state: list[ca.MX] = [x, push, h / count, p]
    for _ in range(count):
        state = list(one(*state))
    return ca.Function("step", [x, push, h, p], [state[0]])


@lru_cache(maxsize=32)
def _runge_kutta_step(order: int) -> ca.Function:
    """x, (drive, slope), length, loop parameters -> the same after one step."""
    loop = _loop(order, True)
    f = right_hand_side(loop)
    x, push, h, p = ca.SX.sym("x", loop.states.numel()), ca.SX.sym("push", 2), ca.SX.sym("h"), loop.parameters

    def rate(x: Any, t: Any) -> Any:
        return f(x, ca.SX(0, 1), push[0] + push[1] * t, p)[0]

    k1 = rate(x, 0.0)
    k2 = rate(x + h / 2 * k1, h / 2)
    k3 = rate(x + h / 2 * k2, h / 2)
    k4 = rate(x + h * k3, h)
    after = [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), push + ca.vertcat(push[1] * h, 0), h, p]
    return ca.Function("one", [x, push, h, p], after)

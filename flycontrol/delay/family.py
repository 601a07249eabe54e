"""Delay systems that depend on parameters, seen by what their roots depend on."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from flycontrol.delay.kernels import winding
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray, is_retarded
from flycontrol.errors import InvalidParameterError, NeutralSystemError

_STEP = 1e-6  # of a parameter, for differences: a predictor and Newton's slope need no better ones


class Blocks(NamedTuple):
    """What the roots of a `DelayLTI` depend on; shapes as there, arrays writeable."""

    A: FloatArray
    B2: FloatArray
    C2: FloatArray
    D22: FloatArray
    tau: FloatArray  #: [s]


class Neighbours(NamedTuple):
    """The blocks on both sides of a point along one parameter."""

    before: Blocks
    after: Blocks
    width: float  #: distance between the two, in the parameter's unit


class Family:
    """x -> DelayLTI over a box of parameters; all members scaled alike, by powers of two.

    Raises
    ------
    InvalidParameterError
        If the family refuses a point of the box or returns something else.
    NeutralSystemError
        If a member is of neutral type.
    """

    def __init__(self, system_at: Callable[..., DelayLTI], low: FloatArray, high: FloatArray) -> None:
        self.low, self.high = low, high
        self._system_at = system_at
        middle = _blocks(self.system(0.5 * (low + high)))
        self._factors = winding.scale(middle.A, middle.B2, middle.C2, middle.D22)
        #: how large roots near the imaginary axis can be at the middle of the box [1/s]
        self.rate = float(winding.radius(middle.A, middle.B2, middle.C2, middle.D22, np.ones(len(middle.tau))))

    def system(self, point: FloatArray) -> DelayLTI:
        """The member at a point (p,)."""
        try:
            system = self._system_at(*[float(x) for x in point])
        except InvalidParameterError as refusal:
            raise InvalidParameterError(
                f"The family has no system at {_written(point)}: {refusal} Choose a range where it has, and build a "
                "delay that goes to zero with flycontrol.delay's `delay`, which is the identity there."
            ) from refusal
        if not isinstance(system, DelayLTI):
            raise InvalidParameterError(f"A family must return a DelayLTI, got {system!r} at {_written(point)}.")
        if not is_retarded(system):
            raise NeutralSystemError(
                f"At {_written(point)} the system is of neutral type (a delay feeds back into itself without passing "
                "a state): infinitely many roots can cross at once. Put a lag into that path."
            )
        return system

    def blocks(self, point: FloatArray) -> Blocks:
        """The scaled blocks at a point (p,)."""
        blocks = _blocks(self.system(point))
        f, g = self._factors
        if blocks.B2.shape != (len(f), len(g)):  # a delay that vanishes at the end of the range
            winding.scale(blocks.A, blocks.B2, blocks.C2, blocks.D22)
            return blocks
        rows, columns = f[:, None], g[:, None]
        return Blocks(
            blocks.A * (rows / f), blocks.B2 * (rows * g), blocks.C2 / (columns * f), blocks.D22 * (g / columns),
            blocks.tau,
        )  # fmt: skip

    def neighbours(self, point: FloatArray, axis: int) -> Neighbours | None:
        """Blocks on both sides along one parameter, inside the box; None where the family's structure changes."""
        step = _STEP * max(1e-3 * float(self.high[axis] - self.low[axis]), abs(float(point[axis])))
        sides: list[FloatArray] = []
        for offset in (-step, step):
            side = point.copy()
            side[axis] = min(max(point[axis] + offset, self.low[axis]), self.high[axis])
            sides.append(side)
        before, after = (self.blocks(side) for side in sides)
        if before.B2.shape != after.B2.shape:
            return None
        return Neighbours(before, after, float(sides[1][axis] - sides[0][axis]))


def _blocks(system: DelayLTI) -> Blocks:
    x = system
    return Blocks(x.A.copy(), x.B2.copy(), x.C2.copy(), x.D22.copy(), x.tau.copy())


def _written(point: FloatArray) -> str:
    return ", ".join(f"{x:g}" for x in point)


def characteristic(blocks: Blocks, s: complex) -> ComplexArray:
    """M(s) = [[s I - A, -B2], [-E C2, I - E D22]], E = diag exp(-s tau); shape (n + q, n + q)."""
    factor = np.exp(-s * blocks.tau)[:, None]
    n, q = blocks.B2.shape
    return np.block(
        [[s * np.eye(n) - blocks.A, -blocks.B2], [-factor * blocks.C2, np.eye(q) - factor * blocks.D22]]
    ).astype(np.complex128)


def characteristic_slope(blocks: Blocks, s: complex, order: int = 1) -> ComplexArray:
    """The derivative of M(s) of the given order >= 1."""
    n, q = blocks.B2.shape
    factor = -((-blocks.tau) ** order * np.exp(-s * blocks.tau))[:, None]
    upper = np.eye(n) if order == 1 else np.zeros((n, n))
    return np.block([[upper, np.zeros((n, q))], [factor * blocks.C2, factor * blocks.D22]]).astype(np.complex128)

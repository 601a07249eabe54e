"""Delay systems that depend on parameters, seen by what their roots depend on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from flycontrol.delay.characteristic import CharacteristicBlocks, characteristic_blocks, without_ports
from flycontrol.delay.kernels import winding
from flycontrol.delay.system import DelayLTI, FloatArray, require_retarded
from flycontrol.errors import InvalidParameterError, NeutralSystemError

_STEP = 1e-6  # of a parameter, for differences: a predictor and Newton's slope need no better ones

Member = DelayLTI | CharacteristicBlocks


class Neighbours(NamedTuple):
    """The blocks at a point and at one beside it along one parameter."""

    before: CharacteristicBlocks
    after: CharacteristicBlocks
    width: float  #: from the first to the second, in the parameter's unit; negative at the end of the range


class Family:
    """x -> system over a box of parameters; all members scaled alike, by powers of two.

    Parameters
    ----------
    system_at
        Takes p numbers and returns a `DelayLTI`, or `CharacteristicBlocks` where speed matters.
    low, high
        Corners of the box, shape (p,).

    Raises
    ------
    InvalidParameterError
        If the family refuses a point of the box or returns something else.
    NeutralSystemError
        If a member is of neutral type.
    """

    def __init__(self, system_at: Callable[..., Member], low: FloatArray, high: FloatArray) -> None:
        self.low, self.high = low, high
        self._system_at = system_at
        self._shapes: tuple[tuple[int, ...], ...] = ()
        self._recent: dict[tuple[float, ...], Member] = {}  # a step asks for the same few points again and again
        middle = characteristic_blocks(self.system(0.5 * (low + high)))
        self._shapes = middle.shapes
        self._factors = winding.scale(middle.A, middle.B2, middle.C2, middle.D22)
        #: how large roots near the imaginary axis can be at the middle of the box [1/s]
        self.rate = float(winding.radius(middle.A, middle.B2, middle.C2, middle.D22, np.ones(len(middle.tau))))

    def member(self, point: FloatArray) -> Member:
        """What the family returns at a point (p,), known to be of retarded type."""
        place = tuple(point.tolist())
        if place not in self._recent:
            if len(self._recent) > 8:
                self._recent.clear()
            self._recent[place] = self.at(*place)
        return self._recent[place]

    def at(self, *place: float) -> Member:
        """`member` at a point that will not be asked for again soon."""
        try:
            member = self._system_at(*place)
            if isinstance(member, CharacteristicBlocks) and not self._fits(member):
                without_ports(member)  # says what is wrong
        except InvalidParameterError as refusal:
            raise InvalidParameterError(
                f"The family has no system at {_written(place)}: {refusal} Choose a range where it has, and build a "
                "delay that goes to zero with flycontrol.delay's `delay`, which is the identity there."
            ) from refusal
        if not isinstance(member, Member):
            raise InvalidParameterError(f"A family must return a DelayLTI, got {member!r} at {_written(place)}.")
        if np.count_nonzero(member.D22):
            try:
                require_retarded(as_system(member))
            except NeutralSystemError as refusal:
                raise NeutralSystemError(f"At {_written(place)}: {refusal}") from refusal
        return member

    def stack(self, points: FloatArray) -> CharacteristicBlocks:
        """Blocks at k points (k, p) from one call with p arrays (k,): each with a leading axis (k, ...), writeable.

        The family returns blocks that have this axis or, where they are the same at all points, do not.
        """
        k = len(points)
        given: Any = self._system_at(*points.T.copy())
        try:
            blocks = CharacteristicBlocks(
                *[np.array(np.broadcast_to(x, (k, *shape))) for x, shape in zip(given, self._shapes, strict=True)]
            )
        except (TypeError, ValueError) as refusal:
            raise InvalidParameterError(
                f"A batched family must return CharacteristicBlocks for arrays of {k} values: blocks of shapes "
                f"{self._shapes}, or with {k} as an axis before these."
            ) from refusal
        sound = all(np.isfinite(x).all() for x in blocks) and (blocks.tau > 0).all()
        for i in range(k if np.count_nonzero(blocks.D22) or not sound else 0):
            require_retarded(without_ports(CharacteristicBlocks(*[x[i] for x in blocks])))  # says what is wrong
        return blocks

    def _fits(self, blocks: CharacteristicBlocks) -> bool:
        return blocks.shapes == self._shapes and all(t > 0 for t in blocks.tau.tolist())

    def system(self, point: FloatArray) -> DelayLTI:
        """The member at a point (p,), checked."""
        return as_system(self.member(point))

    def blocks(self, point: FloatArray) -> CharacteristicBlocks:
        """The scaled blocks at a point (p,), writeable."""
        x = self.member(point)
        f, g = self._factors
        if x.B2.shape != (len(f), len(g)):  # a delay that vanishes at the end of the range
            copies = characteristic_blocks(as_system(x))
            winding.scale(copies.A, copies.B2, copies.C2, copies.D22)
            return copies
        rows, columns = f[:, None], g[:, None]
        return CharacteristicBlocks(
            x.A * (rows / f), x.B2 * (rows * g), x.C2 / (columns * f), x.D22 * (g / columns), x.tau.copy()
        )

    def neighbours(self, point: FloatArray, axis: int) -> Neighbours | None:
        """Blocks at the point and beside it along one parameter; None where the family's structure changes."""
        step = _STEP * max(1e-3 * float(self.high[axis] - self.low[axis]), abs(float(point[axis])))
        beside = point.copy()
        beside[axis] += step if point[axis] + step <= self.high[axis] else -step
        here, there = self.blocks(point), self.blocks(beside)
        if here.B2.shape != there.B2.shape:
            return None
        return Neighbours(here, there, float(beside[axis] - point[axis]))


def as_system(member: Member) -> DelayLTI:
    """The member as a `DelayLTI`, without inputs and outputs if it came as blocks."""
    return member if isinstance(member, DelayLTI) else without_ports(member)


def _written(place: tuple[float, ...]) -> str:
    return ", ".join(f"{x:g}" for x in place)

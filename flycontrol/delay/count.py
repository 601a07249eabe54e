"""How many roots lie right of a line: the argument principle with steps that a bound on the derivative justifies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flycontrol.delay.characteristic import CharacteristicBlocks
from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.kernels import winding
from flycontrol.delay.system import DelayLTI, FloatArray, require_retarded
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

MOST_STEPS = 200_000  # of a count along its line
#: in words, what a count returns instead of a number
STATUS = {winding.TOO_NEAR: "a root too near the line", winding.NOT_COUNTED: "not certified"}


@dataclass(frozen=True, slots=True, kw_only=True)
class RootCount:
    """Number of roots with Re s > line, or None with the reason in `status`."""

    line: float  #: [1/s]
    roots: int | None
    steps: int  #: evaluations of the characteristic matrix
    status: str  #: "certified", "a root too near the line" or "not certified"


def count_right_of(system: Operand, line: float) -> RootCount:
    """Count the roots right of Re s = line by the phase of the characteristic function f along it.

    On the line the phase is followed from w = 0 to W = R / sin(pi / n), with R a bound on |s| for roots right of it, by
    steps that cannot miss a turn. On the arc beyond, f(s) / s^n is a product of n factors 1 - mu / s with |mu| <= R,
    its phase the principal value. Hence Z = (phase of f on the arc - phase on the line) / pi.

    Raises
    ------
    InvalidParameterError
        If the line is not finite.
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    if not np.isfinite(line):
        raise InvalidParameterError(f"A line to count roots right of must be at a finite Re s [1/s], got {line!r}.")
    plant = as_delay_lti(system)
    require_retarded(plant)
    return counts_right_of([plant], [line])[0]


def counts_right_of(
    systems: Sequence[DelayLTI | CharacteristicBlocks], lines: Sequence[float] | FloatArray
) -> list[RootCount]:
    """`count_right_of` for each of many systems and its line [1/s]; those in a row with equal shapes share one call."""
    found: list[RootCount] = []
    while len(found) < len(systems):
        first = len(found)
        last = first
        while last < len(systems) and _shape(systems[last]) == _shape(systems[first]):
            last += 1
        found += _counted(systems[first:last], np.array(lines[first:last], dtype=np.float64))
    return found


def _shape(system: DelayLTI | CharacteristicBlocks) -> tuple[int, ...]:
    return system.B2.shape


def stacked(systems: Sequence[DelayLTI | CharacteristicBlocks]) -> CharacteristicBlocks:
    """The blocks of k systems of equal shapes, as copies with a leading axis (k, ...)."""
    names = CharacteristicBlocks._fields
    return CharacteristicBlocks(*[np.array([getattr(s, name) for s in systems], dtype=np.float64) for name in names])


def _counted(systems: Sequence[DelayLTI | CharacteristicBlocks], lines: FloatArray) -> list[RootCount]:
    if len(systems[0].A) == 0:
        return [RootCount(line=float(line), roots=0, steps=0, status="certified") for line in lines]
    A, B2, C2, D22, tau = stacked(systems)
    roots, steps = winding.count_each(A, B2, C2, D22, tau, lines, MOST_STEPS)
    return [
        RootCount(
            line=float(line), roots=int(r) if r >= 0 else None, steps=int(k), status=STATUS.get(int(r), "certified")
        )
        for line, r, k in zip(lines, roots, steps, strict=True)
    ]

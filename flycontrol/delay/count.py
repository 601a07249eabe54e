"""How many roots lie right of a line: the argument principle with steps that a bound on the derivative justifies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flycontrol.delay.characteristic import CharacteristicBlocks
from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.kernels import winding
from flycontrol.delay.real import real_number
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
    line = real_number(line, "A line to count roots right of, Re s [1/s],")
    if not np.isfinite(line):
        raise InvalidParameterError(f"A line to count roots right of must be at a finite Re s [1/s], got {line!r}.")
    plant = as_delay_lti(system)
    require_retarded(plant)
    return counts_right_of([plant], [line])[0]


def counts_right_of(
    systems: Sequence[DelayLTI | CharacteristicBlocks], lines: Sequence[float] | FloatArray
) -> list[RootCount]:
    """`count_right_of` for each of many systems and its line [1/s]; those in a row with equal shapes share one call."""
    counted = numbers_right_of(systems, lines)
    return [
        RootCount(line=float(line), roots=r if r >= 0 else None, steps=k, status=STATUS.get(r, "certified"))
        for line, r, k in zip(lines, counted.roots.tolist(), counted.steps.tolist(), strict=True)
    ]


class RootNumbers(NamedTuple):
    """Counts of k systems, bare."""

    roots: NDArray[np.int64]  #: roots right of each line, or a key of `STATUS`, shape (k,)
    steps: NDArray[np.int64]  #: evaluations of the characteristic matrix, shape (k,)


def numbers_right_of(
    systems: Sequence[DelayLTI | CharacteristicBlocks], lines: Sequence[float] | FloatArray
) -> RootNumbers:
    """`counts_right_of` where thousands are counted."""
    found = RootNumbers(np.zeros(len(systems), np.int64), np.zeros(len(systems), np.int64))
    first = 0
    while first < len(systems):
        last = first + 1
        while last < len(systems) and _shape(systems[last]) == _shape(systems[first]):
            last += 1
        run = slice(first, last)
        if len(systems[first].A) > 0:
            counted = numbers_of_stack(stacked(systems[run]), np.array(lines[run], dtype=np.float64))
            found.roots[run], found.steps[run] = counted
        first = last
    return found


def numbers_of_stack(blocks: CharacteristicBlocks, lines: FloatArray) -> RootNumbers:
    """`counts_right_of` for k systems with states, from `stacked` blocks, which it scales, and lines (k,) [1/s]."""
    return RootNumbers(*winding.count_each(*blocks, lines, MOST_STEPS))


def _shape(system: DelayLTI | CharacteristicBlocks) -> tuple[int, ...]:
    return system.B2.shape


def stacked(systems: Sequence[DelayLTI | CharacteristicBlocks]) -> CharacteristicBlocks:
    """The blocks of k systems of equal shapes, as copies with a leading axis (k, ...)."""
    names = CharacteristicBlocks._fields
    return CharacteristicBlocks(*[np.array([getattr(s, name) for s in systems], dtype=np.float64) for name in names])

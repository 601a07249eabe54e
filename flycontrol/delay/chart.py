"""Stability charts: a delay system over a grid of two parameters, and the curves that bound its regions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from flycontrol.delay.count import numbers_of_stack, numbers_right_of, stacked
from flycontrol.delay.dcurve import DCurve, trace_boundary
from flycontrol.delay.family import Family, Member, as_system
from flycontrol.delay.kernels import decay
from flycontrol.delay.margins import margins
from flycontrol.delay.real import real_array, require_callable
from flycontrol.delay.spectrum import Spectrum, rightmost_roots
from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError
from flycontrol.jobs.progress import Progress, no_progress

if TYPE_CHECKING:
    from matplotlib.axes import Axes as MplAxes

Quantity = Literal["unstable_roots", "decay_rate", "modulus_margin", "boundary"]
_QUANTITIES = ("unstable_roots", "decay_rate", "modulus_margin", "boundary")
_MOST_STEPS = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """A parameter and the values at which a chart looks.

    Raises
    ------
    InvalidParameterError
        If the values do not rise strictly or are not finite.
    """

    name: str
    unit: str
    values: FloatArray  #: rising, shape (k,); one value makes the chart a slice

    def __post_init__(self) -> None:
        grid = real_array(self.values, f"The values of the axis {self.name!r}")
        rises = grid.ndim == 1 and len(grid) > 0 and bool(np.isfinite(grid).all() and (np.diff(grid) > 0).all())
        if not rises:
            raise InvalidParameterError(f"The values of the axis {self.name!r} must be finite and rise strictly.")
        grid.setflags(write=False)
        object.__setattr__(self, "values", grid)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StabilityChart:
    """A grid over two parameters. A quantity that was not asked for is None."""

    x: Axis
    y: Axis
    unstable_roots: NDArray[np.int64]  #: roots with Re s > 0, shape (ny, nx); -1 where one lies on the axis
    decay_rate: FloatArray | None = None  #: -max Re s [1/s], shape (ny, nx); NaN where not certified
    modulus_margin: FloatArray | None = None  #: min |1 + L(jw)|, shape (ny, nx); NaN where the loop is not stable
    boundary: tuple[DCurve, ...] | None = None  #: curves on which a root lies on the imaginary axis

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where every root has Re s < 0, shape (ny, nx)."""
        return self.unstable_roots == 0

    def plot(self, quantity: str | None = None, **options: Any) -> MplAxes:
        """Draw it; options and return value as in `stability_chart_plot`."""
        from flycontrol.delay.plots import stability_chart_plot

        return stability_chart_plot(self, quantity, **options)


def stability_chart(  # noqa: PLR0913 (options by name)
    system_at: Callable[[float, float], Member],
    x: Axis,
    y: Axis,
    quantities: Sequence[Quantity] = ("unstable_roots",),
    *,
    loop_at: Callable[[float, float], DelayLTI] | None = None,
    batched: bool = False,
    progress: Progress = no_progress,
) -> StabilityChart:
    """Chart of the closed loops system_at(x, y).

    Unstable roots are counted by the argument principle at each point. The decay rate follows the rightmost root from
    point to point by Newton, and the count decides whether it is the rightmost one; where it objects, roots are sought
    anew. The boundary is traced by continuation (`flycontrol.delay.dcurve`).

    Parameters
    ----------
    system_at
        Closed loop at (x, y): a `DelayLTI`, or `CharacteristicBlocks` where speed matters.
    quantities
        Any of "unstable_roots" (always computed), "decay_rate", "modulus_margin", "boundary".
    loop_at
        Open loop L at (x, y), one input and one output, around which negative unit feedback is closed; needed by
        "modulus_margin".
    batched
        Whether `system_at` also takes a row of the grid, two arrays (k,), and then returns `CharacteristicBlocks` with
        a leading axis of k where they differ: as fast as counting itself.
    progress
        Called after each row of the grid and each further part.

    Raises
    ------
    InvalidParameterError
        If a quantity is unknown, the modulus margin is asked for without `loop_at`, the boundary on a slice, or the
        family refuses a point.
    NeutralSystemError
        If a member is of neutral type.
    """
    _check(x, y, quantities, loop_at)
    require_callable(system_at, "The family of a chart")
    low, high = np.array([x.values[0], y.values[0]]), np.array([x.values[-1], y.values[-1]])
    family = Family(system_at, low, high)
    parts = len(y.values) + len({*quantities} - {"unstable_roots"})
    done = len(y.values)
    rows: list[list[Member]] = []
    unstable = np.empty((len(y.values), len(x.values)), dtype=np.int64)
    for i, v in enumerate(y.values.tolist()):
        if not batched or "decay_rate" in quantities:
            rows.append([family.at(u, v) for u in x.values.tolist()])
        unstable[i] = _unstable_at_once(family, x.values, v) if batched else _unstable_one_by_one(rows[-1])
        progress(i + 1, parts, "unstable roots")
    rates = margin = boundary = None
    if "decay_rate" in quantities:
        rates = _decay_rates(rows)
        progress(done := done + 1, parts, "decay rate")
    if loop_at is not None and "modulus_margin" in quantities:
        margin = _modulus_margins(Family(loop_at, low, high), x, y, unstable)
        progress(done := done + 1, parts, "modulus margin")
    if "boundary" in quantities:
        boundary = trace_boundary(family, x.values, y.values, unstable)
        progress(done + 1, parts, "boundary")
    return StabilityChart(
        x=x, y=y, unstable_roots=unstable, decay_rate=rates, modulus_margin=margin, boundary=boundary
    )  # fmt: skip


def _check(
    x: Axis, y: Axis, quantities: Sequence[Quantity], loop_at: Callable[[float, float], DelayLTI] | None
) -> None:
    for axis in (x, y):
        if not isinstance(axis, Axis):
            raise InvalidParameterError(
                f"A chart needs each axis as Axis(name, unit, values), got {type(axis).__name__}."
            )
    unknown = [quantity for quantity in quantities if quantity not in _QUANTITIES]
    if unknown:
        raise InvalidParameterError(f"A chart has no quantity {unknown[0]!r}; choose from {', '.join(_QUANTITIES)}.")
    if "modulus_margin" in quantities and loop_at is None:
        raise InvalidParameterError(
            "The modulus margin is a distance of the open loop from -1: give loop_at, the open loop at (x, y)."
        )
    if "boundary" in quantities and min(len(x.values), len(y.values)) < 2:
        raise InvalidParameterError("A boundary needs at least two values on both axes; a slice has crossings instead.")


def _unstable_at_once(family: Family, x: FloatArray, y: float) -> NDArray[np.int64]:
    """Roots with Re s > 0 along a row of the grid (nx,), -1 where one lies on the axis, from one stack of blocks."""
    points = np.column_stack([x, np.full(len(x), y)])
    return np.maximum(numbers_of_stack(family.stack(points), np.zeros(len(x))).roots, -1)


def _unstable_one_by_one(members: Sequence[Member]) -> NDArray[np.int64]:
    """The same from the members of the row."""
    return np.maximum(numbers_right_of(members, np.zeros(len(members))).roots, -1)


def _modulus_margins(loops: Family, x: Axis, y: Axis, unstable: NDArray[np.int64]) -> FloatArray:
    """min |1 + L(jw)| where the closed loop is stable, NaN elsewhere."""
    margin = np.full(unstable.shape, np.nan)
    for i, j in np.argwhere(unstable == 0):
        margin[i, j] = margins(loops.system(np.array([x.values[j], y.values[i]]))).modulus_margin
    return margin


def _decay_rates(rows: list[list[Member]]) -> FloatArray:
    """-max Re s at every point, from neighbour to neighbour, every other row backwards."""
    path = [system for i, row in enumerate(rows) for system in (row if i % 2 == 0 else row[::-1])]
    rates = -np.concatenate([_abscissae(list(run)) for _, run in groupby(path, key=_shape)])
    rates = rates.reshape(len(rows), -1)
    rates[1::2] = rates[1::2, ::-1].copy()
    return rates


def _shape(member: Member) -> tuple[int, ...]:
    return member.B2.shape


def _abscissae(systems: list[Member]) -> FloatArray:
    """Real parts of the rightmost roots of neighbouring systems of equal shapes; NaN where none could be certified."""
    found = np.empty(len(systems))
    A, B2, C2, D22, tau = stacked(systems)
    place = 0
    while place < len(systems):
        spectrum = _certified(systems[place])
        found[place] = np.nan if spectrum is None else spectrum.abscissa
        known = np.zeros(0, dtype=np.complex128) if spectrum is None else spectrum.roots
        place = decay.abscissae(A, B2, C2, D22, tau, known[known.imag >= 0], found, place + 1, _MOST_STEPS)
    return found


def _certified(member: Member) -> Spectrum | None:
    for count in (6, 9, 12):
        spectrum = rightmost_roots(as_system(member), count)
        if spectrum.status.startswith("certified"):
            return spectrum
    return None

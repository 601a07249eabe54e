"""The outline of a wing as a polygon: x along the chord, y along the span from the hinge; chord, area and moments.

The length of the lines of constant y within a polygon is linear between its corners, so the chord table that it becomes
is exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.planform import ChordTable, beta_chord

FloatArray = NDArray[np.float64]

MOST_POINTS = 4000
_OPEN = 2.0  #: times the longest edge that the edge from the last point back to the first may be long
_SAME = 1e-12  #: [wing lengths]


@dataclass(frozen=True, slots=True, kw_only=True)
class WingShape:
    """A planform in units of its wing length, hinge to tip."""

    table: ChordTable
    mean_chord: float | None  #: over the wing length, so the wing's area over its square; None: not known

    @property
    def first_moment_radius(self) -> float:
        """r1 / R."""
        return self.table.moment_radius(1)

    @property
    def second_moment_radius(self) -> float:
        """r2 / R."""
        return self.table.moment_radius(2)

    @property
    def largest_chord(self) -> float:
        """Over the mean chord."""
        return max(self.table.chord) / _mean(self.table)

    def beta_difference(self) -> float:
        """Root mean square over the span of c - c_beta, over the mean chord, c_beta of equal area and r2."""
        x = (np.arange(4000) + 0.5) / 4000
        own = np.interp(x, self.table.span, self.table.chord) / _mean(self.table)
        return float(np.sqrt(np.mean((own - beta_chord(x, self.second_moment_radius)) ** 2)))


def outline_shape(points: FloatArray) -> WingShape:
    """Chords of an outline.

    Parameters
    ----------
    points : (N, 2) corners in order, either way round, the first repeated or not: x along the chord, y along the span
        from the hinge, in one unit; the tip is where y is largest

    Raises
    ------
    InvalidInputError
        If the points are no simple closed outline from the hinge outwards.
    """
    corners = _corners(np.asarray(points, dtype=np.float64))
    refuse_crossing_edges(corners)
    return polygon_shape(corners)


def polygon_shape(corners: FloatArray) -> WingShape:
    """Chords of a polygon known to be simple; corners (N, 2), the first not repeated."""
    if corners[:, 1].min() < 0 or not np.ptp(corners[:, 1]) > 0:
        raise InvalidInputError(
            "an outline must lie beyond the hinge, at span positions >= 0, and this one reaches from "
            f"{corners[:, 1].min():.4g} to {corners[:, 1].max():.4g}; put the hinge at 0 and the span second."
        )
    corners = corners / corners[:, 1].max()
    y = _distinct(corners[:, 1])
    low, high = _limits(corners, y)
    if not max(low.max(), high.max()) > _SAME:
        raise InvalidInputError("an outline must enclose an area, and the points of this one lie on a line.")
    span, chord = _rows(y, np.maximum(low, 0.0), np.maximum(high, 0.0))  # 0 to rounding where edges meet in a corner
    table = ChordTable(span=tuple(span), chord=tuple(chord))
    return WingShape(table=table, mean_chord=_mean(table))


def refuse_crossing_edges(corners: FloatArray) -> None:
    """Refuse a polygon, corners (N, 2), of which two edges that are no neighbours meet."""
    start, end = corners, np.roll(corners, -1, axis=0)
    count = len(corners)
    for k in range(count - 2):
        others = np.arange(k + 2, count - (k == 0))
        crossed = others[_meets(start[k], end[k], start[others], end[others])]
        if crossed.size:
            j = int(crossed[0])
            raise InvalidInputError(
                f"an outline must not cross itself, and the edges after points {k + 1} and {j + 1} meet; list the "
                "points in order, once around the wing."
            )


def _corners(points: FloatArray) -> FloatArray:
    """Drop the repetition of the first point; refuse what is too short, open or repeated."""
    if points.ndim != 2 or points.shape[1] != 2 or not np.all(np.isfinite(points)):
        raise InvalidInputError(f"an outline needs points (N, 2) of finite numbers, got an array {points.shape}.")
    if len(points) > 1 and np.array_equal(points[0], points[-1]):
        points = points[:-1]
    if not 3 <= len(points) <= MOST_POINTS:
        raise InvalidInputError(f"an outline needs 3 to {MOST_POINTS} different points, got {len(points)}.")
    _, first, counts = np.unique(points, axis=0, return_index=True, return_counts=True)
    if np.any(counts > 1):
        twice = int(first[counts > 1].min())
        raise InvalidInputError(
            f"an outline passes each point once, and point {twice + 1}, {points[twice, 0]:g}, {points[twice, 1]:g}, "
            "stands there again; drop one."
        )
    edges = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    if edges[-1] > _OPEN * edges[:-1].max():
        raise InvalidInputError(
            f"an outline must be closed, and from the last point of this one to its first there is a gap of "
            f"{edges[-1]:.3g}, where its longest edge is {edges[:-1].max():.3g}; list the points all around the wing."
        )
    return points


def _meets(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> NDArray[np.bool_]:
    """Whether the segment a-b meets the segments c-d, (M, 2) each."""

    def side(p: FloatArray, q: FloatArray, r: FloatArray) -> FloatArray:
        along, to = q - p, r - p
        return np.sign(along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0])

    crossing = (side(a, b, c) * side(a, b, d) <= 0) & (side(c, d, a) * side(c, d, b) <= 0)
    low, high = np.minimum(a, b), np.maximum(a, b)  # segments of one line meet only where their boxes do
    return crossing & np.all((np.minimum(c, d) <= high) & (np.maximum(c, d) >= low), axis=-1)


def _distinct(y: FloatArray) -> FloatArray:
    ordered = np.unique(y)
    return ordered[np.concatenate([np.diff(ordered) > _SAME, [True]])]


def _limits(corners: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Chords at the lower and at the upper end of every strip between neighbouring corners' y, each (len(y) - 1,)."""
    ahead = np.roll(corners, -1, axis=0)
    low, high = np.zeros(len(y) - 1), np.zeros(len(y) - 1)
    for k, (bottom, top) in enumerate(pairwise(y)):
        middle = (bottom + top) / 2
        across = (corners[:, 1] > middle) != (ahead[:, 1] > middle)
        (x0, y0), (x1, y1) = corners[across].T, ahead[across].T
        slope = (x1 - x0) / (y1 - y0)
        sign = np.where(np.argsort(np.argsort(x0 + slope * (middle - y0))) % 2, 1.0, -1.0)
        low[k], high[k] = np.sum(sign * (x0 + slope * (bottom - y0))), np.sum(sign * (x0 + slope * (top - y0)))
    return low, high


def _rows(y: FloatArray, low: FloatArray, high: FloatArray) -> tuple[list[float], list[float]]:
    """Rows of a chord table; a chord that jumps does so between two rows beside one another."""
    below, above = np.concatenate([[0.0], high]), np.concatenate([low, [0.0]])
    span, chord = [0.0], [float(above[0]) if y[0] <= _SAME else 0.0]
    for at, left, right in zip(y, below, above, strict=True):
        if at <= _SAME:
            continue
        if at >= 1.0:
            rows = [(1.0, left)]
        elif abs(right - left) <= _SAME:
            rows = [(at, left)]
        else:
            rows = [(at - _SAME / 4, left), (at + _SAME / 4, right)]
        span += [float(row[0]) for row in rows]
        chord += [float(row[1]) for row in rows]
    return span, chord


def _mean(table: ChordTable) -> float:
    return float(np.trapezoid(table.chord, table.span))

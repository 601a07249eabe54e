"""Regions of a stability chart as a fine picture: cut along the D-curves, counted at the grid points within."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.ndimage
from numpy.typing import NDArray

from flycontrol.delay.chart import StabilityChart
from flycontrol.delay.system import FloatArray

_PIXELS = 720  # along each axis
_LEAST_AREA = 40  # pixels of a region; smaller ones are corners between curves
UNKNOWN = -1  #: number of unstable roots of a piece that holds no grid point
_GAP = -2  # pixels that belong to the piece beside them


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A connected region with equally many unstable roots."""

    unstable_roots: int  #: or UNKNOWN
    x: float  #: its point farthest from every border
    y: float
    room: float  #: distance of that point to the border, in units of the picture


@dataclass(frozen=True, slots=True, eq=False)
class Regions:
    """Number of unstable roots pixel by pixel, and the regions; the picture ends at the first and last grid values."""

    unstable_roots: NDArray[np.int64]  #: shape (pixels, pixels), rows by rising y; or UNKNOWN
    regions: tuple[Region, ...]


def regions_of(chart: StabilityChart) -> Regions:
    """The regions between the D-curves of a chart; without curves each pixel is as the grid point nearest to it.

    A piece of the plane that the curves cut out has the number of unstable roots of its grid points. Where these
    differ, a curve is not known, and pixels are again as the nearest grid point; a piece too narrow for the grid stays
    unknown.
    """
    nearest = _nearest(chart)
    labels: Any = scipy.ndimage.label(~_cut(chart))
    piece, many = labels[0], labels[1]
    votes = piece[_pixel(_unit(chart.y.values))[:, None], _pixel(_unit(chart.x.values))]
    roots = np.full(piece.shape, _GAP, dtype=np.int64)
    for k in range(1, many + 1):
        counted = chart.unstable_roots[(votes == k) & (chart.unstable_roots >= 0)]
        within = piece == k
        if within.sum() < _LEAST_AREA:
            continue
        if not len(counted):
            roots[within] = UNKNOWN
        else:
            roots[within] = counted[0] if (counted == counted[0]).all() else nearest[within]
    roots = _spread(roots, roots == _GAP)
    return Regions(roots, tuple(_regions(chart, roots)))


def _unit(values: FloatArray) -> FloatArray:
    """Between 0 and 1 from the first to the last value."""
    return (values - values[0]) / (values[-1] - values[0])


def _pixel(share: FloatArray) -> NDArray[np.int64]:
    return np.clip(np.rint(share * (_PIXELS - 1)), 0, _PIXELS - 1).astype(np.int64)


def _nearest(chart: StabilityChart) -> NDArray[np.int64]:
    """Number of unstable roots at the nearest grid point where it is known."""
    known = _spread(chart.unstable_roots, chart.unstable_roots < 0)
    share = np.linspace(0.0, 1.0, _PIXELS)
    row, column = (np.abs(_unit(axis.values)[:, None] - share).argmin(axis=0) for axis in (chart.y, chart.x))
    return known[row[:, None], column]


def _spread(roots: NDArray[np.int64], gaps: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Entries in gaps replaced by the nearest others; UNKNOWN where there is no other."""
    if gaps.all():
        return np.full_like(roots, UNKNOWN)
    place: Any = scipy.ndimage.distance_transform_edt(gaps, return_distances=False, return_indices=True)
    return roots[tuple(place)]


def _cut(chart: StabilityChart) -> NDArray[np.bool_]:
    """Pixels on a curve, gapless for steps along rows and columns."""
    cut = np.zeros((_PIXELS, _PIXELS), dtype=np.bool_)
    x, y = chart.x.values, chart.y.values
    for curve in chart.boundary or ():
        points = np.column_stack([(curve.x - x[0]) / (x[-1] - x[0]), (curve.y - y[0]) / (y[-1] - y[0])])
        if len(points) < 2:
            continue
        points = np.vstack([_beyond(points[1], points[0]), points, _beyond(points[-2], points[-1])])
        along = np.append(0.0, np.hypot(*np.diff(points, axis=0).T).cumsum())
        fine = np.linspace(0.0, along[-1], 2 + int(4 * _PIXELS * along[-1]))
        u, v = (np.interp(fine, along, points[:, k]) for k in (0, 1))
        inside = (np.abs(u - 0.5) <= 0.5) & (np.abs(v - 0.5) <= 0.5)
        cut[_pixel(v[inside]), _pixel(u[inside])] = True
    return cut


def _beyond(before: FloatArray, end: FloatArray) -> FloatArray:
    """Two pixels on: curves end a little before the edge of the box or the curve that they run into."""
    step = end - before
    return end + 2.0 / _PIXELS * step / max(float(np.hypot(*step)), 1e-300)


def _regions(chart: StabilityChart, roots: NDArray[np.int64]) -> list[Region]:
    found: list[Region] = []
    for many in np.unique(roots):
        label: Any = scipy.ndimage.label(roots == many)
        for k in range(1, label[1] + 1):
            within = label[0] == k
            if within.sum() < _LEAST_AREA:
                continue
            depth = np.asarray(scipy.ndimage.distance_transform_edt(np.pad(within, 1)))[1:-1, 1:-1]
            i, j = np.unravel_index(int(depth.argmax()), depth.shape)
            x, y = (
                axis.values[0] + place / (_PIXELS - 1) * (axis.values[-1] - axis.values[0])
                for axis, place in ((chart.x, j), (chart.y, i))
            )
            found.append(Region(int(many), float(x), float(y), float(depth.max()) / _PIXELS))
    return found

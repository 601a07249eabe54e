"""Stability boundaries in a plane of two parameters: curves on which a root lies on the imaginary axis (D-curves)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flycontrol.delay.characteristic import matrix, matrix_derivative
from flycontrol.delay.count import count_right_of
from flycontrol.delay.family import Family
from flycontrol.delay.real import real_array, real_number
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LONGEST = 0.02  # step along a curve, in units of the box
_SHORTEST = 1e-7
_SHARPEST = 0.2  # turn of a curve within a step [rad]
_MOST_POINTS = 5000
_BISECTIONS = 7


class PDGains(NamedTuple):
    """Gains of u = -(kp y + kd y')."""

    kp: FloatArray  #: [1/s^2]
    kd: FloatArray  #: [1/s]


def pd_boundary(b: float, T: float, omega: ArrayLike) -> PDGains:
    """kp = w^2 cos wT + b w sin wT,  kd = w sin wT - b cos wT.

    The gains at which the plant 1 / (s (s + b)) under PD feedback through a delay, s^2 + b s + (kp + kd s) exp(-s T),
    has roots at +-jw. Together with kp = 0, where a root is at the origin, they bound all regions of equally many
    unstable roots.

    Parameters
    ----------
    b
        Damping rate of the plant [1/s].
    T
        Delay [s].
    omega
        Frequencies w >= 0 [rad/s], any shape.

    Raises
    ------
    InvalidParameterError
        If the delay is negative or something is not finite.
    """
    w = real_array(omega, "The frequencies of a PD boundary [rad/s]")
    b, T = real_number(b, "The damping rate of a PD boundary [1/s]"), real_number(T, "The delay of a PD boundary [s]")
    if not (np.isfinite(b) and np.isfinite(T) and T >= 0 and np.isfinite(w).all()):
        raise InvalidParameterError(
            f"A PD boundary needs finite b and omega and a delay >= 0 s, got b = {b:g}, T = {T:g} and omega = "
            f"{np.array2string(w, threshold=6)}."
        )
    return PDGains(w**2 * np.cos(w * T) + b * w * np.sin(w * T), w * np.sin(w * T) - b * np.cos(w * T))


@dataclass(frozen=True, slots=True, eq=False)
class DCurve:
    """One piece of a stability boundary, in order along the curve; the number of roots on its right side changes."""

    x: FloatArray  #: first parameter, shape (k,)
    y: FloatArray  #: second parameter, shape (k,)
    omega: FloatArray  #: imaginary part of the root on the axis [rad/s], shape (k,); zeros on a static boundary

    @property
    def static(self) -> bool:
        """Whether a real root passes the origin here (one root changes sides), rather than a pair the axis (two)."""
        return not self.omega.any()

    def plot(self, **options: Any) -> Axes:
        """Draw it; options and return value as in `d_curve_plot`."""
        from flycontrol.delay.plots import d_curve_plot

        return d_curve_plot(self, **options)


def trace_boundary(family: Family, x: FloatArray, y: FloatArray, unstable: NDArray[np.int64]) -> tuple[DCurve, ...]:
    """The curves det M(jw; x, y) = 0 that separate grid points with different numbers of unstable roots.

    On a grid edge whose ends differ, bisection with the root count and Newton find a point of the curve; from there it
    is followed in (w, x, y) by pseudo-arclength continuation in both directions, to the edge of the box, to w = 0 or
    around to its start. Curves that no grid edge tells apart are not found.

    Parameters
    ----------
    x, y
        Rising grid values, shapes (nx,) and (ny,), both at least 2.
    unstable
        Number of unstable roots, shape (ny, nx); -1 where a root lies on the axis.
    """
    tracer = _Tracer(family)
    curves: list[_Curve] = []
    for edge in _grid_edges(x, y, unstable):
        if _explained(edge, curves) >= abs(edge.change):
            continue
        for seed in tracer.seeds(edge):
            if not any(curve.passes(seed) for curve in curves):
                curves.append(tracer.curve(seed))
    return tuple(tracer.in_units(curve) for curve in curves)


class _Edge(NamedTuple):
    """A grid edge in units of the box; a grid point whose roots could not be counted is an edge of no length."""

    start: FloatArray  #: (2,)
    end: FloatArray  #: (2,)
    before: int
    after: int

    @property
    def change(self) -> int:
        return self.after - self.before


def _grid_edges(x: FloatArray, y: FloatArray, unstable: NDArray[np.int64]) -> list[_Edge]:
    """Edges between neighbours with different counts, and grid points with a root on the axis."""
    u, v = (x - x[0]) / (x[-1] - x[0]), (y - y[0]) / (y[-1] - y[0])
    edges: list[_Edge] = []
    for i, j in np.ndindex(unstable.shape):
        here, count = np.array([u[j], v[i]]), int(unstable[i, j])
        if count < 0:
            edges.append(_Edge(here, here, 0, 1))
            continue
        for k, m in ((i, j + 1), (i + 1, j)):
            if k < len(y) and m < len(x) and unstable[k, m] >= 0 and unstable[k, m] != count:
                edges.append(_Edge(here, np.array([u[m], v[k]]), count, int(unstable[k, m])))
    return edges


@dataclass(slots=True, eq=False)
class _Curve:
    """Points (w, x, y) along a curve, in units of a frequency and of the box."""

    points: FloatArray  #: (k, 3)
    static: bool

    def passes(self, seed: FloatArray) -> bool:
        """Whether a point lies on the curve, as far as its chords can tell."""
        if (seed[0] == 0.0) != self.static:
            return False
        start, chord = self.points[:-1], np.diff(self.points, axis=0)
        along = ((seed - start) * chord).sum(axis=1) / np.maximum((chord**2).sum(axis=1), 1e-300)
        nearest = start + np.clip(along, 0.0, 1.0)[:, None] * chord
        return bool((np.linalg.norm(seed - nearest, axis=1) < 0.1 * _LONGEST).any())


def _explained(edge: _Edge, curves: list[_Curve]) -> int:
    """How large a change of the count the curves already found explain on an edge: 2 for a pair, 1 for a real root."""
    total = 0
    direction = edge.end - edge.start
    if not direction.any():
        return sum(c.passes(np.array([0.0, *edge.start])) for c in curves if c.static)
    for curve in curves:
        ends = 1e-3 * np.array([curve.points[0] - curve.points[1], curve.points[-1] - curve.points[-2]])
        points = np.vstack([curve.points[0] + ends[0], curve.points, curve.points[-1] + ends[1]])  # onto the box's edge
        relative = points[:, 1:] - edge.start
        across = direction[0] * relative[:, 1] - direction[1] * relative[:, 0]
        along = relative @ direction / (direction @ direction)
        crosses = (across[1:] >= 0) != (across[:-1] >= 0)
        share = across[:-1][crosses] / (across[:-1] - across[1:])[crosses]
        where = along[:-1][crosses] + share * (along[1:] - along[:-1])[crosses]
        total += int(((where > 0) & (where < 1)).sum()) * (1 if curve.static else 2)
    return total


class _Tracer:
    """Newton and continuation on sigma(w, x, y) = u' M v = 0, the smallest singular value of M(jw; x, y)."""

    def __init__(self, family: Family) -> None:
        self._family = family
        self._width = family.high - family.low
        self._rate = family.rate

    def in_units(self, curve: _Curve) -> DCurve:
        """The curve in the parameters' units and rad/s."""
        w, x, y = curve.points.T
        low, width = self._family.low, self._width
        return DCurve(low[0] + width[0] * x, low[1] + width[1] * y, self._rate * w)

    def seeds(self, edge: _Edge) -> list[FloatArray]:
        """Points of the boundary on an edge: one for each interval, cut by bisection, whose ends differ."""
        intervals = [edge]
        for _ in range(_BISECTIONS):
            intervals = [half for whole in intervals for half in self._halves(whole)]
        found: list[FloatArray] = []
        for piece in intervals:
            found += self._solved(piece)
        return found

    def _halves(self, edge: _Edge) -> list[_Edge]:
        if edge.start is edge.end:
            return [edge]
        middle = 0.5 * (edge.start + edge.end)
        count = count_right_of(self._family.system(self._point(middle)), 0.0).roots
        if count is None:  # a root on the axis: found
            return [_Edge(middle, middle, edge.before, edge.after)]
        halves = (_Edge(edge.start, middle, edge.before, count), _Edge(middle, edge.end, count, edge.after))
        return [half for half in halves if half.change != 0]

    def _solved(self, edge: _Edge) -> list[FloatArray]:
        """Newton along an edge (in w and the place on it) from the roots nearest to the axis."""
        middle = 0.5 * (edge.start + edge.end)
        roots = rightmost_roots(self._family.system(self._point(middle)), max(edge.before, edge.after) + 2).roots
        upper = roots[roots.imag >= 0]
        nearest = upper[np.argsort(np.abs(upper.real))][: 1 if edge.change in (1, -1, 2, -2) else 2]
        found: list[FloatArray] = []
        for root in nearest:
            start = np.array([root.imag / self._rate, *middle])
            direction = edge.end - edge.start
            moves = np.array([[1.0, 0.0, 0.0], [0.0, *direction]]) if direction.any() else np.eye(3)
            solution = self._newton(start, moves)
            if solution is not None and np.abs(solution - start)[1:].max() < 0.05:
                found.append(solution)
        return found

    def curve(self, seed: FloatArray) -> _Curve:
        """The whole curve through a seed."""
        static = seed[0] == 0.0
        tangent = self._tangent(seed)
        onward = self._followed(seed, tangent)
        closed = len(onward) > 3 and bool((onward[-1] == seed).all())
        backward = [] if closed else self._followed(seed, -tangent)
        return _Curve(np.array([*backward[::-1], seed, *onward]), static)

    def _followed(self, seed: FloatArray, tangent: FloatArray) -> list[FloatArray]:
        points: list[FloatArray] = []
        here, step = seed, 0.5 * _LONGEST
        while len(points) < _MOST_POINTS and step > _SHORTEST:
            ahead = here + step * tangent
            if not _inside(ahead):
                last = self._at_the_edge(here, ahead)
                if last is not None and np.linalg.norm(last - here) > 1e-9:
                    points.append(last)
                return points
            there = self._newton(ahead, np.eye(3))
            onward = tangent if there is None else self._tangent(there)
            onward = onward if onward @ tangent > 0 else -onward
            turn = float(np.arccos(min(1.0, onward @ tangent)))
            if there is None or not _inside(there) or turn > _SHARPEST or np.linalg.norm(there - ahead) > 0.3 * step:
                step *= 0.5
                continue
            if len(points) > 2 and np.linalg.norm(there - seed) < 0.75 * step and onward @ (seed - here) > 0:
                return [*points, seed]
            points.append(there)
            here, tangent = there, onward
            step = min(_LONGEST, step * (1.5 if turn < 0.4 * _SHARPEST else 1.0))
        return points

    def _at_the_edge(self, here: FloatArray, ahead: FloatArray) -> FloatArray | None:
        """Where the curve leaves the box or reaches w = 0: that coordinate fixed, Newton in the others."""
        bounds = np.where(ahead > here, [np.inf, 1.0, 1.0], [1e-4 if here[0] > 1e-4 else 0.0, 0.0, 0.0])
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(ahead != here, (bounds - here) / (ahead - here), np.inf)
        share = np.where(share < 0.0, np.inf, share)
        first = int(np.argmin(share))
        start = here + min(1.0, float(share[first])) * (ahead - here)
        start[first] = bounds[first]
        solution = self._newton(start, np.delete(np.eye(3), first, axis=0))
        near = solution is not None and np.linalg.norm(solution - start) < _LONGEST
        return solution if near else None

    def _newton(self, start: FloatArray, moves: FloatArray) -> FloatArray | None:
        """The nearest solution within start + span(moves), w kept at 0; None if Newton does not converge in the box."""
        here, last = start, np.inf
        if start[0] == 0.0:
            moves = moves * np.array([0.0, 1.0, 1.0])
        for _ in range(20):
            value, slope = self._equations(here)
            step = -moves.T @ np.linalg.lstsq(slope @ moves.T, value, rcond=1e-12)[0]
            size = float(np.linalg.norm(step))
            if not size < 0.5:
                return None
            here = here + step
            here = np.array([here[0], *np.clip(here[1:], 0.0, 1.0)])
            if size < 1e-14 or (size < 1e-9 and size >= 0.5 * last):
                return here
            last = size
        return None

    def _tangent(self, z: FloatArray) -> FloatArray:
        """Direction in which the equations stay fulfilled."""
        _, slope = self._equations(z)
        static = z[0] == 0.0
        along = np.array([0.0, -slope[0, 2], slope[0, 1]]) if static else np.cross(slope[0], slope[1])
        return along / np.linalg.norm(along)

    def _equations(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """sigma and its derivatives in w, x, y, split into real and imaginary part (only the real part at w = 0)."""
        point, s = self._point(z[1:]), 1j * self._rate * z[0]
        blocks = self._family.blocks(point)
        U, sigma, Vh = np.linalg.svd(matrix(blocks, s))
        u, v = U[:, -1].conj(), Vh[-1].conj()
        slope = np.zeros(3, dtype=np.complex128)
        slope[0] = 1j * self._rate * (u @ matrix_derivative(blocks, s) @ v)
        for axis in (0, 1):
            beside = self._family.neighbours(point, axis)
            if beside is not None:
                change = matrix(beside.after, s) - matrix(beside.before, s)
                slope[1 + axis] = (u @ change @ v) / beside.width * self._width[axis]
        parts = 1 if z[0] == 0.0 else 2
        return np.array([sigma[-1], 0.0])[:parts], np.array([slope.real, slope.imag])[:parts]

    def _point(self, place: FloatArray) -> FloatArray:
        return self._family.low + np.clip(place, 0.0, 1.0) * self._width


def _inside(z: FloatArray) -> bool:
    return bool(z[0] >= 0.0 and (z[1:] >= -1e-9).all() and (z[1:] <= 1.0 + 1e-9).all())

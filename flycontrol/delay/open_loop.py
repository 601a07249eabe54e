"""Poles of an open loop that matter to its frequency response: how many are unstable, which lie on the axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse.csgraph
from numpy.typing import NDArray

from flycontrol.delay.count import count_right_of
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import ComplexArray, DelayLTI, delay_lti
from flycontrol.errors import NeutralSystemError

_ON_THE_AXIS = 1e-12  # of the largest rate: eigenvalues are known to rounding only
_CLUSTER = 1e-6  # and those of a double or triple pole to a root of it


@dataclass(frozen=True, slots=True)
class AxisPole:
    """A pole of an open loop at j frequency, of some multiplicity, its computed eigenvalues within `spread` of it."""

    frequency: float  #: >= 0 [rad/s]
    multiplicity: int
    spread: float  #: [1/s]


@dataclass(frozen=True, slots=True, eq=False)
class OpenLoopPoles:
    """Poles of a system, seen from the imaginary axis."""

    on_axis: list[AxisPole]  #: by rising frequency
    unstable: int  #: how many lie right of the axis, those on it left out
    others: ComplexArray  #: listed poles that are not on the axis [1/s]
    complete_to: float  #: parts with delay that have poles on the axis are listed right of this line [1/s]
    counted: list[DelayLTI]  #: parts with delay and without poles on the axis, which are counted, not listed

    def alone(self, pole: AxisPole, radius: float) -> bool:
        """Whether no pole but those of `pole` can lie within a radius [1/s] of it."""
        if radius >= -self.complete_to or (np.abs(self.others - 1j * pole.frequency) <= radius).any():
            return False
        counts = [[count_right_of(part, side * radius) for side in (-1.0, 1.0)] for part in self.counted]
        return all(left.roots is not None and left.roots == right.roots for left, right in counts)


def open_loop_poles(system: DelayLTI) -> OpenLoopPoles:
    """Where the poles of a balanced system lie, one part after the other of those that feed each other one way only.

    Raises
    ------
    NeutralSystemError
        If the poles of an inner loop with delay, some of them on the axis, cannot be listed with a certificate.
    """
    scale = float((np.abs(system.A) + np.abs(system.B2) @ np.abs(system.C2)).max(initial=0.0))
    listed: list[ComplexArray] = [np.zeros(0, dtype=np.complex128)]
    counted: list[DelayLTI] = []
    unstable, complete_to = 0, -np.inf
    for states, delays in _parts(system):
        if len(delays) == 0:
            listed.append(np.linalg.eigvals(system.A[states][:, states]).astype(np.complex128))
            continue
        part = _part(system, states, delays)
        count = count_right_of(part, 0.0).roots
        if count is not None:
            counted.append(part)
            unstable += count
        else:
            roots, line = _listed(part, -_CLUSTER * scale)
            listed.append(roots)
            complete_to = max(complete_to, line)
    poles = np.concatenate(listed)
    on_axis = _axis_poles(poles, scale)
    others = poles[~_belong(poles, on_axis)]
    return OpenLoopPoles(on_axis, unstable + int((others.real > 0).sum()), others, complete_to, counted)


def _parts(system: DelayLTI) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """States and delay channels of the parts of a system that feed each other in one direction only."""
    n = system.n_states
    edges = np.block([[system.A, system.B2], [system.C2, system.D22]]) != 0
    many, part = scipy.sparse.csgraph.connected_components(edges, connection="strong")
    parts = [(np.flatnonzero(part[:n] == k), np.flatnonzero(part[n:] == k)) for k in range(many)]
    return [(states, delays) for states, delays in parts if len(states)]


def _part(system: DelayLTI, states: NDArray[np.intp], delays: NDArray[np.intp]) -> DelayLTI:
    return delay_lti(
        A=system.A[states][:, states], B1=np.zeros((len(states), 1)), C1=np.zeros((1, len(states))),
        B2=system.B2[states][:, delays], C2=system.C2[delays][:, states],
        D22=system.D22[delays][:, delays], tau=system.tau[delays],
    )  # fmt: skip


def _listed(part: DelayLTI, line: float) -> tuple[ComplexArray, float]:
    """Poles with Re s > line and some left of it, and the line down to which none is missing."""
    count = 1
    while True:
        found = rightmost_roots(part, count)
        if not found.status.startswith("certified") and count >= 64:
            raise NeutralSystemError(
                "An inner loop with delay has a pole on the imaginary axis, and its poles could not be listed with a "
                "certificate; change its gain or delay a little."
            )
        if found.status.startswith("certified") and found.line < line:
            return found.roots, found.line
        count *= 2


def _axis_poles(poles: ComplexArray, scale: float) -> list[AxisPole]:
    """Poles on the upper imaginary axis, 0 included, by rising frequency.

    Eigenvalues within rounding of the axis are on it. So is a cluster whose mean is: rounding spreads the eigenvalues
    of a multiple pole over a small circle around it.
    """
    near = poles[(np.abs(poles.real) <= _CLUSTER * scale) & (poles.imag >= -_CLUSTER * scale)]
    exact = np.abs(near.real) <= _ON_THE_AXIS * scale
    groups = _clusters(near[exact], 1e3 * _ON_THE_AXIS * scale) + [
        group for group in _clusters(near[~exact], _CLUSTER * scale) if abs(group.mean().real) <= _ON_THE_AXIS * scale
    ]
    found: list[AxisPole] = []
    for group in groups:
        middle = float(group.mean().imag)
        frequency = 0.0 if abs(middle) <= np.abs(group - group.mean()).max() + _ON_THE_AXIS * scale else middle
        if frequency >= 0:  # the conjugate stands for the others
            found.append(AxisPole(frequency, len(group), float(np.abs(group - 1j * frequency).max())))
    return sorted(found, key=lambda pole: pole.frequency)


def _clusters(points: ComplexArray, reach: float) -> list[ComplexArray]:
    """Points grouped so that every point within `reach` of another is in its group."""
    groups: list[ComplexArray] = []
    for point in points:
        near = [group for group in groups if np.abs(group - point).min() <= reach]
        groups = [group for group in groups if all(group is not other for other in near)]
        groups.append(np.concatenate([*near, [point]]))
    return groups


def _belong(poles: ComplexArray, on_axis: list[AxisPole]) -> NDArray[np.bool_]:
    """Which poles are those on the axis, conjugates included."""
    close = np.zeros(len(poles), dtype=bool)
    for pole in on_axis:
        for place in (1j * pole.frequency, -1j * pole.frequency):
            close |= np.abs(poles - place) <= 1.01 * pole.spread + 1e-14 * pole.frequency
    return close

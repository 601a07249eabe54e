"""How many roots lie right of a line: the argument principle with steps that a bound on the derivative justifies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.delay.balance import balance, root_bound
from flycontrol.delay.kernels import winding
from flycontrol.delay.system import DelayLTI

_MOST_STEPS = 200_000


@dataclass(frozen=True, slots=True, kw_only=True)
class RootCount:
    """Number of roots with Re s > line, or None with the reason in `status`."""

    line: float  #: [1/s]
    roots: int | None
    steps: int  #: evaluations of the characteristic matrix
    status: str  #: "certified", "a root too near the line" or "not certified"


def count_right_of(system: DelayLTI, line: float) -> RootCount:
    """Count the roots right of Re s = line by the phase of the characteristic function f along it.

    On the line the phase is followed from w = 0 to W = 2 R, with R a bound on |s| for roots right of it, by steps
    that cannot miss a turn. Beyond, f(s) / s^n is a product of factors 1 - mu / s with |mu| <= R, their phases
    principal values all the way to infinity. Hence Z = (phase of f on the arc - phase on the line) / pi.
    """
    x = balance(system)
    n = x.n_states
    if n == 0:
        return RootCount(line=line, roots=0, steps=0, status="certified")
    radius = root_bound(x, line)
    top = max(2.0 * radius, 2.0 * abs(line), 1e-12)
    blocks = (x.A.copy(), x.B2.copy(), x.C2.copy(), x.D22.copy(), x.tau.copy())
    phase, steps = winding.phase_along_line(blocks, line, top, _MOST_STEPS)
    if np.isnan(phase):
        return RootCount(line=line, roots=None, steps=steps, status="a root too near the line")
    corner = complex(line, top)
    factor = np.exp(-corner * x.tau)
    delayed = x.B2 @ np.linalg.solve(np.eye(x.n_delays) - factor[:, None] * x.D22, factor[:, None] * x.C2)
    arc = n * np.angle(corner) + np.angle(1.0 - np.linalg.eigvals(x.A + delayed) / corner).sum()
    turns = (arc - phase) / np.pi
    if abs(turns - round(turns)) > 1e-6:
        return RootCount(line=line, roots=None, steps=steps, status="not certified")
    return RootCount(line=line, roots=round(turns), steps=steps, status="certified")

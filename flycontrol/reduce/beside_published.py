"""A reduced model beside published numbers of *D. melanogaster*, in words; nothing is fitted to make them agree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.model.hinge import PUBLISHED_TRANSMISSION, TRANSMISSION_PROVENANCE
from flycontrol.model.provenance import Provenance
from flycontrol.reduce.reduced_yaw import ReducedYaw

PUBLISHED_INERTIA = 3.06e-13  #: body 45 deg nose up, about the vertical [kg m^2]
PUBLISHED_DAMPING = (21e-12, 54e-12)  #: beta [N m s]

_INERTIA = Provenance(source="cheng2011", certainty="S", note="about the vertical axis in hover, body 45 deg nose up")
_LOW = Provenance(source="cheng2010", certainty="S2", note="low end of the published damping")
_HIGH = Provenance(source="hesselberg2007", certainty="S", note="high end of the published damping")


@dataclass(frozen=True, slots=True, kw_only=True)
class BesidePublished:
    """One quantity of the reduced model and what was published of it, both in SI units."""

    name: str
    unit: str
    ours: float
    low: float  #: least published value
    high: float  #: largest published value
    sources: tuple[Provenance, ...]

    @property
    def agreement(self) -> str:
        """In words."""
        if self.low <= self.ours <= self.high:
            return "inside the published range"
        if self.ours < self.low:
            return f"{1 - self.ours / self.low:.0%} below {self._end('low')}"
        return f"{self.ours / self.high - 1:.0%} above {self._end('high')}"

    def _end(self, which: str) -> str:
        return "the published value" if self.low == self.high else f"the {which} end of the published range"


def beside_published(model: ReducedYaw) -> tuple[BesidePublished, ...]:
    """Inertia, damping, the half-life that both make, and mu where the model has it.

    The published half-life is ln 2 I / beta of the published inertia and damping: no source read so far states one.
    """
    low, high = PUBLISHED_DAMPING
    once = float(np.log(2)) * PUBLISHED_INERTIA
    rows = [
        ("I, body and wings", "kg m^2", model.inertia.total, (PUBLISHED_INERTIA, PUBLISHED_INERTIA), (_INERTIA,)),
        ("beta", "N m s", model.damping, (low, high), (_LOW, _HIGH)),
        ("half-life, ln 2 I / beta", "s", model.half_life, (once / high, once / low), (_INERTIA, _LOW, _HIGH)),
    ]
    if model.transmission is not None:
        rows.append(("mu", "1", model.transmission, PUBLISHED_TRANSMISSION, (TRANSMISSION_PROVENANCE,)))
    return tuple(
        BesidePublished(name=name, unit=unit, ours=ours, low=ends[0], high=ends[1], sources=sources)
        for name, unit, ours, ends, sources in rows
    )

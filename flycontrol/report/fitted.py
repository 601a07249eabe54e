"""What the stability report of a fitted fly says of the fit that its numbers come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flycontrol.identify.gains.study import FitStudy
from flycontrol.report.fit.tables import consequence_rows
from flycontrol.report.fit.words import differing_flies, in_symbols
from flycontrol.report.numbers import sentence

#: Quantities of the verdict's table, in the order of the intervals in `consequence_rows`.
_FINDINGS = ("Gain margin", "Phase margin", "Delay margin", "Modulus margin", "Recovery", "Slowest mode")


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedFrom:
    """Where the numbers of a stability report come from if they were fitted."""

    sentences: tuple[str, ...]  #: the fit's status, whether the flies differ
    intervals: Mapping[str, str]  #: by the quantity's first words in the verdict's table

    def interval(self, quantity: str) -> str:
        """Interval of a quantity of the verdict's table; empty if it has none."""
        return next((text for name, text in self.intervals.items() if quantity.startswith(name)), "")


def fitted_from(study: FitStudy) -> FittedFrom:
    """Status and intervals of a fit, in words."""
    level = f"{100 * study.result.level:g} %"
    ends = [f"{level} interval {row.cells[1]} {row.cells[2]}".removesuffix(" 1") for row in consequence_rows(study)]
    intervals: dict[str, str] = dict(zip(_FINDINGS, ends, strict=True)) if ends else {}
    if "Slowest mode" in intervals:
        intervals["Slowest mode"] += " (real part)"
    said = (f"The fit: {sentence(in_symbols(study.result.status))}", differing_flies(study))
    return FittedFrom(sentences=tuple(each for each in said if each), intervals=intervals)

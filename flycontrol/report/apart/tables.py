"""Rows of the tables on flies that are not pooled."""

from __future__ import annotations

import math

from flycontrol.identify.gains.apart import ApartStudy, Member
from flycontrol.report.fit.tables import Row
from flycontrol.report.fit.words import KINDS, OF_THE_LOOP, digits_for
from flycontrol.report.numbers import ABSENT, fixed
from flycontrol.units import deg, ms

#: What `Consequences` has intervals of, and the size of the unit that the table's head names.
_MARGINS = (("gain_margin", 1.0), ("delay_margin", ms), ("modulus_margin", 1.0), ("recovery_time", ms))


def kinds_of(study: ApartStudy) -> list[str]:
    """Unknowns of the loop that any member has, in the usual order."""
    found = {e.kind for member in study.members for e in member.study.result.estimates}
    return [kind for kind in OF_THE_LOOP if kind in found]


def heads(study: ApartStudy) -> list[tuple[str, str]]:
    """Symbol (HTML) and unit of the columns of `estimate_rows`."""
    return [(KINDS[kind][1], KINDS[kind][2]) for kind in kinds_of(study)]


def estimate_rows(study: ApartStudy) -> list[tuple[Member, Row]]:
    """Of each member its estimates with intervals, and whether they can be used."""
    return [
        (
            member,
            Row(
                head=member.name,
                cells=(
                    str(len(member.study.recordings)),
                    *(_estimate(member, kind) for kind in kinds_of(study)),
                    "usable" if member.study.result.usable else member.study.result.status.partition(":")[0],
                ),
                mark=not member.study.result.usable,
            ),
        )
        for member in study.members
    ]


def _estimate(member: Member, kind: str) -> str:
    e = next((e for e in member.study.result.estimates if e.name == kind), None)
    if e is None or e.undetermined:
        return ABSENT
    size = KINDS[kind][3]
    digits = digits_for(e.standard_error / size, e.value / size)
    return f"{fixed(e.value / size, digits)} ({_end(e.low / size, digits)} to {_end(e.high / size, digits)})"


def _end(value: float, digits: int) -> str:
    return fixed(value, digits) if math.isfinite(value) else "open"


def margin_rows(study: ApartStudy) -> list[Row]:
    """Of each member whose loop can be judged its margins and recovery with intervals."""
    rows = [Row(head=member.name, cells=_margins(member, study.level)) for member in study.members]
    return [row for row in rows if any(row.cells)]


def _margins(member: Member, level: float) -> tuple[str, ...]:
    found, at = member.study.consequences, member.study.stability
    if found is None or at is None or at.margins is None:
        return ()
    values = (at.margins.gain_margin, at.margins.delay_margin, at.margins.modulus_margin, at.recovery_time)
    cells: list[str] = []
    for (name, size), value in zip(_MARGINS, values, strict=True):
        low, high = (end / size for end in found.interval(name, level))
        digits = digits_for(abs(high - low) / 4, low)
        shown = fixed(None if value is None else value / size, digits)
        cells.append(f"{shown} ({_end(low, digits)} to {_end(high, digits)})")
    return tuple(cells)


def recovery_words(study: ApartStudy) -> str:
    """What the recovery of the tables is measured by."""
    task = next((m.study.stability.task for m in study.members if m.study.stability is not None), None)
    if task is None:
        return ""
    return (
        f"recovery to ±{fixed(task.tolerance / deg, 0)}° from a {fixed(task.peak / deg, 0)}° pulse of "
        f"{fixed(task.duration / ms, 1, 'ms')}"
    )

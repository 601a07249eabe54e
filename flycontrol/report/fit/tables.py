"""The rows of a fit report's further tables: controllers compared, flies, recordings predicted from the others."""

from __future__ import annotations

from dataclasses import dataclass

from flycontrol.identify.gains.random_effects import RandomEffects
from flycontrol.identify.gains.study import FitStudy, Group
from flycontrol.report.fit.words import KINDS, digits_for
from flycontrol.report.numbers import fixed, significant
from flycontrol.units import deg, ms

_MOST = 24  #: recordings in a table
_POOR = 2.0  #: noises by which a prediction misses that is marked


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Cells of one row, the first its head."""

    head: str
    cells: tuple[str, ...]
    mark: bool = False  #: drawn with a ground of its own


def controller_rows(study: FitStudy) -> list[Row]:
    """Unknowns, difference in AICc and BIC, weight, error of left-out samples, estimates of the shared gains."""
    found = study.comparison
    if found is None:
        return []
    aicc, bic = min(row.aicc for row in found.rows), min(row.bic for row in found.rows)
    return [
        Row(
            head=row.controller,
            cells=(
                str(row.unknowns), fixed(row.aicc - aicc, 1), fixed(row.bic - bic, 1), fixed(row.weight, 3),
                fixed(row.error / deg, 3), "" if row.converged else "not converged",
            ),
            mark=row.controller == study.result.controller,
        )
        for row in found.rows
    ]  # fmt: skip


def consequence_rows(study: FitStudy) -> list[Row]:
    """Margins, recovery and decay of the fitted loop, with intervals over the loops that the data allow as well."""
    found, at = study.consequences, study.stability
    if found is None or at is None or at.margins is None:
        return []
    task, level = at.task, study.result.level
    quantities: list[tuple[str, str, float | None, float, str]] = [
        ("gain margin", "gain_margin", at.margins.gain_margin, 1.0, "1"),
        ("phase margin", "phase_margin", at.margins.phase_margin, deg, "deg"),
        ("delay margin", "delay_margin", at.margins.delay_margin, ms, "ms"),
        ("modulus margin, min |1 + L|", "modulus_margin", at.margins.modulus_margin, 1.0, "1"),
        (
            f"recovery to ±{fixed(task.tolerance / deg, 0)}° from a {fixed(task.peak / deg, 0)}° pulse",
            "recovery_time", at.recovery_time, ms, "ms",
        ),
        ("real part of the rightmost pole", "abscissa", float(at.poles[0].real), 1.0, "1/s"),
    ]  # fmt: skip
    rows: list[Row] = []
    for words, name, value, size, unit in quantities:
        low, high = (end / size for end in found.interval(name, level))
        digits = digits_for(abs(high - low) / 4, low)
        shown = fixed(None if value is None else value / size, digits)
        rows.append(Row(head=words, cells=(shown, f"{fixed(low, digits)} to {fixed(high, digits)}", unit)))
    return rows


def effect_rows(group: Group) -> list[Row]:
    """Mean over flies with its interval, spread between them with its interval, p of no spread."""
    return [_effect(effect) for effect in group.effects]


def _effect(effect: RandomEffects) -> Row:
    words, _, unit, size = KINDS[effect.kind]
    digits = digits_for((effect.mean_high - effect.mean_low) / 4 / size, effect.mean / size)
    mean, *ends = (fixed(v / size, digits) for v in (effect.mean, effect.mean_low, effect.mean_high))
    spread, *limits = (fixed(v / size, digits) for v in (effect.deviation, effect.deviation_low, effect.deviation_high))
    return Row(head=words, cells=(mean, " to ".join(ends), spread, " to ".join(limits), significant(effect.p, 2), unit))


def prediction_rows(study: FitStudy) -> list[Row]:
    """Each recording predicted from the others, of many the worst."""
    worst = sorted(study.predictions, key=lambda each: -each.in_noise)[:_MOST]
    return [
        Row(
            head=each.trial,
            cells=(each.fly, *(fixed(v, 2) for v in (each.error / deg, each.noise / deg, each.in_noise))),
            mark=each.in_noise > _POOR,
        )
        for each in worst
    ]


def group_sentences(group: Group | None) -> list[str]:
    """Whether they differ, and who does not go with the others."""
    if group is None:
        return []
    test = [] if group.homogeneity is None else [group.homogeneity.sentence]
    return test + [outlier.sentence for outlier in group.outliers]

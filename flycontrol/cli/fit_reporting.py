"""How a study of gains is reported, whether its flies are pooled or not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flycontrol.identify.gains.apart import ApartStudy
    from flycontrol.identify.gains.result import FitResult
    from flycontrol.identify.gains.study import FitStudy
    from flycontrol.jobs.progress import Progress
    from flycontrol.model.parameters import Parameters


@dataclass(frozen=True, slots=True)
class Report:
    """What a study, pooled or apart, is reported by."""

    status: str
    summary: str  #: the loop's estimates with intervals; empty where there is no one loop
    beside: str  #: what lies beside the page; empty: all that was written
    write: Callable[[Parameters, Path, Progress], tuple[Path, ...]]
    json: Callable[[], str]


def listed(report: Report, written: tuple[Path, ...]) -> str:
    """The page that was written and what lies beside it."""
    page = next(path for path in written if path.name == "index.html")
    others = [path.name for path in written if path.name != "index.html"]
    return f"{page}{report.beside or ', ' + ', '.join(others[:-1]) + ' and ' + others[-1]}"


def _summary(result: FitResult) -> str:
    from flycontrol.identify.gains.result import spoken_estimate

    if result.found_nothing:
        return ""
    return "; ".join(f"{e.name} {spoken_estimate(e)}" for e in result.estimates if e.name == e.kind)


def report_of(found: FitStudy | ApartStudy, command: str) -> Report:
    """The report of a study."""
    from flycontrol.identify.gains.study import FitStudy

    if isinstance(found, FitStudy):
        from flycontrol.report.fit.page import fit_provenance, write_fit_report
        from flycontrol.report.fit.result import fit_result_json

        return Report(
            found.result.status, _summary(found.result), "",
            lambda fly, folder, progress: write_fit_report(found, fly, folder, command=command, progress=progress),
            lambda: fit_result_json(found, fit_provenance(found, command)),
        )  # fmt: skip
    from flycontrol.report.apart.page import apart_provenance, write_apart_report
    from flycontrol.report.apart.result import apart_result_json

    return Report(
        found.status, "", f", result.json, estimates.csv, table.md and a report of each {found.by}",
        lambda fly, folder, progress: write_apart_report(found, fly, folder, command=command, progress=progress),
        lambda: apart_result_json(found, apart_provenance(found, command)),
    )  # fmt: skip

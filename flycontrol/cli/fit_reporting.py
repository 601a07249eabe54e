"""How a study of gains is reported, whether its flies are pooled or not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flycontrol.identify.gains.apart import ApartStudy
    from flycontrol.identify.gains.study import FitStudy
    from flycontrol.jobs.progress import Progress
    from flycontrol.model.parameters import Parameters


@dataclass(frozen=True, slots=True)
class Report:
    """What a study, pooled or apart, is reported by."""

    status: str
    beside: str  #: names of what lies beside the page
    write: Callable[[Parameters, Path, Progress], object]
    json: Callable[[], str]


def report_of(found: FitStudy | ApartStudy, command: str) -> Report:
    """The report of a study."""
    from flycontrol.identify.gains.study import FitStudy

    if isinstance(found, FitStudy):
        from flycontrol.report.fit_page import fit_provenance, write_fit_report
        from flycontrol.report.fit_result import fit_result_json

        return Report(
            found.result.status, ", result.json, estimates.csv and table.md",
            lambda fly, folder, progress: write_fit_report(found, fly, folder, command=command, progress=progress),
            lambda: fit_result_json(found, fit_provenance(found, command)),
        )  # fmt: skip
    from flycontrol.report.apart_page import apart_provenance, write_apart_report
    from flycontrol.report.apart_result import apart_result_json

    return Report(
        found.status, f", result.json, estimates.csv, table.md and a report of each {found.by}",
        lambda fly, folder, progress: write_apart_report(found, fly, folder, command=command, progress=progress),
        lambda: apart_result_json(found, apart_provenance(found, command)),
    )  # fmt: skip

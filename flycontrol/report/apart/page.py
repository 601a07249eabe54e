"""The report of flies that are not pooled: a page on all, and the whole report of each in a folder of its own."""

from __future__ import annotations

from pathlib import Path

from flycontrol.identify.gains.apart import ApartStudy
from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.model.parameters import Parameters
from flycontrol.report.apart import tables as apart_tables
from flycontrol.report.apart.figures import apart_figures
from flycontrol.report.apart.result import apart_estimates_csv, apart_result_json, apart_table
from flycontrol.report.fit.page import fit_files, fit_provenance
from flycontrol.report.fit.result import FitProvenance
from flycontrol.report.fit.tables import effect_rows, group_sentences
from flycontrol.report.page import template_environment, the_css


def apart_provenance(study: ApartStudy, command: str) -> FitProvenance:
    """What the report was made from and with: no clock, no machine, no user."""
    return fit_provenance(study.members[0].study, command)


def write_apart_report(
    study: ApartStudy, parameters: Parameters, folder: Path, *, command: str, progress: Progress = no_progress
) -> tuple[Path, ...]:
    """Write index.html, result.json, estimates.csv and table.md on all, and each member's report, all or none.

    Parameters and exceptions as of `write_fit_report`.
    """
    origin = apart_provenance(study, command)
    files = {
        "result.json": apart_result_json(study, origin),
        "estimates.csv": apart_estimates_csv(study),
        "table.md": apart_table(study),
        "index.html": apart_page(study, origin),
    }
    for member in study.members:
        own = fit_files(member.study, parameters, command=command, progress=progress)
        files |= {f"{member.folder}/{name}": text for name, text in own.items()}
    return write_files_atomically(folder, files)


def apart_page(study: ApartStudy, origin: FitProvenance) -> str:
    """Render the page on all members, self-contained but for links to their own pages."""
    environment = template_environment()
    figures = apart_figures(study)
    return environment.get_template("apart.html").render(
        css=the_css(environment),
        study=study,
        origin=origin,
        figures=figures,
        numbers={name: k for k, name in enumerate(figures, start=1)},
        level=f"{100 * study.level:g}",
        noun=study.by,
        effects=effect_rows(study.group),
        kinds=apart_tables.heads(study),
        estimates=apart_tables.estimate_rows(study),
        margins=apart_tables.margin_rows(study),
        recovery=apart_tables.recovery_words(study),
        sentences=group_sentences(study.group),
        recordings=sum(len(member.study.recordings) for member in study.members),
        paper=apart_table(study),
    )

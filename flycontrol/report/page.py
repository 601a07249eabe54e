"""The stability report of a fly's yaw loop: study it, then write index.html and result.json."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from flycontrol.identify.flight import FlightAnalysis
from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.model.parameters import CERTAINTIES, Parameters
from flycontrol.model.references import Reference, cite, references
from flycontrol.model.study import StabilityStudy, study
from flycontrol.report import tables
from flycontrol.report.chain import loop_chain
from flycontrol.report.fitted import FittedFrom
from flycontrol.report.flight import FlightPart, flight_part
from flycontrol.report.nominal import dampings, pulse_task, yaw_loop
from flycontrol.report.page_figures import page_figures
from flycontrol.report.provenance import Provenance, provenance
from flycontrol.report.result import result_json
from flycontrol.report.verdict import proportional_sentence, verdict

_LABELS = {"review": "the review", "flycontrol": "this package"}  #: of references without authors
_FIGURES = (
    "diagram", "bode", "nyquist", "budget", "gain-locus", "delay-locus", "chart", "recoveries", "strength", "damping",
    "flight-wings", "flight-turning", "flight-angles",
)  # fmt: skip
_OF_A_FIT = ("fit", "fixed")  #: certainties
_FIXED_TABLES = 6  #: tables before those on a flight


def write_report(
    parameters: Parameters,
    analysis: FlightAnalysis | None,
    folder: Path,
    *,
    command: str,
    progress: Progress = no_progress,
) -> None:
    """Study the yaw loop of a fly and write index.html and result.json, both or none.

    Parameters
    ----------
    parameters
        Of the fly and its nominal experiment.
    analysis
        What a recorded flight says; None leaves that part out.
    folder
        Where the two files go.
    command
        That made this report, as it shall stand in its provenance.
    progress
        Told after every part.

    Raises
    ------
    OutputError
        If the files cannot be written; earlier ones stay as they were.
    """
    found = study(
        yaw_loop(parameters),
        pulse_task(parameters),
        dampings(parameters),
        deadline=parameters.deadline.value,
        progress=progress,
    )
    origin = provenance(parameters, command, analysis)
    files = {
        "index.html": page(found, parameters, origin, analysis),
        "result.json": result_json(found, parameters, origin, analysis),
    }
    write_files_atomically(folder, files)


def page(
    found: StabilityStudy,
    parameters: Parameters,
    origin: Provenance,
    analysis: FlightAnalysis | None = None,
    fitted: FittedFrom | None = None,
) -> str:
    """Render the whole report as one self-contained HTML page; `fitted` if the fly's numbers come from a fit."""
    frequency = parameters.wingbeat_frequency.value
    gamma = parameters.paddling_gain
    chain = loop_chain(found.result.loop, frequency, None if gamma is None else gamma.value)
    flight = None if analysis is None else flight_part(analysis)
    figures = page_figures(found, chain, frequency) | ({} if flight is None else flight.figures)
    parameter_rows = tables.parameter_rows(parameters)
    cited = _references(parameter_rows, flight)
    environment = template_environment()
    return environment.get_template("page.html").render(
        css=the_css(environment),
        parameters=parameters,
        origin=origin,
        said=verdict(found, parameters),
        reason=found.result.reason,
        proportional=proportional_sentence(found, parameters),
        figures=figures,
        numbers=_numbered([name for name in _FIGURES if name in figures or name == "diagram"]),
        table=_table_numbers(flight),
        links=tables.link_rows(chain),
        parameter_rows=parameter_rows,
        derived_rows=tables.derived_rows(found, parameters, chain),
        certainties=_certainties(parameter_rows),
        fitted=fitted,
        mode_rows=tables.mode_rows(found),
        damping_rows=tables.damping_rows(found),
        pade_rows=tables.pade_rows(found),
        exact_pole=tables.exact_pole(found),
        exact_error=tables.exact_error(found),
        delay_check=tables.delay_check(found),
        chart_check=tables.chart_check(found),
        poles_check=tables.poles_check(found),
        labels={reference.key: _LABELS.get(reference.key, reference.label) for reference in cited},
        references=cited,
        flight=flight,
    )


def _certainties(rows: list[tables.ParameterRow]) -> dict[str, str]:
    """Legend of the certainties: those of files always, those of a fit where they occur."""
    found = {row.certainty for row in rows}
    return {key: words for key, words in CERTAINTIES.items() if key not in _OF_A_FIT or key in found}


def _references(rows: list[tables.ParameterRow], flight: FlightPart | None) -> list[Reference]:
    """Every reference that the page cites, in order of appearance."""
    keys = ["review", *[row.source for row in rows if row.source]]
    if flight is not None and flight.notes.get("source") in references():
        keys.append(flight.notes["source"])
    return [cite(key) for key in dict.fromkeys(keys)]


def _numbered(names: list[str]) -> dict[str, int]:
    return {name: number for number, name in enumerate(names, start=1)}


def _table_numbers(flight: FlightPart | None) -> dict[str, int]:
    """Numbers of the tables from the flight's on; those before it never change."""
    present = [] if flight is None else ["plant"]
    present += ["turns"] if flight is not None and flight.turns else []
    present += ["conventions"] if flight is not None and flight.conventions else []
    return {name: _FIXED_TABLES + number for name, number in _numbered([*present, "pade", "provenance"]).items()}


def template_environment() -> Environment:
    """Where the templates of all pages are; a name that a template lacks is an error."""
    return Environment(
        loader=PackageLoader("flycontrol.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip


def the_css(environment: Environment) -> str:
    """The style sheet that every page carries in itself."""
    assert environment.loader is not None
    return environment.loader.get_source(environment, "style.css")[0]

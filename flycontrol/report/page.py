"""The stability report of a fly's yaw loop: study it, then write index.html and result.json."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.model.parameters import CERTAINTIES, Parameters
from flycontrol.model.references import cite
from flycontrol.model.study import StabilityStudy, study
from flycontrol.report import tables
from flycontrol.report.chain import loop_chain
from flycontrol.report.nominal import dampings, pulse_task, yaw_loop
from flycontrol.report.page_figures import page_figures
from flycontrol.report.provenance import Provenance, provenance
from flycontrol.report.result import result_json
from flycontrol.report.verdict import proportional_sentence, verdict

if TYPE_CHECKING:
    from flycontrol.identify.flight import FlightAnalysis

_LABELS = {"review": "the review", "flycontrol": "this package"}  #: of references without authors
_ORDER = ("diagram", "bode", "nyquist", "budget", "gain-locus", "delay-locus", "recoveries", "strength", "damping")


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
    found = study(yaw_loop(parameters), pulse_task(parameters), dampings(parameters), progress=progress)
    recording = None if analysis is None else analysis.recording
    origin = provenance(
        parameters,
        command,
        None if recording is None else recording.name,
        None if recording is None else recording.source_sha256,
    )
    files = {"index.html": page(found, parameters, origin), "result.json": result_json(found, parameters, origin)}
    write_files_atomically(folder, files)


def page(found: StabilityStudy, parameters: Parameters, origin: Provenance, flight: Any = None) -> str:
    """Render the whole report as one self-contained HTML page."""
    chain = loop_chain(found.result.loop, parameters.wingbeat_frequency.value)
    figures = page_figures(found, chain, parameters.wingbeat_frequency.value)
    drawn = [name for name in _ORDER if name in figures or name == "diagram"]
    parameter_rows = tables.parameter_rows(parameters)
    keys = ["review", *[row.source for row in parameter_rows if row.source]]
    references = [cite(key) for key in dict.fromkeys(keys)]
    environment = _environment()
    return environment.get_template("page.html").render(
        css=_css(environment),
        parameters=parameters,
        origin=origin,
        said=verdict(found, parameters),
        reason=found.result.reason,
        proportional=proportional_sentence(found, parameters),
        figures=figures,
        numbers={name: k + 1 for k, name in enumerate(drawn)},
        links=tables.link_rows(chain),
        parameter_rows=parameter_rows,
        derived_rows=tables.derived_rows(found, parameters, chain),
        certainties=CERTAINTIES,
        mode_rows=tables.mode_rows(found),
        damping_rows=tables.damping_rows(found),
        pade_rows=tables.pade_rows(found),
        exact_pole=tables.exact_pole(found),
        exact_error=tables.exact_error(found),
        delay_check=tables.delay_check(found),
        labels={reference.key: _LABELS.get(reference.key, reference.label) for reference in references},
        references=references,
        flight=flight,
    )


def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("flycontrol.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip


def _css(environment: Environment) -> str:
    assert environment.loader is not None
    return environment.loader.get_source(environment, "style.css")[0]

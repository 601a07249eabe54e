"""`flycontrol validate`: every analysis run, and each claim of the review beside what they find, on one page."""

from __future__ import annotations

import os
import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flycontrol.cli.terminal import WorkInterruptedError, progress_bar, say
from flycontrol.errors import InvalidInputError

if TYPE_CHECKING:
    from flycontrol.io.analyses import Analyses, Analysis
    from flycontrol.jobs.progress import Progress
    from flycontrol.jobs.scripts import Script, ScriptEnd
    from flycontrol.report.validation import Finding

INCOMPLETE = 1
_KINDS = {"note": ".md", "figure": ".svg", "numbers": ".json"}


@dataclass(frozen=True, slots=True)
class _Measurements:
    """The folder of real measurements; absolute, for processes that look from elsewhere."""

    folder: Path | None  #: None if none was named
    names: tuple[str, ...]  #: of the folders in it; none if it is not there
    sha256: str  #: over all files; empty if there are none


def validate(
    out: Annotated[
        str, typer.Option(metavar="DIR", help="Folder for index.html, result.json and the analyses' own reports.")
    ] = "reports/validation",
    analyses: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder of the analyses, one Python file a question.")
    ] = Path("analyses"),
    data: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", envvar="FLYCONTROL_DATA", help="Real measurements; left out: where validation.toml says."
        ),
    ] = None,
    reports: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for the analyses' own reports, if not that of --out.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, metavar="NUMBER", help="Analyses at a time; left out: one on every core.")
    ] = None,
    limit: Annotated[
        float, typer.Option(min=0.01, metavar="MINUTES", help="An analysis that takes longer is ended and has failed.")
    ] = 60.0,
) -> None:
    """Run every analysis and put each claim of the review beside what it finds, those that fail too.

    Finished analyses are kept: an interrupted run goes on, a repeated one runs only what has changed. What an earlier
    run wrote for an analysis that fails now, or is there no more, is removed unless somebody changed it. Exit status
    0: all were run; 1: some could not be, and the page says why; 2: refused.

    Example: flycontrol validate --out reports/validation
    """
    from flycontrol.io.analyses import read_analyses
    from flycontrol.jobs.files import require_writable_folder
    from flycontrol.jobs.processes import ProcessPool
    from flycontrol.jobs.scripts import forget_other_scripts, run_scripts

    started = time.perf_counter()
    if not out.strip():
        raise InvalidInputError("--out is empty; name a folder such as reports/validation.")
    folder = Path(out)
    found = read_analyses(analyses)
    measured = _measurements(data, found)
    own = folder if reports is None else reports
    for place in (folder, own):
        require_writable_folder(place)
    scripts = _scripts(found, own, measured)
    environment = {} if measured.folder is None else {"FLYCONTROL_DATA": str(measured.folder)}
    kept = folder / "kept"
    with progress_bar() as progress, _kept_when_interrupted(kept):
        ends = run_scripts(
            scripts, kept, at_once=ProcessPool(workers).count, environment=environment, limit=60.0 * limit,
            progress=_told(progress),
        )  # fmt: skip
    forget_other_scripts(kept, {analysis.name for analysis in found.analyses} | set(found.left_out), own)
    failures = _reported(found, ends, own, folder, measured)
    run = sum(not end.kept for end in ends)
    say(
        f"wrote {folder / 'index.html'} and result.json from {len(ends)} analyses, {run} of them run now, in "
        f"{time.perf_counter() - started:.1f} s"
    )
    for failure in failures:
        say(failure)
    if logs := [f"{end.name}.log" for end in ends if end.failure]:
        say(f"what analyses that did not finish said, the end of it, is in {kept}: {', '.join(logs)}")
    if failures:
        raise typer.Exit(INCOMPLETE)


def _told(progress: Progress) -> Progress:
    """Progress for those who watch, and a line an analysis for those who read a log."""
    from rich.console import Console

    watched = Console(stderr=True).is_terminal

    def told(done: int, total: int, what: str) -> None:
        progress(done, total, what)
        if not watched:
            say(
                f"{done} of {total} analyses are finished; at work: {what}" if done < total else f"{total} are finished"
            )

    return told


def _measurements(asked: Path | None, found: Analyses) -> _Measurements:
    """Look at the folder that was asked for, which must be there, or the one that the settings name."""
    from flycontrol.jobs.digest import digest_of, files_below

    if asked is not None and not asked.is_dir():
        raise InvalidInputError(
            f"--data or FLYCONTROL_DATA: {asked} is no folder; name that of the real measurements, or leave it out."
        )
    folder = found.data if asked is None else asked.resolve()
    files = {} if folder is None else files_below(folder)
    names = tuple(sorted({name.partition("/")[0] for name in files if "/" in name}))
    return _Measurements(folder, names, digest_of(files) if files else "")


def _scripts(found: Analyses, reports: Path, measured: _Measurements) -> list[Script]:
    """The analyses as scripts, known by all that they depend on."""
    import json

    from flycontrol.jobs.digest import digest_of, files_below
    from flycontrol.jobs.scripts import Script
    from flycontrol.report.validation_provenance import validation_provenance

    package = Path(__file__).resolve().parents[1]
    common = {
        "package": digest_of(files_below(package, besides=("__pycache__", "cli", "templates"))),
        "data": measured.sha256,
        "versions": validation_provenance("").versions,
    }

    def identity(analysis: Analysis) -> str:
        sources = digest_of({path.name: path for path in analysis.sources})
        return json.dumps(common | {"sources": sources}, sort_keys=True)

    return [Script(a.path, reports / a.name, identity(a)) for a in found.analyses]


def _reported(found: Analyses, ends: list[ScriptEnd], reports: Path, out: Path, measured: _Measurements) -> list[str]:
    """Write page and result; return what went wrong, a sentence an analysis."""
    from flycontrol.report.validation import Validation
    from flycontrol.report.validation_page import write_validation_report

    findings = [
        _finding(analysis, end, reports, out, measured.folder)
        for analysis, end in zip(found.analyses, ends, strict=True)
    ]
    validation = Validation(
        findings=tuple(sorted(findings, key=lambda finding: finding.name)),
        left_out=found.left_out,
        data=measured.names,
        data_sha256=measured.sha256,
    )
    write_validation_report(validation, out, command="flycontrol validate")
    said = {end.name: end.failure for end in ends}  # names real places, unlike the page
    return [f"{one.name} gave no result: {said[one.name] or one.failure}" for one in validation.failed]


def _finding(analysis: Analysis, end: ScriptEnd, reports: Path, out: Path, data: Path | None) -> Finding:
    """What an analysis states, or why it states nothing."""
    from flycontrol.io.claims import read_claims, refuse_misplaced_claims
    from flycontrol.report.validation import Finding

    folder, claims = reports / analysis.name, ()
    failure = _without_places(end.failure, data, analysis.path.parent)
    if failure and folder.is_dir() and any(path.is_file() for path in folder.rglob("*")):
        failure += " (What lies in its folder is not of this run.)"
    links = {} if failure else _links(folder, analysis.name, out)
    if not failure:
        try:
            claims = read_claims(folder / f"{analysis.name}.json") or ()
            refuse_misplaced_claims(folder, analysis.name)
        except InvalidInputError as error:
            failure = str(error)
    return Finding(name=analysis.name, question=analysis.question, claims=claims, links=links, failure=failure)


def _links(folder: Path, name: str, out: Path) -> dict[str, str]:
    """What an analysis wrote, by kind, as seen from the page."""
    paths = {kind: folder / f"{name}{ending}" for kind, ending in _KINDS.items()}
    here = out.resolve()
    return {
        kind: Path(os.path.relpath(path.resolve(), here)).as_posix() for kind, path in paths.items() if path.is_file()
    }


def _without_places(failure: str, data: Path | None, folder: Path) -> str:
    """A page names no machine and no user."""
    if data is not None:
        failure = failure.replace(f"{data}{os.sep}", "FLYCONTROL_DATA/")
        failure = failure.replace(str(data), "the folder of real measurements")
    return failure.replace(str(folder.resolve()), folder.name)


@contextmanager
def _kept_when_interrupted(folder: Path) -> Generator[None]:
    """Say what an interruption leaves."""
    try:
        yield
    except KeyboardInterrupt:
        raise WorkInterruptedError(
            f"finished analyses are kept, and noted in {folder}; the same command goes on from there."
        ) from None

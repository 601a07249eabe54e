"""The report of a fit: its page, the stability report of the fitted fly, result.json, estimates.csv and a table."""

from __future__ import annotations

import math
import platform
from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

from flycontrol.errors import UnstableSystemError
from flycontrol.identify.gains.design import said_together
from flycontrol.identify.gains.result import Estimate, FitResult
from flycontrol.identify.gains.study import FitStudy
from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.model.parameters import Parameters, Sourced
from flycontrol.model.study import study as stability_study
from flycontrol.model.trial import Pulse
from flycontrol.report.fit import tables as fit_tables
from flycontrol.report.fit.figures import fit_figures
from flycontrol.report.fit.result import FitProvenance, estimates_csv, fit_result_json
from flycontrol.report.fit.words import KINDS, differing_flies, digits_for, estimate_rows, in_symbols, paper_table
from flycontrol.report.fitted import fitted_from
from flycontrol.report.nominal import dampings, pulse_task, yaw_loop
from flycontrol.report.numbers import counted, fixed, sentence
from flycontrol.report.page import page as stability_page
from flycontrol.report.page import template_environment, the_css
from flycontrol.report.provenance import Provenance

_MADE_WITH = ("flycontrol", "numpy", "scipy", "numba", "matplotlib")
FIGURES = ("recordings", "residuals", "profiles", "ridge", "cloud", "strength", "flies", "single", "paddling")
#: Fields of `Parameters` that a fit replaces.
_FITTED = {"proportional_gain": "kp", "derivative_gain": "kd", "delay": "delay"}


def fit_provenance(study: FitStudy, command: str) -> FitProvenance:
    """What the report was made from and with: no clock, no machine, no user."""
    notes = study.recordings[0].trial.notes
    return FitProvenance(
        command=command,
        mapping=notes.get("mapping"),
        mapping_sha256=notes.get("mapping_sha256"),
        versions={"Python": platform.python_version()} | {name: version(name) for name in _MADE_WITH},
        seed=study.seed,
    )


def write_fit_report(
    study: FitStudy, parameters: Parameters, folder: Path, *, command: str, progress: Progress = no_progress
) -> tuple[Path, ...]:
    """Write index.html, stability.html, result.json, estimates.csv and table.md, all or none.

    Parameters
    ----------
    study
        What was fitted.
    parameters
        Of the fly, for what yaw alone cannot tell: inertia, wingbeat frequency, the nominal experiment.
    folder
        Where the files go.
    command
        That made this report, as it shall stand in its provenance.

    Raises
    ------
    OutputError
        If the files cannot be written; earlier ones stay as they were.
    """
    return write_files_atomically(folder, fit_files(study, parameters, command=command, progress=progress))


def fit_files(
    study: FitStudy, parameters: Parameters, *, command: str, progress: Progress = no_progress
) -> dict[str, str]:
    """Contents of what `write_fit_report` writes, by name."""
    origin = fit_provenance(study, command)
    files = {
        "result.json": fit_result_json(study, origin),
        "estimates.csv": estimates_csv(study),
        "table.md": paper_table(study),
    }
    fly = fitted_fly(study, parameters)
    stability = None if fly is None else _stability(fly, study, origin, progress)
    if stability is not None:
        files["stability.html"] = stability
    progress(0, 1, "drawing the page of the fit")
    files["index.html"] = fit_page(study, origin, with_stability=stability is not None)
    return files


def fit_page(study: FitStudy, origin: FitProvenance, *, with_stability: bool) -> str:
    """Render the page of the fit, self-contained."""
    environment = template_environment()
    figures = fit_figures(study)
    return environment.get_template("fit.html").render(
        css=the_css(environment),
        study=study,
        result=study.result,
        origin=origin,
        figures=figures,
        numbers={name: k for k, name in enumerate([f for f in FIGURES if f in figures], start=1)},
        rows=estimate_rows(study.result),
        own_rows=estimate_rows(study.result, of_the_loop=False),
        tables=_table_numbers(study),
        level=f"{100 * study.result.level:g}",
        consequences=fit_tables.consequence_rows(study),
        trade_offs=[sentence(in_symbols(each)) for each in said_together(study.trade_offs[:4])],
        status=sentence(in_symbols(study.result.status)),
        controllers=fit_tables.controller_rows(study),
        predictions=fit_tables.prediction_rows(study),
        effects=[] if study.flies is None else fit_tables.effect_rows(study.flies),
        fly_sentences=fit_tables.group_sentences(study.flies),
        recording_sentences=fit_tables.group_sentences(study.single),
        paper=paper_table(study),
        differing=differing_flies(study),
        flies=len({recording.trial.fly for recording in study.recordings}),
        with_stability=with_stability,
    )


def _table_numbers(study: FitStudy) -> dict[str, int]:
    """Numbers of the tables that are there."""
    there = {
        "estimates": True, "consequences": bool(fit_tables.consequence_rows(study)),
        "controllers": study.comparison is not None, "effects": study.flies is not None and bool(study.flies.effects),
        "predictions": study.single is not None and bool(study.predictions),
    }  # fmt: skip
    return {name: k for k, name in enumerate([name for name, is_there in there.items() if is_there], start=1)}


def fitted_fly(study: FitStudy, parameters: Parameters) -> Parameters | None:
    """The parameters of the fitted fly; None where flies differ in them, or the controller is not P or PD."""
    result = study.result
    if result.controller not in ("P", "PD") or not result.usable or not _is_one_loop(result):
        return None
    inertia = parameters.inertia.value
    fitted = {field: _sourced(result, kind) for field, kind in _FITTED.items()}
    damping = _sourced(result, "damping")
    fitted["damping"] = replace(
        damping,
        value=damping.value * inertia,
        unit="N m s",
        text=f"{damping.value * inertia:.3g} N m s",
        note=f"β/I = {damping.text}, {damping.note}",
    )
    gamma = _fitted_paddling(result, inertia)
    if gamma is not None:
        fitted["paddling_gain"] = gamma
    pulses = [r.trial.perturbation for r in study.recordings if isinstance(r.trial.perturbation, Pulse)]
    if pulses:
        length = pulses[0].duration
        fitted["pulse_duration"] = Sourced(value=length, unit="s", certainty="fixed", note="of the recordings")
    name = f"fly fitted to {counted(len(study.recordings), 'recording')}"
    return replace(parameters, name=name, **fitted)


def _fitted_paddling(result: FitResult, inertia: float) -> Sourced | None:
    """gamma from gamma/I, where all recordings share one that was estimated or fixed; None where it may be anything.

    Paddling lost in its noise leaves gamma open, or of the sign of a fly that turns against its wings.
    """
    if "paddling_gain" not in (*result.problem.names, *result.problem.model.known):
        return None
    said = [e for e in result.estimates if e.name == "paddling_gain"]
    if not result.value("paddling_gain") > 0 or any(math.isinf(e.low) and math.isinf(e.high) for e in said):
        return None
    ratio = _sourced(result, "paddling_gain")
    note = f"γ/I = {ratio.text}, {ratio.note}"
    return replace(
        ratio, value=ratio.value * inertia, unit="N m/rad", text=f"{ratio.value * inertia:.3g} N m/rad", note=note
    )


def _is_one_loop(result: FitResult) -> bool:
    """Whether all recordings share one loop that exists."""
    loop = [e for e in result.estimates if e.kind in ("kp", "kd", "delay", "damping")]
    shared = all(e.name == e.kind for e in loop)
    said = all(math.isfinite(e.low) or math.isfinite(e.high) for e in loop)  # open at both ends: nothing was found
    return shared and said and result.value("damping") > 0 and result.value("delay") > 0


def _sourced(result: FitResult, kind: str) -> Sourced:
    _, _, unit, size = KINDS[kind]
    si = {"kp": "1/s^2", "kd": "1/s", "delay": "s", "damping": "1/s", "paddling_gain": "1/s^2"}[kind]
    found: Mapping[str, Estimate] = {e.name: e for e in result.estimates}
    if kind not in found:
        value = result.value(kind)
        return Sourced(value=value, unit=si, text=f"{value / size:.6g} {unit}", certainty="fixed", note="fixed")
    e = found[kind]
    digits = digits_for(e.standard_error / size, e.value / size)
    ends = f"{fixed(e.low / size, digits)} to {fixed(e.high / size, digits, unit)}"
    note = f"{100 * result.level:g} % interval {ends}"
    return Sourced(value=e.value, unit=si, certainty="fit", text=f"{fixed(e.value / size, digits)} {unit}", note=note)


def _stability(fly: Parameters, study: FitStudy, origin: FitProvenance, progress: Progress) -> str | None:
    """The stability report of the fitted fly; None where its loop cannot be studied."""
    try:
        found = stability_study(
            yaw_loop(fly), pulse_task(fly), dampings(fly), deadline=fly.deadline.value, progress=progress
        )
    except UnstableSystemError:
        return None
    provenance = Provenance(
        command=origin.command,
        parameter_file=f"the estimates of index.html beside this page; for the rest {fly.file}",
        parameter_sha256=fly.sha256,
        defaulted=fly.defaulted,
        recording=f"{counted(len(study.recordings), 'recording')}, names and SHA-256 in result.json",
        recording_sha256=None,
        versions=origin.versions,
        seed=str(origin.seed),
    )
    return stability_page(found, fly, provenance, fitted=fitted_from(study))

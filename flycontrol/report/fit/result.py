"""result.json and estimates.csv of a fit; `FIELDS` says what each field of the first holds."""

from __future__ import annotations

import csv
import io
import json
import math
from dataclasses import asdict, dataclass
from typing import Any

from flycontrol.identify.gains.recording_fits import ChannelFit, RecordingFit
from flycontrol.identify.gains.result import Estimate
from flycontrol.identify.gains.study import FitStudy
from flycontrol.report.fit.surroundings import surroundings
from flycontrol.report.fit.words import owner
from flycontrol.report.result import FIELDS as STABILITY_FIELDS
from flycontrol.report.result import finite
from flycontrol.units import deg

#: Fields of a stability report's result.json that a fit has of its loop, under `stability`.
_OF_THE_LOOP = (
    *("margins.", "modes", "recovery.recovery_time_ms", "recovery.pulse_duration_ms"),
    *("recovery.peak_deg", "recovery.tolerance_deg"),
)
FIELDS: dict[str, str] = {
    "status": "how far the fit can be trusted, in a sentence",
    "usable": "false if the status forbids the use of the estimates: not converged, not identifiable, nothing found",
    "converged": "whether the search ended at a minimum",
    "controller": "P, PD, PI or PID",
    "signal": "what the controller acts on",
    "level": "of all intervals",
    "loss": "of the residuals: linear or huber",
    "deviance": "minus twice the logarithm of the likelihood",
    "samples": "measured, of all channels",
    "fixed.*": "parameters taken for known, in SI units and radians",
    "estimates[].name": "parameter, and in brackets the fly or recording that it belongs to",
    "estimates[].kind": "parameter: kp = K_P/I, kd = K_D/I, ki = K_I/I, damping = beta/I, paddling_gain = gamma/I, ...",
    "estimates[].owner": "fly or recording; empty: all share it",
    "estimates[].unit": "of value, low, high, standard_error and bias",
    "estimates[].value": "corrected for the bias that the model's curvature causes; null: no limit was ever reached",
    "estimates[].low": "low end of the interval; null: open",
    "estimates[].high": "high end of the interval; null: open",
    "estimates[].standard_error": "null: the data do not determine it, or it lies at a bound",
    "estimates[].degrees_of_freedom": "of the interval",
    "estimates[].bias": "that was taken off",
    "estimates[].method": "that gave the interval",
    "estimates[].at_bound": "whether a bound holds it",
    "estimates[].open_because": "why a side of the interval is open",
    "correlation.names[]": "estimates that all recordings share",
    "correlation.matrix[][]": "of their errors; null: not determined",
    "recordings[].name": "of the recording",
    "recordings[].fly": "recordings of one fly share it",
    "recordings[].sha256": "of the file's bytes",
    "recordings[].channels[].kind": "yaw or paddling",
    "recordings[].channels[].samples": "measured",
    "recordings[].channels[].residual_rms_deg": "of measured less fitted",
    "recordings[].channels[].noise_sd_deg": "standard deviation of the noise as modelled",
    "recordings[].channels[].noise_order": "of the autoregressive noise; 0: white",
    "recordings[].channels[].noise_coefficients[]": "e_t = sum of coefficient * e_(t-k) + innovation",
    "trade_offs[]": "which unknowns make up for each other, and what would help",
    "profiles[].name": "unknown that is held",
    "profiles[].values[]": "that it is held at, in SI units",
    "profiles[].deviance[]": "least deviance there, 0 at the minimum",
    "profiles[].threshold": "deviance at the ends of the interval",
    "bootstrap.kind": "parametric: noise drawn from the noise model; block: blocks of residuals",
    "bootstrap.draws": "fits to data drawn anew that converged",
    "bootstrap.failed": "those that did not",
    "bootstrap.intervals[].name": "unknown that all recordings share",
    "bootstrap.intervals[].low": "of the interval at `level`, BCa",
    "bootstrap.intervals[].high": "likewise",
    "bootstrap.intervals[].standard_deviation": "of the draws",
    "controllers.sentence": "which controller describes the recordings best",
    "controllers.noise_order": "the same for all",
    "controllers.rows[].controller": "P, PD, PI or PID on the yaw angle",
    "controllers.rows[].unknowns": "noise included",
    "controllers.rows[].deviance": "minus twice the logarithm of the largest likelihood",
    "controllers.rows[].aicc": "Akaike's criterion, corrected",
    "controllers.rows[].bic": "Schwarz's criterion",
    "controllers.rows[].weight": "Akaike's weight",
    "controllers.rows[].error_deg": "root mean square error of samples left out; null: not asked for",
    "flies.sentences[]": "whether they differ, and which do not go with the others",
    "flies.fits[].name": "fly, or recording, fitted alone",
    "flies.fits[].usable": "converged, everything determined",
    "flies.fits[].values.*": "estimates in SI units",
    "flies.fits[].standard_errors.*": "of them",
    "flies.effects[].kind": "parameter",
    "flies.effects[].mean": "over flies, or recordings, in SI units",
    "flies.effects[].mean_low": "of its interval at `level`",
    "flies.effects[].mean_high": "likewise",
    "flies.effects[].deviation": "standard deviation between flies",
    "flies.effects[].deviation_low": "of its interval",
    "flies.effects[].deviation_high": "null: so few say nothing",
    "flies.effects[].p": "of no spread",
    "recordings_alone.*": "the same of recordings fitted one by one",
    "ridge.names[]": "two unknowns that the data cannot tell apart; null: they can",
    "ridge.units[]": "of their values",
    "ridge.first[]": "values of the first",
    "ridge.second[]": "values of the second",
    "ridge.deviance[][]": "by value of the first, by value of the second: the least deviance, all others fitted",
    "ridge.threshold": "deviance below which the data go along",
    "ridge.open_ends[]": "sides at which they still do",
    "predictions[].trial": "recording predicted from the others",
    "predictions[].error_deg": "root mean square of measured less predicted yaw",
    "predictions[].noise_deg": "standard deviation of its noise",
    "predictions[].in_noise": "error over noise, both one sample ahead; 1 is perfect",
    **{f"stability.{name}": words for name, words in STABILITY_FIELDS.items() if name.startswith(_OF_THE_LOOP)},
    "consequences.draws": "loops drawn from the estimates' distribution",
    "consequences.unstable_share": "of them",
    "consequences.gain_margin.low": "gain margin: of its interval at `level`",
    "consequences.gain_margin.high": "likewise",
    "consequences.phase_margin_deg.low": "phase margin: of its interval at `level`",
    "consequences.phase_margin_deg.high": "likewise",
    "consequences.delay_margin_ms.low": "delay margin: of its interval at `level`",
    "consequences.delay_margin_ms.high": "likewise",
    "consequences.modulus_margin.low": "min |1 + L|: of its interval at `level`",
    "consequences.modulus_margin.high": "likewise",
    "consequences.recovery_time_ms.low": "recovery from the nominal pulse: of its interval at `level`",
    "consequences.recovery_time_ms.high": "likewise",
    "consequences.rightmost_real_per_s.low": "real part of the rightmost pole: of its interval at `level`",
    "consequences.rightmost_real_per_s.high": "likewise",
    "recovery.sentence": "how measured and predicted recovery times agree",
    "recovery.tolerance_deg": "half width of the band around the heading",
    "recovery.measured[].trial": "recording",
    "recovery.measured[].peak_deg": "largest deflection, its sign with it",
    "recovery.measured[].time_ms": "from onset to the last entry into the band; null: not recovered",
    "recovery.measured[].low_ms": "of its interval at `level`",
    "recovery.measured[].high_ms": "null: the recording does not show that the fly is back",
    "recovery.predicted.peak_deg[]": "peak deflections",
    "recovery.predicted.time_ms[]": "by the estimates",
    "recovery.predicted.low_ms[]": "of the band at `level`",
    "recovery.predicted.high_ms[]": "null: unstable draws",
    "absent.*": "why a part is not there",
    "provenance.command": "that made this report",
    "provenance.mapping": "name of the mapping; null: trials given from Python",
    "provenance.mapping_sha256": "of its file",
    "provenance.versions.*": "of Python and the packages that computed",
    "provenance.seed": "of everything drawn at random",
}

COLUMNS = (
    *("name", "kind", "owner", "unit", "value", "low", "high", "level", "standard_error"),
    *("degrees_of_freedom", "bias", "method", "at_bound", "bootstrap_low", "bootstrap_high"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class FitProvenance:
    """Command, mapping by hash, versions, seed."""

    command: str
    mapping: str | None
    mapping_sha256: str | None
    versions: dict[str, str]  #: by package, Python first
    seed: int


def fit_result_json(study: FitStudy, origin: FitProvenance) -> str:
    """Write everything as JSON, keys sorted, floats at full precision; what is not finite is null."""
    return json.dumps(finite(fit_result(study, origin)), indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def fit_result(study: FitStudy, origin: FitProvenance) -> dict[str, Any]:
    """Everything as numbers, texts, lists and dictionaries."""
    result = study.result
    shared = [i for i, e in enumerate(result.estimates) if e.name == e.kind]
    correlation = result.correlation
    return {
        "fields": FIELDS,
        "status": result.status,
        "usable": result.usable,
        "converged": result.converged,
        "controller": result.controller,
        "signal": "yaw angle",
        "level": result.level,
        "loss": result.weighted.loss,
        "deviance": result.deviance,
        "samples": result.problem.samples,
        "fixed": dict(result.problem.model.known),
        "estimates": [estimate_fields(e) for e in result.estimates],
        "correlation": {
            "names": [result.estimates[i].name for i in shared],
            "matrix": [[float(correlation[i, j]) for j in shared] for i in shared],
        },
        "recordings": [_recording(recording) for recording in study.recordings],
        **surroundings(study),
        "absent": dict(study.absent),
        "provenance": asdict(origin),
    }


def estimate_fields(e: Estimate) -> dict[str, Any]:
    """One estimate, numbers unrounded."""
    return {
        "name": e.name,
        "kind": e.kind,
        "owner": owner(e),
        "unit": e.unit,
        "value": e.value,
        "low": e.low,
        "high": e.high,
        "standard_error": e.standard_error,
        "degrees_of_freedom": e.freedom,
        "bias": e.bias,
        "method": e.method,
        "at_bound": e.at_bound,
        "open_because": e.open_because,
    }


def _recording(recording: RecordingFit) -> dict[str, Any]:
    trial = recording.trial
    return {
        "name": trial.name,
        "fly": trial.fly,
        "sha256": trial.source_sha256,
        "channels": [_channel(channel) for channel in recording.channels],
    }


def _channel(channel: ChannelFit) -> dict[str, Any]:
    return {
        "kind": channel.kind,
        "samples": len(channel.measured),
        "residual_rms_deg": channel.rms / deg,
        "noise_sd_deg": channel.noise.standard_deviation / deg,
        "noise_order": channel.noise.order,
        "noise_coefficients": channel.noise.coefficients.tolist(),
    }


def estimates_csv(study: FitStudy) -> str:
    """One row an estimate, columns as `COLUMNS`, SI units and radians; what is not there or not finite is empty."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n", extrasaction="ignore")
    writer.writeheader()
    for e in study.result.estimates:
        row = estimate_fields(e) | {"level": study.result.level} | _bootstrapped(e, study)
        writer.writerow(_written(row))
    return text.getvalue()


def _bootstrapped(e: Estimate, study: FitStudy) -> dict[str, float]:
    """The bootstrap's interval of an unknown that all recordings share."""
    if study.bootstrap is None or e.name != e.kind:
        return {}
    low, high = study.bootstrap.interval(e.name, study.result.level)
    return {"bootstrap_low": low, "bootstrap_high": high}


def _written(row: dict[str, Any]) -> dict[str, Any]:
    return {key: "" if isinstance(value, float) and not math.isfinite(value) else value for key, value in row.items()}

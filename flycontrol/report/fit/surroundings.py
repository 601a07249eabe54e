"""The part of a fit's result.json on what surrounds the fit; `fit_result.FIELDS` says what each field holds."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from flycontrol.identify.gains.bootstrap import Bootstrap
from flycontrol.identify.gains.consequences import Consequences
from flycontrol.identify.gains.profile import Profile
from flycontrol.identify.gains.recovery_band import RecoveryAgainstStrength
from flycontrol.identify.gains.ridge import Ridge
from flycontrol.identify.gains.selection import ControllerComparison
from flycontrol.identify.gains.study import FitStudy, Group
from flycontrol.model.stability import StabilityResult
from flycontrol.report.fit.tables import group_sentences
from flycontrol.report.result import margin_fields, mode_fields
from flycontrol.units import deg, ms


def surroundings(study: FitStudy) -> dict[str, Any]:
    """Fields by part; None for a part that the study has not."""
    return {
        "profiles": [_profile(profile) for profile in study.profiles.values()],
        "bootstrap": None if study.bootstrap is None else _bootstrap(study.bootstrap, study),
        "controllers": None if study.comparison is None else _controllers(study.comparison),
        "flies": None if study.flies is None else group_fields(study.flies),
        "recordings_alone": None if study.single is None else group_fields(study.single),
        "trade_offs": [each.sentence for each in study.trade_offs],
        "ridge": None if study.ridge is None else _ridge(study.ridge),
        "predictions": [
            {"trial": p.trial, "error_deg": p.error / deg, "noise_deg": p.noise / deg, "in_noise": p.in_noise}
            for p in study.predictions
        ],
        "stability": None if study.stability is None else _stability(study.stability),
        "consequences": None if study.consequences is None else _consequences(study.consequences, study.result.level),
        "recovery": None if study.recovery is None else _recovery(study.recovery),
    }


def _profile(profile: Profile) -> dict[str, Any]:
    return {
        "name": profile.name,
        "values": profile.values.tolist(),
        "deviance": profile.deviance.tolist(),
        "threshold": profile.threshold,
    }


def _ridge(found: Ridge) -> dict[str, Any]:
    return {
        "names": list(found.names),
        "units": list(found.units),
        "first": found.first.tolist(),
        "second": found.second.tolist(),
        "deviance": found.deviance.tolist(),
        "threshold": found.threshold,
        "open_ends": list(found.open_ends),
    }


def _bootstrap(found: Bootstrap, study: FitStudy) -> dict[str, Any]:
    shared = [e.name for e in study.result.estimates if e.name == e.kind]
    deviations = np.sqrt(np.diag(found.covariance))
    return {
        "kind": found.kind,
        "draws": len(found.draws),
        "failed": found.failed,
        "intervals": [_interval(found, name, study.result.level, deviations) for name in shared],
    }


def _interval(found: Bootstrap, name: str, level: float, deviations: np.ndarray) -> dict[str, Any]:
    low, high = found.interval(name, level)
    return {"name": name, "low": low, "high": high, "standard_deviation": float(deviations[found.names.index(name)])}


def _controllers(found: ControllerComparison) -> dict[str, Any]:
    names = ("controller", "unknowns", "deviance", "aicc", "bic", "weight")
    return {
        "sentence": found.sentence,
        "noise_order": found.order,
        "rows": [{name: getattr(r, name) for name in names} | {"error_deg": r.error / deg} for r in found.rows],
    }


def group_fields(group: Group) -> dict[str, Any]:
    """Fits one by one, and what is common to them."""
    return {
        "sentences": group_sentences(group),
        "fits": [
            {
                "name": fit.name,
                "usable": fit.usable,
                "values": {kind: fit.estimate(kind) for kind in fit.kinds},
                "standard_errors": {kind: fit.standard_error(kind) for kind in fit.kinds},
            }
            for fit in group.fits
        ],
        "effects": [
            {key: value for key, value in asdict(e).items() if key not in ("unit", "count")} for e in group.effects
        ],
    }


def _consequences(found: Consequences, level: float) -> dict[str, Any]:
    sizes = {
        "gain_margin": ("gain_margin", 1.0),
        "phase_margin": ("phase_margin_deg", deg),
        "delay_margin": ("delay_margin_ms", ms),
        "modulus_margin": ("modulus_margin", 1.0),
        "recovery_time": ("recovery_time_ms", ms),
        "abscissa": ("rightmost_real_per_s", 1.0),
    }
    intervals = {name: [end / size for end in found.interval(key, level)] for key, (name, size) in sizes.items()}
    return {
        "draws": len(found.loops),
        "unstable_share": found.unstable,
        **{name: {"low": low, "high": high} for name, (low, high) in intervals.items()},
    }


def _stability(found: StabilityResult) -> dict[str, Any]:
    seconds = found.recovery_time
    return {
        "margins": margin_fields(found),
        "modes": mode_fields(found),
        "modes_status": found.poles_status,
        "recovery": {
            "recovery_time_ms": None if seconds is None else seconds / ms,
            "pulse_duration_ms": found.task.duration / ms,
            "peak_deg": found.task.peak / deg,
            "tolerance_deg": found.task.tolerance / deg,
        },
    }


def _recovery(found: RecoveryAgainstStrength) -> dict[str, Any]:
    band = found.band
    return {
        "sentence": found.sentence,
        "tolerance_deg": band.tolerance / deg,
        "measured": [
            {
                "trial": r.trial,
                "peak_deg": r.peak / deg,
                "time_ms": r.time / ms,
                "low_ms": r.low / ms,
                "high_ms": r.high / ms,
            }
            for r in found.measured
        ],
        "predicted": {
            "peak_deg": (band.peaks / deg).tolist(),
            "time_ms": (band.times / ms).tolist(),
            "low_ms": (band.low / ms).tolist(),
            "high_ms": (band.high / ms).tolist(),
        },
    }

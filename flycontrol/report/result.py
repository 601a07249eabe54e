"""result.json: every number of the report, unrounded, with its unit in its name.

A number that does not exist is null, and the `reason` beside it says why; NaN and Infinity never appear. `FIELDS` says
what each field holds and is written into the file itself, under `fields`.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

from flycontrol.delay.system import ComplexArray
from flycontrol.identify.flight import FlightAnalysis
from flycontrol.model.gains import ChosenGains
from flycontrol.model.parameters import Parameters
from flycontrol.model.stability import StabilityResult
from flycontrol.model.study import StabilityStudy
from flycontrol.report.chart_result import chart_fields
from flycontrol.report.flight_result import FLIGHT_FIELDS, flight_fields
from flycontrol.report.provenance import Provenance
from flycontrol.report.verdict import verdict
from flycontrol.units import deg, ms

FIELDS: dict[str, str] = {
    "fly": "name of the fly",
    "verdict": "stable or unstable",
    "sentences[]": "the verdict in words",
    "reason": "why margins or recovery are null; null when nothing is missing",
    "parameters.*.value": "SI value",
    "parameters.*.unit": "its unit",
    "parameters.*.text": "as the parameter file writes it",
    "parameters.*.source": "key of references.bib; empty for a user's own value",
    "parameters.*.certainty": "S read in the source, S2 second hand, C calibrated by this package, user: given",
    "parameters.*.note": "what the source says",
    "loop.damping_per_s": "b = beta / I",
    "loop.proportional_gain_per_s2": "K_P / I, positive restores",
    "loop.derivative_gain_per_s": "K_D / I",
    "loop.delay_ms": "T",
    "loop.delay_wingbeats": "T f",
    "margins.gain_margin": "smallest factor > 1 on both gains that reaches the boundary of stability; null: none does",
    "margins.gain_reduction_margin": "largest factor < 1 that does; 0: none does",
    "margins.phase_margin_deg": "smallest lag at a gain crossover that reaches the boundary; null: none does",
    "margins.delay_margin_ms": "smallest further delay that reaches the boundary; null: none does",
    "margins.largest_stable_delay_ms": "delay plus delay margin",
    "margins.modulus_margin": "min |1 + L|",
    "margins.modulus_frequency_rad_per_s": "where; null when only approached at infinite frequency",
    "margins.gain_crossovers_rad_per_s[]": "every frequency with |L| = 1",
    "margins.phase_crossovers_rad_per_s[]": "every frequency with L real and negative, |L| above the floor",
    "margins.phase_crossover_floor": "|L| under which phase crossovers are left out",
    "modes_status": "certified if a count by the argument principle found no other pole as far right as `modes`",
    "modes[].real_per_s": "real part of the pole",
    "modes[].imag_per_s": "imaginary part, >= 0; the conjugate is meant too",
    "modes[].time_constant_ms": "-1 / real part; negative: grows",
    "modes[].frequency_hz": "imaginary part / 2 pi",
    "modes[].damping_ratio": "-real part / |pole|",
    "modes[].error_estimate_per_s": "last Newton step",
    "chart.own.proportional_gain_per_s2": "K_P / I of this loop",
    "chart.own.derivative_gain_per_s": "K_D / I of this loop",
    "chart.own.decay_rate_per_s": "of its slowest mode; negative: grows",
    "chart.fastest_decay.proportional_gain_per_s2": "K_P / I at which the slowest mode decays fastest, closed form",
    "chart.fastest_decay.derivative_gain_per_s": "K_D / I there",
    "chart.fastest_decay.decay_rate_per_s": "there",
    "chart.boundary.frequency_rad_per_s[]": "of the pair on the imaginary axis, around the stable gains; closed form",
    "chart.boundary.proportional_gain_per_s2[]": "K_P / I on the boundary",
    "chart.boundary.derivative_gain_per_s[]": "K_D / I on the boundary",
    "chart.regions[].unstable_roots": "number of roots with positive real part; -1: a root on the imaginary axis",
    "chart.regions[].grid_points": "points of the chart's grid over the gains with so many",
    "chart.grid.proportional_gain_per_s2[]": "lowest and highest K_P / I of that grid",
    "chart.grid.derivative_gain_per_s[]": "lowest and highest K_D / I of that grid",
    "chart.grid.points": "points at which unstable roots were counted, over the gains and over gain and delay",
    "chart.grid.points_agreeing": "points at which the closed form gives the same verdict on stability",
    "chart.delay_slice.gain_factor[]": "common factor on both gains",
    "chart.delay_slice.largest_stable_delay_ms[]": "with the gains times the factor, closed form",
    "recovery.recovery_time_ms": "from pulse onset to the last entry into the band",
    "recovery.recovery_time_wingbeats": "the same times the wingbeat frequency",
    "recovery.pulse_duration_ms": "of the nominal pulse",
    "recovery.pulse_torque_nN_m": "that deflects this loop to peak_deg; null: no such pulse",
    "recovery.peak_deg": "largest deflection of the nominal pulse",
    "recovery.tolerance_deg": "half width of the band",
    "recovery_curve.peak_deg[]": "peak deflection",
    "recovery_curve.recovery_time_ms[]": "recovery time from each peak",
    "recovery_curve.jumps_deg[]": "peaks at which a later swing leaves the band and the time jumps",
    "recovery_curve.swings[]": "sizes of successive extrema of yaw as fractions of the peak",
    "damping_table[].damping_per_s": "beta / I",
    "damping_table[].*.rule": "how the gains were chosen",
    "damping_table[].*.proportional_gain_per_s2": "K_P / I",
    "damping_table[].*.derivative_gain_per_s": "K_D / I",
    "damping_table[].*.recovery_time_ms": "from the nominal pulse",
    "damping_table[].*.recovery_time_nearby_ms": "longest with gains up to 1 % off; null: some are unstable",
    "damping_table[].*.modulus_margin": "min |1 + L|",
    "proportional.deadline_ms": "recovery time that P alone is held against",
    "proportional.suffices_from_per_s": "beta / I at which the best P just meets the deadline; null: not found",
    "cross_checks.largest_stable_delay_closed_form_ms": "by the closed form for PD; null: it does not apply",
    "cross_checks.largest_stable_delay_difference_ms": "margins less closed form",
    "cross_checks.pade[].order": "order of the approximation",
    "cross_checks.pade[].rightmost_real_per_s": "its rightmost pole",
    "cross_checks.pade[].rightmost_imag_per_s": "its rightmost pole",
    "cross_checks.pade[].error_per_s": "distance from the exact rightmost pole",
    "provenance.command": "that made this report",
    "provenance.parameter_file": "name of the file read",
    "provenance.parameter_sha256": "of that file and, where keys were missing, of the default file",
    "provenance.defaulted[]": "keys taken from the default file",
    "provenance.recording": "name of the recording; null: none given",
    "provenance.recording_sha256": "of the recording's file; null: none given",
    "provenance.versions.*": "of Python and the packages that computed",
    "provenance.seed": "of anything drawn at random",
}


def result_json(
    study: StabilityStudy, parameters: Parameters, origin: Provenance, analysis: FlightAnalysis | None = None
) -> str:
    """Write everything as JSON, keys sorted, floats at full precision.

    Parameters
    ----------
    analysis
        Of a real flight, added under `flight`; None when no recording was given.
    """
    said = verdict(study, parameters)
    found: dict[str, Any] = {
        "fields": FIELDS | (FLIGHT_FIELDS if analysis is not None else {}),
        "fly": parameters.name,
        "verdict": said.word,
        "sentences": list(said.sentences),
        "reason": study.result.reason,
        "parameters": {name: _parameter(number) for name, number in parameters.sourced().items()},
        "loop": _loop(study, parameters),
        "margins": margin_fields(study.result),
        "modes": mode_fields(study.result),
        "modes_status": study.result.poles_status,
        "chart": chart_fields(study),
        "recovery": _recovery(study, parameters),
        "recovery_curve": _curve(study),
        "damping_table": [
            {
                "damping_per_s": row.b,
                "proportional": _gains(row.proportional),
                "proportional_derivative": _gains(row.derivative),
            }
            for row in study.damping_table
        ],
        "proportional": {
            "deadline_ms": study.deadline / ms,
            "suffices_from_per_s": study.proportional_suffices_from,
        },
        "cross_checks": _cross_checks(study),
        "provenance": asdict(origin),
    }
    if analysis is not None:
        found["flight"] = flight_fields(analysis)
    return json.dumps(finite(found), indent=1, sort_keys=True, allow_nan=False, ensure_ascii=False) + "\n"


def finite(value: Any) -> Any:
    """Replace every number that is not finite by None, at any depth."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if isinstance(value, bool | str | int) or value is None:
        return value
    number = float(value)
    return number if math.isfinite(number) else None


def _parameter(number: Any) -> dict[str, Any]:
    return {name: getattr(number, name) for name in ("value", "unit", "text", "source", "certainty", "note")}


def _loop(study: StabilityStudy, parameters: Parameters) -> dict[str, float]:
    loop = study.result.loop
    return {
        "damping_per_s": loop.plant.damping_rate,
        "proportional_gain_per_s2": loop.kp,
        "derivative_gain_per_s": loop.kd,
        "delay_ms": loop.delay / ms,
        "delay_wingbeats": parameters.delay_in_wingbeats,
    }


def margin_fields(result: StabilityResult) -> dict[str, Any] | None:
    """Margins of a loop; None if it is unstable."""
    margins = result.margins
    if margins is None:
        return None
    return {
        "gain_margin": margins.gain_margin,
        "gain_reduction_margin": margins.gain_reduction_margin,
        "phase_margin_deg": margins.phase_margin / deg,
        "delay_margin_ms": margins.delay_margin / ms,
        "largest_stable_delay_ms": (result.loop.delay + margins.delay_margin) / ms,
        "modulus_margin": margins.modulus_margin,
        "modulus_frequency_rad_per_s": margins.modulus_frequency,
        "gain_crossovers_rad_per_s": _list(margins.gain_crossovers),
        "phase_crossovers_rad_per_s": _list(margins.phase_crossovers),
        "phase_crossover_floor": margins.floor,
    }


def mode_fields(result: StabilityResult) -> list[dict[str, float]]:
    """Modes, slowest first; a pair counts as one."""
    errors = [float(e) for root, e in zip(result.poles, result.pole_errors, strict=True) if root.imag >= 0]
    return [
        {
            "real_per_s": mode.root.real,
            "imag_per_s": mode.root.imag,
            "time_constant_ms": mode.time_constant / ms,
            "frequency_hz": mode.frequency,
            "damping_ratio": mode.damping_ratio,
            "error_estimate_per_s": error,
        }
        for mode, error in zip(result.modes, errors, strict=True)
    ]


def _recovery(study: StabilityStudy, parameters: Parameters) -> dict[str, Any]:
    result = study.result
    seconds = result.recovery_time
    return {
        "recovery_time_ms": None if seconds is None else seconds / ms,
        "recovery_time_wingbeats": None if seconds is None else seconds * parameters.wingbeat_frequency.value,
        "pulse_duration_ms": result.task.duration / ms,
        "pulse_torque_nN_m": None if result.pulse is None else result.pulse.torque * 1e9,
        "peak_deg": result.task.peak / deg,
        "tolerance_deg": result.task.tolerance / deg,
    }


def _curve(study: StabilityStudy) -> dict[str, Any] | None:
    curve = study.curve
    if curve is None:
        return None
    return {
        "peak_deg": _list(curve.peaks / deg),
        "recovery_time_ms": _list(curve.times / ms),
        "jumps_deg": _list(curve.jumps / deg),
        "swings": _list(curve.swings),
    }


def _gains(chosen: ChosenGains) -> dict[str, Any]:
    return {
        "rule": chosen.rule,
        "proportional_gain_per_s2": chosen.kp,
        "derivative_gain_per_s": chosen.kd,
        "recovery_time_ms": chosen.recovery_time / ms,
        "recovery_time_nearby_ms": chosen.nearby / ms,
        "modulus_margin": chosen.modulus_margin,
    }


def _cross_checks(study: StabilityStudy) -> dict[str, Any]:
    closed, margins = study.closed_form_largest_delay, study.result.margins
    numeric = None if margins is None else study.result.loop.delay + margins.delay_margin
    return {
        "largest_stable_delay_closed_form_ms": None if closed is None else closed / ms,
        "largest_stable_delay_difference_ms": (None if closed is None or numeric is None else (numeric - closed) / ms),
        "pade": [
            {
                "order": order,
                "rightmost_real_per_s": float(poles[0].real),
                "rightmost_imag_per_s": float(poles[0].imag),
                "error_per_s": pade_error(study, poles),
            }
            for order, poles in sorted(study.pade_poles.items())
        ],
    }


def pade_error(study: StabilityStudy, poles: ComplexArray) -> float:
    """Distance of a Pade loop's rightmost pole from the exact one [1/s], both in the upper half plane."""
    exact, other = complex(study.result.poles[0]), complex(poles[0])
    return abs(complex(exact.real, abs(exact.imag)) - complex(other.real, abs(other.imag)))


def _list(values: Iterable[float]) -> list[float]:
    return [float(value) for value in values]

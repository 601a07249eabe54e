"""The part of result.json on a real flight; `FLIGHT_FIELDS` says what each field holds."""

from __future__ import annotations

from typing import Any

from flycontrol.identify.conventions import SignTest
from flycontrol.identify.flight import FlightAnalysis
from flycontrol.identify.yaw_plant import Estimate, YawPlantFit
from flycontrol.model.turn import PaddlingTurn
from flycontrol.units import deg, ms

FLIGHT_FIELDS: dict[str, str] = {
    "flight.name": "of the recording",
    "flight.status": "how well Eq. 3 explains this flight, in a sentence",
    "flight.sentences[]": "everything found, in words",
    "flight.notes.*": "what the mapping says of the recording",
    "flight.wingbeats.count": "whole wingbeats",
    "flight.wingbeats.mean_frequency_hz": "wingbeats over the time they took",
    "flight.wingbeats.mean_wing_speed_rad_per_s": "omega, mean absolute stroke rate",
    "flight.series.time_ms[]": "middle of each wingbeat",
    "flight.series.d_alpha_deg[]": "paddling angle of each wingbeat",
    "flight.series.yaw_rate_rad_per_s[]": "mean about the stroke-plane normal over each wingbeat",
    "flight.d_alpha_noise_deg": "scatter of d_alpha from wingbeat to wingbeat",
    "flight.d_alpha_reliability": "share of d_alpha's variance that is not that scatter",
    "flight.d_alpha_largest_share": "share of d_alpha's variance that one wingbeat holds",
    "flight.plants.*.damping_per_s.*": "beta / I: median, low and high end of the 95 % interval",
    "flight.plants.*.paddling_per_s2_per_rad.*": "gamma / I, likewise; null where d_alpha does not vary",
    "flight.plants.*.turn_gain_per_s.*": "gamma / beta, likewise; null where damping may be zero or gamma is null",
    "flight.plants.*.noise_correlation.*": "from one wingbeat to the next, likewise",
    "flight.plants.*.r2_acceleration": "share of the acceleration's variance explained at the estimates",
    "flight.plants.*.r2_acceleration_best": "the most that any coefficients could explain",
    "flight.plants.*.r2_simulated": "share of the yaw rate's variance, simulated from the paddling alone",
    "flight.blade_elements.damping_per_s": "beta / I predicted at the measured mean stroke",
    "flight.blade_elements.paddling_per_s2_per_rad": "gamma / I predicted",
    "flight.blade_elements.turn_gain_per_s": "gamma / beta predicted",
    "flight.torque_correlation.*": "predicted against needed torque over the wingbeats, about each axis",
    "flight.conventions[].convention": "what was asked",
    "flight.conventions[].measure": "by which number",
    "flight.conventions[].as_mapped": "the number as the mapping has it",
    "flight.conventions[].turned": "with the convention turned round",
    "flight.conventions[].difference_low": "low end of the 95 % interval of as_mapped - turned",
    "flight.conventions[].difference_high": "high end",
    "flight.conventions[].finding": "supported, contradicted or undetermined",
    "flight.turns[].start_ms": "beginning",
    "flight.turns[].end_ms": "end",
    "flight.turns[].wingbeats": "how many",
    "flight.turns[].complete": "begins and ends at low yaw rate inside the recording",
    "flight.turns[].measured_deg": "integral of the yaw rate about the stroke-plane normal",
    "flight.turns[].by_wing_speed_deg": "omega times the integral of d_alpha, Eq. 5",
    "flight.turns[].by_wing_speed_trimmed_deg": "the same of d_alpha less the flight's median",
    "flight.turns[].by_plant_deg": "gamma/beta times the integral of d_alpha; null where beta <= 0",
    "flight.turns[].rate_change_correction_deg": "Eq. 4's last term, to be added; null where beta <= 0",
}


def flight_fields(analysis: FlightAnalysis) -> dict[str, Any]:
    """Return the fields below `flight`, numbers unrounded; those that are not finite become null on writing."""
    found, beats, blades = analysis.turning, analysis.beats, analysis.blade_elements
    inertia = analysis.morphology.yaw_inertia
    plants = {"as_it_stands": found.plant, "with_coupling_to_roll": found.plant_with_coupling}
    return {
        "name": analysis.recording.name,
        "status": found.status,
        "sentences": list(analysis.verdicts),
        "notes": dict(analysis.recording.notes),
        "wingbeats": {
            "count": beats.count,
            "mean_frequency_hz": beats.mean_frequency,
            "mean_wing_speed_rad_per_s": analysis.paddling.mean_wing_speed,
        },
        "series": {
            "time_ms": list(found.time / ms),
            "d_alpha_deg": list(found.d_alpha / deg),
            "yaw_rate_rad_per_s": list(found.yaw_rate),
        },
        "d_alpha_noise_deg": found.d_alpha_noise / deg,
        "d_alpha_reliability": found.d_alpha_reliability,
        "d_alpha_largest_share": found.d_alpha_largest_share,
        "plants": {name: None if fit is None else _plant(fit) for name, fit in plants.items()},
        "blade_elements": None if blades is None else {
            "damping_per_s": blades.damping / inertia,
            "paddling_per_s2_per_rad": blades.paddling / inertia,
            "turn_gain_per_s": blades.turn_gain,
        },
        "torque_correlation": None if analysis.torque is None else dict(
            zip(("roll", "pitch", "yaw"), analysis.torque.correlation, strict=True)
        ),
        "conventions": [] if analysis.conventions is None else [_test(test) for test in analysis.conventions.tests],
        "turns": [_turn(turn) for turn in found.turns],
    }  # fmt: skip


def _plant(fit: YawPlantFit) -> dict[str, Any]:
    return {
        "damping_per_s": _interval(fit.damping),
        "paddling_per_s2_per_rad": _interval(fit.paddling),
        "turn_gain_per_s": _interval(fit.turn_gain),
        "noise_correlation": _interval(fit.noise_correlation),
        "r2_acceleration": fit.r2_acceleration,
        "r2_acceleration_best": fit.r2_acceleration_best,
        "r2_simulated": fit.r2_simulated,
    }


def _interval(estimate: Estimate | None) -> dict[str, float | None]:
    ends = ("value", "low", "high")
    return {end: None if estimate is None else getattr(estimate, end) for end in ends}


def _test(test: SignTest) -> dict[str, Any]:
    names = ("convention", "measure", "as_mapped", "turned", "difference_low", "difference_high", "finding")
    return {name: getattr(test, name) for name in names}


def _turn(turn: PaddlingTurn) -> dict[str, Any]:
    return {
        "start_ms": turn.start / ms,
        "end_ms": turn.end / ms,
        "wingbeats": turn.wingbeats,
        "complete": turn.complete,
        "measured_deg": turn.angle / deg,
        "by_wing_speed_deg": turn.by_wing_speed / deg,
        "by_wing_speed_trimmed_deg": turn.by_wing_speed_trimmed / deg,
        "by_plant_deg": turn.by_plant / deg,
        "rate_change_correction_deg": turn.rate_change_correction / deg,
    }

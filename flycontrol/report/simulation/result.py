"""result.json of a simulated flight; `FIELDS` says what each field holds."""

from __future__ import annotations

import csv
import io
import json
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from flycontrol.flight.experiment_ensemble import ANGLES, FlownEnsemble
from flycontrol.flight.flight_record import FlightRecord
from flycontrol.flight.heading import nose_heading
from flycontrol.flight.quasi_steady import TERMS
from flycontrol.model.flight_experiment import FlightExperiment
from flycontrol.report.result import finite
from flycontrol.units import deg, mm, ms

_MADE_WITH = ("flycontrol", "numpy", "scipy", "numba", "matplotlib", "h5py", "pillow")

FIELDS: dict[str, str] = {
    "name": "of the experiment",
    "status": "complete, or a sentence that says at which wingbeat the flight stopped and why",
    "wingbeats": "whole ones flown",
    "fly.species": "of the morphology",
    "fly.mass_mg": "whole fly, wings included",
    "fly.wing_length_mm": "hinge to tip",
    "fly.mean_chord_mm": "area of one wing over its length",
    "fly.stroke_plane_angle_deg": "of the stroke plane from the body's long axis",
    "fly.inertia_kg_m2[][]": "of the body without wings about its centre of mass, stroke-plane frame",
    "stroke.frequency_hz": "wingbeats a second, trimmed where a trim moved it",
    "stroke.trimmed.*": "what the trim moved, in SI units and radians",
    "trim.status": "a sentence; null: not trimmed",
    "trim.forward_weights": "net mean force that is left, over the weight",
    "trim.down_weights": "likewise",
    "trim.pitch_weights_wing_lengths": "net mean pitch torque that is left, over weight times wing length",
    "body_free[]": "what may move of the body",
    "air.terms[]": "of the quasi-steady model",
    "air.coefficients": "of lift and drag, by name",
    "air.density_kg_m3": "of the air",
    "pulses[].start_ms": "of a torque from outside",
    "pulses[].duration_ms": "likewise",
    "pulses[].torque_n_m[]": "about forward, right, down of the stroke-plane frame",
    "settings.steps": "Runge-Kutta steps a wingbeat",
    "settings.samples": "stored instants a wingbeat",
    "settings.nodes": "blades a wing",
    "error.step.*": "of the worst wingbeat repeated with half the steps: m, m/s, rad, rad/s, rad",
    "error.step_wingbeat": "which one that is, from 0",
    "error.step_wingbeats[]": "those repeated: the first, the last, where the strongest pulse begins, amid ramps",
    "error.quadrature.*": "of the load, blades against many: over weight, and weight times wing length",
    "mean.force_weights.*[]": "by term, forward, right, down in the stroke plane, over all wingbeats, over the weight",
    "mean.torque_n_m.*[]": "by term, roll, pitch, yaw, likewise",
    "mean.lift_weights.*": "by term, upward in the world, likewise",
    "mean.lift_weights.all": "of all terms",
    "mean.power_uw": "of both hinges",
    "mean.power_w_per_kg": "over the fly's mass",
    "yaw.peak_deg": "farthest from the heading at the beginning, to the right, while tilted by less than 60 deg",
    "yaw.peak_time_ms": "when",
    "yaw.peak_rate_rad_per_s": "fastest mean of a wingbeat about the stroke-plane normal",
    "end.time_ms": "last instant",
    "end.position_mm[]": "ahead, left, up in the world",
    "end.heading_deg": "of the stroke plane's forward axis, to the right",
    "end.nose_heading_deg": "of the nose, which a roll swings sideways, to the right",
    "end.nose_up_deg": "of the stroke plane",
    "end.roll_deg": "right side down",
    "end.velocity_m_per_s[]": "forward, right, down of the stroke-plane frame",
    "beats.phase[]": "middle of each wingbeat, evenly thinned where there are thousands",
    "beats.lift_weights[]": "upward force of the air in the world",
    "beats.yaw_rate_rad_per_s[]": "mean about the stroke-plane normal",
    "beats.power_uw[]": "of both hinges",
    "ensemble.flights": "how many; there only where the experiment has an ensemble",
    "ensemble.complete": "that flew to the end",
    "ensemble.heading_deg[]": "at the end, percentiles 5, 50 and 95 of those",
    "ensemble.nose_up_deg[]": "likewise",
    "ensemble.roll_deg[]": "likewise",
    "files.*": "what lies beside this file",
    "provenance.command": "that made this report",
    "provenance.experiment": "name of the experiment's file",
    "provenance.experiment_sha256": "of its bytes",
    "provenance.versions.*": "of Python and the packages that computed",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightProvenance:
    """Command, input by hash, versions: no clock, no machine, no user."""

    command: str
    experiment: str
    sha256: str
    versions: dict[str, str]


def flight_provenance(experiment: FlightExperiment, command: str) -> FlightProvenance:
    """Gather it."""
    return FlightProvenance(
        command=command,
        experiment=experiment.file,
        sha256=experiment.sha256,
        versions={"Python": platform.python_version()} | {name: version(name) for name in _MADE_WITH},
    )


def simulation_result(
    record: FlightRecord, origin: FlightProvenance, files: Mapping[str, str], ensemble: FlownEnsemble | None = None
) -> dict[str, Any]:
    """All fields, numbers unrounded, None where a number does not exist."""
    planned, asked = record.planned, record.planned.experiment
    fields = {
        "name": asked.name,
        "status": record.status,
        "wingbeats": record.wingbeats,
        "fly": _fly(asked),
        "stroke": {
            "frequency_hz": planned.frequency,
            "trimmed": {} if planned.trim is None else dict(planned.trim.values),
        },
        "trim": _trim(record),
        "body_free": list(asked.free),
        "air": _air(asked),
        "pulses": _pulses(record),
        "settings": {"steps": asked.steps, "samples": asked.samples, "nodes": asked.air.nodes},
        "error": _error(record),
        "mean": _mean(record),
        "yaw": _yaw(record),
        "end": _end(record),
        "beats": _beats(record),
        **({} if ensemble is None else {"ensemble": _ensemble(ensemble)}),
        "files": dict(files),
        "provenance": _provenance(origin),
        "fields": FIELDS,
    }  # fmt: skip
    return finite(fields)


def simulation_result_json(
    record: FlightRecord, origin: FlightProvenance, files: Mapping[str, str], ensemble: FlownEnsemble | None = None
) -> str:
    """The text of result.json."""
    return (
        json.dumps(simulation_result(record, origin, files, ensemble), indent=1, allow_nan=False, ensure_ascii=False)
        + "\n"
    )


def _fly(asked: FlightExperiment) -> dict[str, Any]:
    fly = asked.morphology
    return {
        "species": fly.species,
        "mass_mg": fly.mass / 1e-6,
        "wing_length_mm": fly.wing_length / mm,
        "mean_chord_mm": fly.mean_chord / mm,
        "stroke_plane_angle_deg": fly.stroke_plane_angle / deg,
        "inertia_kg_m2": [list(row) for row in fly.inertia],
    }


def _trim(record: FlightRecord) -> dict[str, Any]:
    trim = record.planned.trim
    if trim is None:
        return dict.fromkeys(("status", "forward_weights", "down_weights", "pitch_weights_wing_lengths"))
    return {
        "status": trim.status,
        "forward_weights": trim.balance.forward,
        "down_weights": trim.balance.down,
        "pitch_weights_wing_lengths": trim.balance.pitch,
    }


def _air(asked: FlightExperiment) -> dict[str, Any]:
    return {
        "terms": list(asked.air.terms),
        "coefficients": asked.air.coefficients,
        "density_kg_m3": asked.air.density,
    }


def _pulses(record: FlightRecord) -> list[dict[str, Any]]:
    return [
        {"start_ms": pulse.start / ms, "duration_ms": pulse.duration / ms, "torque_n_m": list(pulse.torque_S)}
        for pulse in record.planned.plan.pulses
    ]


def _error(record: FlightRecord) -> dict[str, Any]:
    step, quadrature = record.step_error, record.quadrature_error
    return {
        "step": None if step is None else {name: getattr(step, name) for name in type(step).__slots__},
        "step_wingbeat": record.step_error_wingbeat,
        "step_wingbeats": list(record.step_error_wingbeats),
        "quadrature": None
        if quadrature is None
        else {name: getattr(quadrature, name) for name in type(quadrature).__slots__},
    }


def _mean(record: FlightRecord) -> dict[str, Any] | None:
    mean, fly = record.mean, record.planned.experiment.morphology
    if mean is None:
        return None
    lift = mean.lift[0] / fly.weight
    return {
        "force_weights": {term: list(mean.force_S[0, k] / fly.weight) for k, term in enumerate(TERMS)},
        "torque_n_m": {term: list(mean.torque_S[0, k]) for k, term in enumerate(TERMS)},
        "lift_weights": {term: lift[k] for k, term in enumerate(TERMS)} | {"all": lift.sum()},
        "power_uw": mean.power[0] / 1e-6,
        "power_w_per_kg": mean.power[0] / fly.mass,
    }


def _yaw(record: FlightRecord) -> dict[str, Any]:
    return {
        "peak_deg": record.peak_yaw / deg,
        "peak_time_ms": record.peak_yaw_time / ms,
        "peak_rate_rad_per_s": _largest(record.beats.angular_velocity_S[:, 2]),
    }


def _end(record: FlightRecord) -> dict[str, Any] | None:
    body, angle = record.body, record.planned.experiment.morphology.stroke_plane_angle
    if not len(body.time):
        return None
    return {
        "time_ms": body.time[-1] / ms,
        "position_mm": list(body.position_W[-1] / mm),
        "heading_deg": body.yaw[-1] / deg,
        "nose_heading_deg": nose_heading(body.q_WS, angle)[-1] / deg,
        "nose_up_deg": body.nose_up[-1] / deg,
        "roll_deg": body.roll[-1] / deg,
        "velocity_m_per_s": list(body.velocity_S[-1]),
    }


def _beats(record: FlightRecord) -> dict[str, Any]:
    beats, weight = record.beats, record.planned.experiment.morphology.weight
    return {
        "phase": list(beats.phase),
        "lift_weights": list(beats.lift.sum(axis=1) / weight),
        "yaw_rate_rad_per_s": list(beats.angular_velocity_S[:, 2]),
        "power_uw": list(beats.power / 1e-6),
    }


def _ensemble(ensemble: FlownEnsemble) -> dict[str, Any]:
    complete = np.array([status == "complete" for status in ensemble.status])

    def ends(angles: np.ndarray) -> list[float | None]:
        at_the_end = angles[complete, -1] / deg
        return list(np.percentile(at_the_end, [5, 50, 95])) if len(at_the_end) else [None] * 3

    return {
        "flights": ensemble.flights,
        "complete": int(np.count_nonzero(complete)),
        "heading_deg": ends(ensemble.yaw),
        "nose_up_deg": ends(ensemble.nose_up),
        "roll_deg": ends(ensemble.roll),
    }


def _provenance(origin: FlightProvenance) -> dict[str, Any]:
    return {
        "command": origin.command,
        "experiment": origin.experiment,
        "experiment_sha256": origin.sha256,
        "versions": origin.versions,
    }


def ensemble_csv(ensemble: FlownEnsemble) -> str:
    """One row a flight: how long it flew, and its attitude at the last instant that was kept."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["flight", "wingbeats", "heading_deg", "nose_up_deg", "roll_deg", "status"])
    for k, status in enumerate(ensemble.status):
        last = int(np.flatnonzero(np.isfinite(ensemble.yaw[k]))[-1]) if np.any(np.isfinite(ensemble.yaw[k])) else 0
        angles = [repr(float(getattr(ensemble, name)[k, last] / deg)) for name in ANGLES]
        rows.writerow([k, int(ensemble.wingbeats[k]), *angles, status])
    return text.getvalue()


def _largest(values: np.ndarray) -> float:
    return float(values[int(np.argmax(np.abs(values)))]) if len(values) else 0.0

"""All that a recorded flight says about wings, conventions and turning, in one result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from flycontrol.errors import InvalidInputError
from flycontrol.flight.aerodynamics import QuasiSteadyModel, flight_loads
from flycontrol.flight.yaw_coefficients import YawCoefficients, yaw_coefficients
from flycontrol.identify.conventions import ConventionEvidence, establish_conventions, frame_sentence
from flycontrol.identify.motion import body_motion, required_torque
from flycontrol.identify.turns import TurnIdentification, identify_turns, turn_sentence
from flycontrol.identify.yaw_plant import Estimate, YawPlantFit, explained
from flycontrol.model.morphology import Morphology
from flycontrol.model.paddling import Paddling, paddling
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.stroke import ANGLES, Angle, WingMotion, both_wings, wing_motion
from flycontrol.model.wingbeats import PhaseAverage, Wingbeats, phase_average, segment_wingbeats, wingbeat_mean
from flycontrol.units import deg

FloatArray = NDArray[np.float64]

PHASES = 120  #: points a wingbeat


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueBalance:
    """Torque that the blade elements predict against the one that the measured rotation asks for, frame S."""

    predicted: FloatArray  #: (n, 3) mean over each wingbeat [N m]
    required: FloatArray  #: (n, 3) I w' + w x I w, mean over each wingbeat [N m]
    correlation: tuple[float, float, float]  #: about roll, pitch, yaw
    slope: tuple[float, float, float]  #: least squares of required on predicted, with intercept
    r2_unscaled: tuple[float, float, float]  #: R^2 of predicted + constant, slope 1


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightAnalysis:
    """What a flight says; everything that a figure of it needs."""

    recording: Recording
    morphology: Morphology
    beats: Wingbeats
    left: Mapping[Angle, PhaseAverage]  #: three angles over phase [rad]
    right: Mapping[Angle, PhaseAverage]  #: three angles over phase [rad]
    paddling: Paddling
    conventions: ConventionEvidence | None  #: None where position or attitude were not recorded
    blade_elements: YawCoefficients | None  #: beta and gamma predicted at the measured mean stroke
    torque: TorqueBalance | None  #: None where the body's velocity was not recorded
    turning: TurnIdentification
    verdicts: tuple[str, ...]  #: plain sentences, in reading order


def analyse_flight(
    recording: Recording, morphology: Morphology, model: QuasiSteadyModel | None = None
) -> FlightAnalysis:
    """Wingbeats, phase averages, attack angles, conventions, Eq. 3's plant and Eq. 5's turns of one flight.

    Raises
    ------
    InvalidInputError
        Wing angles or angular velocity are missing, or there are fewer than three wingbeats.
    """
    beats = segment_wingbeats(recording)
    left, right = both_wings(recording)
    paddled = paddling(recording, beats)
    averages = [_averages(wing, recording.time, beats) for wing in (left, right)]
    turning = identify_turns(recording, morphology, beats, paddled)
    conventions, missing = _conventions(recording, morphology, beats, model)
    moving = recording.velocity_S is not None or (recording.position_W is not None and recording.q_WB is not None)
    torque = _torque_balance(recording, morphology, beats, model) if moving else None
    blades = _blade_elements(recording, morphology, averages, beats, model) if moving else None
    return FlightAnalysis(
        recording=recording,
        morphology=morphology,
        beats=beats,
        left=averages[0],
        right=averages[1],
        paddling=paddled,
        conventions=conventions,
        blade_elements=blades,
        torque=torque,
        turning=turning,
        verdicts=(
            _beats_sentence(beats, paddled),
            *(_convention_sentences(conventions) if conventions else [missing]),
            *_plant_sentences(turning, blades, morphology),
            *_limits(turning, torque),
            *[turn_sentence(turn) for turn in turning.turns],
        ),
    )


def _averages(wing: WingAngles, time: FloatArray, beats: Wingbeats) -> dict[Angle, PhaseAverage]:
    return {name: phase_average(getattr(wing, name), time, beats, PHASES) for name in ANGLES}


def _conventions(
    recording: Recording, morphology: Morphology, beats: Wingbeats, model: QuasiSteadyModel | None
) -> tuple[ConventionEvidence | None, str]:
    """Evidence, or the sentence that says which channel it lacks."""
    try:
        return establish_conventions(recording, morphology, beats, model), ""
    except InvalidInputError as error:
        return None, f"Conventions could not be checked: {error}"


def mean_stroke(averages: list[dict[Angle, PhaseAverage]], frequency: float) -> WingMotion:
    """Phase average of both wings together as one periodic stroke with rates, arrays of shape (PHASES,)."""
    angles = {name: 0.5 * (averages[0][name].mean + averages[1][name].mean) for name in ANGLES}
    rates = {name: _periodic_rate(values, frequency) for name, values in angles.items()}
    return WingMotion(
        stroke=angles["stroke"],
        deviation=angles["deviation"],
        pitch=angles["pitch"],
        stroke_rate=rates["stroke"],
        deviation_rate=rates["deviation"],
        pitch_rate=rates["pitch"],
    )


def _periodic_rate(values: FloatArray, frequency: float) -> FloatArray:
    phase = np.arange(len(values) + 1) / len(values)
    spline = CubicSpline(phase, np.append(values, values[0]), bc_type="periodic")
    return spline(phase[:-1], 1) * frequency


def _blade_elements(
    recording: Recording,
    morphology: Morphology,
    averages: list[dict[Angle, PhaseAverage]],
    beats: Wingbeats,
    model: QuasiSteadyModel | None,
) -> YawCoefficients:
    stroke = mean_stroke(averages, beats.mean_frequency)
    return yaw_coefficients(morphology, stroke, body_motion(recording, morphology).velocity.mean(axis=0), model)


def _torque_balance(
    recording: Recording, morphology: Morphology, beats: Wingbeats, model: QuasiSteadyModel | None
) -> TorqueBalance:
    left, right = (wing_motion(wing, recording.rate) for wing in both_wings(recording))
    loads = flight_loads(morphology, left, right, body_motion(recording, morphology), model)
    predicted = wingbeat_mean(loads.total.torque, recording.time, beats)
    required = wingbeat_mean(required_torque(recording, morphology), recording.time, beats)
    pairs = [(predicted[:, k] - predicted[:, k].mean(), required[:, k] - required[:, k].mean()) for k in range(3)]
    return TorqueBalance(
        predicted=predicted,
        required=required,
        correlation=_three([p @ r / np.sqrt((p @ p) * (r @ r)) for p, r in pairs]),
        slope=_three([p @ r / (p @ p) for p, r in pairs]),
        r2_unscaled=_three([explained(r, p) for p, r in pairs]),
    )


def _three(values: list[float]) -> tuple[float, float, float]:
    roll, pitch, yaw = (float(v) for v in values)
    return (roll, pitch, yaw)


def _beats_sentence(beats: Wingbeats, paddled: Paddling) -> str:
    f = beats.frequencies
    attack = 0.5 * (paddled.mean_attack_left + paddled.mean_attack_right).mean(axis=0) / deg
    return (
        f"{beats.count} wingbeats at {f.min():.0f}-{f.max():.0f} Hz (mean {beats.mean_frequency:.1f} Hz); wings sweep "
        f"at {paddled.mean_wing_speed:.0f} rad/s on average; attack angle {attack[0]:.0f} deg forward, "
        f"{attack[1]:.0f} deg backward; "
        f"d_alpha from {paddled.d_alpha.min() / deg:.1f} to {paddled.d_alpha.max() / deg:.1f} deg."
    )


def _convention_sentences(evidence: ConventionEvidence) -> list[str]:
    frame = [] if evidence.frame is None else [frame_sentence(evidence.frame)]
    return [*[test.sentence for test in evidence.tests], *frame, *evidence.undetermined]


def _plant_sentences(turning: TurnIdentification, blades: YawCoefficients | None, fly: Morphology) -> list[str]:
    sentences = [turning.status]
    if turning.plant is None:
        return sentences
    plant = turning.plant
    sentences.append(
        f"beta/I = {_interval(plant.damping, 0)} 1/s{_and_paddling(plant)}; the residuals' correlation from one "
        f"wingbeat to the next is {_interval(plant.noise_correlation, 2)}."
    )
    if blades is not None:
        sentences.append(
            f"Blade elements at the measured mean stroke predict beta/I = {blades.damping / fly.yaw_inertia:.0f} 1/s "
            f"({_inside(blades.damping / fly.yaw_inertia, plant.damping)}), gamma/I = "
            f"{round(blades.paddling / fly.yaw_inertia, -2):.0f} 1/s^2 per rad"
            f"{_beside(blades.paddling / fly.yaw_inertia, plant.paddling)} and "
            f"gamma/beta = {blades.turn_gain:.0f} 1/s, {blades.turn_gain_over_wing_speed:.2f} omega."
        )
    return sentences


def _limits(turning: TurnIdentification, torque: TorqueBalance | None) -> list[str]:
    """Say what probably limits the minimal model on this flight, with its measure."""
    sentences: list[str] = []
    plant, coupled = turning.plant, turning.plant_with_coupling
    if plant is not None and coupled is not None:
        share = float(np.var(turning.coupling) / np.var(plant.acceleration))
        best = coupled.r2_acceleration_best
        gain = f"at most {best:.0%} is explained" if best > 0 else "nothing is explained better than by the mean"
        sentences.append(
            f"Rolling and yawing are coupled by the product of inertia: the coupling has {share:.1f} times the "
            f"variance of the yaw acceleration. With it taken from the measured roll, {gain}, "
            f"beta/I = {_interval(coupled.damping, 0)} 1/s{_and_paddling(coupled)}."
        )
    if np.isfinite(turning.d_alpha_reliability):
        sentences.append(
            f"d_alpha scatters by {turning.d_alpha_noise / deg:.1f} deg from wingbeat to wingbeat; if that is tracking "
            f"noise, {turning.d_alpha_reliability:.0%} of its variance is signal, which scales gamma down by that "
            f"factor, and one wingbeat alone holds {turning.d_alpha_largest_share:.0%} of it."
        )
    if torque is not None:
        roll, pitch, yaw = torque.correlation
        sentences.append(
            "Torque of all measured wing motion by blade elements correlates with the torque that the body's rotation "
            f"needs by {roll:.2f} (roll), {pitch:.2f} (pitch), {yaw:.2f} (yaw)."
        )
    return sentences


def _interval(estimate: Estimate, digits: int) -> str:
    value, low, high = (round(v, digits) for v in (estimate.value, estimate.low, estimate.high))
    places = max(digits, 0)
    return f"{value:.{places}f} [{low:.{places}f}, {high:.{places}f}]"


def _and_paddling(plant: YawPlantFit) -> str:
    if plant.paddling is None:
        return " (95 %)"
    return f" and gamma/I = {_interval(plant.paddling, -2)} 1/s^2 per rad (95 %), {_gain(plant.turn_gain)}"


def _beside(value: float, estimate: Estimate | None) -> str:
    return "" if estimate is None else f" ({_inside(value, estimate)})"


def _gain(turn_gain: Estimate | None) -> str:
    if turn_gain is None:
        return "gamma/beta has no bounded interval, since beta may be zero"
    return f"gamma/beta = {_interval(turn_gain, 0)} 1/s"


def _inside(value: float, estimate: Estimate) -> str:
    return "inside the interval" if estimate.low <= value <= estimate.high else "outside the interval"

"""What a simulated flight's page says in words and tables."""

from __future__ import annotations

from dataclasses import dataclass

from flycontrol.flight.flight_record import FlightRecord
from flycontrol.flight.heading import nose_heading
from flycontrol.flight.quasi_steady import TERMS
from flycontrol.model.flight_experiment import FREEDOMS, Joint, TorqueJoint
from flycontrol.model.steering import Steering
from flycontrol.report.numbers import degrees, fixed, milliseconds, sentence, significant
from flycontrol.units import deg, mm, nN_m

_MICRO = 1e-6
_TURNED = 0.5 * deg  #: less is no turn worth a sentence
_NO_FORCE = "it is a torque about the wing’s axis, no force"
_TRIMMED = {
    "frequency": ("wingbeat frequency", 1.0, "Hz"),
    "stroke_amplitude": ("stroke amplitude", deg, "deg"),
    "stroke_offset": ("mean stroke position, forward", deg, "deg"),
    "pitch_amplitude": ("pitch amplitude", deg, "deg"),
    "pitch_offset": ("pitch offset", deg, "deg"),
    "pitch_lead": ("lead of the flip", deg, "deg"),
    "deviation_offset": ("deviation offset", deg, "deg"),
    "body_pitch": ("stroke plane above the horizon", deg, "deg"),
}


@dataclass(frozen=True, slots=True)
class Row:
    """A line of a table."""

    head: str
    value: str
    meaning: str = ""

    @property
    def values(self) -> tuple[str, str]:
        """Its cells after the head."""
        return self.value, self.meaning


def lead(record: FlightRecord) -> list[str]:
    """What happened, in a few sentences; the first is the main one."""
    planned, asked = record.planned, record.planned.experiment
    first = (
        f"{asked.morphology.species} flew {record.wingbeats} wingbeats at {fixed(planned.frequency, 1, 'Hz')}."
        if record.complete
        else f"The flight {sentence(record.status)}"
    )
    sentences = [first]
    if record.complete and record.mean is not None and planned.plan.fly.air.terms:
        carried = float(record.mean.lift.sum()) / asked.morphology.weight
        sentences.append(f"In the mean over the flight the air carried {fixed(carried, 3)} of its weight.")
    if abs(record.peak_yaw) > _TURNED:
        sentences = [*_turn(record), *sentences] if record.complete else [*sentences, *_turn(record)]
    if record.complete and planned.trim is not None and asked.free == FREEDOMS and not asked.steering:
        sentences.append("Nothing steers: hover without a controller is unstable, and what a pulse has begun grows.")
    return sentences


def _turn(record: FlightRecord) -> list[str]:
    """How far it turned, by the stroke plane and by the nose."""
    body, angle = record.body, record.planned.experiment.morphology.stroke_plane_angle
    nose, end = nose_heading(body.q_WS, angle)[-1], float(body.time[-1])
    still = ", still growing at the end" if record.peak_yaw_time >= end else f" at {milliseconds(record.peak_yaw_time)}"
    return [
        f"The heading of its stroke plane went {degrees(abs(record.peak_yaw))} to the {_side(record.peak_yaw)} at the "
        f"most{still}.",
        f"At the end the stroke plane heads {degrees(abs(body.yaw[-1]))} to the {_side(body.yaw[-1])} and the nose, "
        f"which a roll swings sideways, {degrees(abs(nose))} to the {_side(nose)}.",
    ]


def _side(angle: float) -> str:
    return "right" if angle >= 0 else "left"


def fly_rows(record: FlightRecord) -> list[Row]:
    """The fly."""
    fly = record.planned.experiment.morphology
    return [
        Row("Mass", significant(fly.mass / 1e-6, 3, "mg"), "whole fly, wings included"),
        Row("Wing length", significant(fly.wing_length / mm, 3, "mm"), "hinge to tip"),
        Row("Mean chord", significant(fly.mean_chord / mm, 3, "mm"), "area of one wing over its length"),
        Row("Wing mass", significant(1e9 * fly.wing_body.mass, 3, "µg"), "one wing"),
        Row("Yaw inertia", significant(fly.yaw_inertia, 3, "kg m²"), "of the body about the stroke-plane normal"),
        Row("Stroke plane", degrees(fly.stroke_plane_angle), "nose down from the body’s long axis"),
    ]  # fmt: skip


def experiment_rows(record: FlightRecord) -> list[Row]:
    """What was done to it."""
    planned, asked = record.planned, record.planned.experiment
    free = "all six ways" if asked.free == FREEDOMS else ", ".join(asked.free) or "none: the body is held"
    rows = [
        Row("Body free", free, "of forward, sideways, down, roll, pitch, yaw"),
        *(Row(f"{side} wing", _wing(wing), "") for side, wing in (("Left", asked.left), ("Right", asked.right))),
        Row(
            "Air",
            ", ".join(asked.air.terms).replace("_", " ") or "none",
            f"{asked.air.coefficients}, {asked.air.density:g} kg/m³",
        ),
    ]
    for number, pulse in enumerate(planned.plan.pulses, start=1):
        torque = ", ".join(fixed(part / nN_m, 3) for part in pulse.torque_S)
        rows.append(
            Row(
                f"Pulse {number}",
                f"({torque}) nN m",
                f"roll, pitch, yaw; from {milliseconds(pulse.start, 2)} for {milliseconds(pulse.duration, 2)}",
            )
        )
    for number, change in enumerate(asked.steering, start=1):
        rows.append(Row(f"Steering {number}", _when(change), _what(change)))
    return rows


def trim_rows(record: FlightRecord) -> list[Row]:
    """What the trim found."""
    trim = record.planned.trim
    if trim is None:
        return []
    rows: list[Row] = []
    for name, value in trim.values.items():
        words, unit, text = _TRIMMED[name]
        rows.append(Row(words.capitalize(), fixed(value / unit, 3, text), "moved by the trim"))
    left = trim.balance
    rows.append(
        Row("Force left", f"{significant(max(abs(left.forward), abs(left.down)), 2)}", "net mean, over the weight")
    )
    rows.append(
        Row("Pitch torque left", f"{significant(abs(left.pitch), 2)}", "net mean, over weight times wing length")
    )
    return rows


def error_rows(record: FlightRecord) -> list[Row]:
    """How far the numbers can be trusted."""
    asked, step, blades = record.planned.experiment, record.step_error, record.quadrature_error
    rows: list[Row] = []
    if step is not None:
        among = ", ".join(str(beat) for beat in record.step_error_wingbeats)
        halved = (
            f"of wingbeat {record.step_error_wingbeat} alone, by repeating it with half of its {asked.steps} steps; "
            f"the worst of wingbeats {among}, from 0"
        )
        if {"roll", "pitch", "yaw"} & set(asked.free):
            rows.append(Row("Attitude", significant(step.attitude / deg, 2, "deg"), halved))
            rows.append(Row("Angular velocity", significant(step.angular_velocity, 2, "rad/s"), "likewise"))
        if {"forward", "sideways", "down"} & set(asked.free):
            rows.append(Row("Position", significant(step.position / mm, 2, "mm"), "likewise"))
        if not (asked.left.prescribed and asked.right.prescribed):
            rows.append(Row("Free wing angles", significant(step.wing_angle / deg, 2, "deg"), halved))
    if blades is not None:
        rows.append(
            Row("Force", significant(blades.force, 2), f"of weight, at most, {asked.air.nodes} blades against 64")
        )
        rows.append(Row("Torque", significant(blades.torque, 2), "of weight times wing length, likewise"))
    return rows


def mean_rows(record: FlightRecord) -> list[Row]:
    """Forces by term over the whole flight."""
    if record.mean is None:
        return []
    weight = record.planned.experiment.morphology.weight
    lift = record.mean.lift[0] / weight
    rows = [
        Row(
            term.replace("_", " ").capitalize(),
            fixed(lift[k], 4),
            _NO_FORCE if term == "dissipative" else "upward force over the weight",
        )
        for k, term in enumerate(TERMS)
    ]
    power = float(record.mean.power[0])
    return [
        *rows,
        Row("All terms", fixed(float(lift.sum()), 4), "likewise"),
        Row("Power", significant(power / _MICRO, 3, "µW"), "of both hinges"),
    ]


def _wing(wing: object) -> str:
    parts = {name: getattr(wing, name) for name in ("stroke", "deviation", "pitch")}
    if all(joint is None for joint in parts.values()):
        return "prescribed"
    return ", ".join(f"{name} {_joint(joint)}" for name, joint in parts.items())


def _joint(joint: Joint) -> str:
    if joint is None:
        return "prescribed"
    if isinstance(joint, TorqueJoint):
        return f"driven by {significant(joint.amplitude, 3, 'N m')}"
    return f"a spring of {significant(joint.stiffness, 3, 'N m/rad')}"


def _when(change: Steering) -> str:
    return "throughout" if change.ramp is None else f"wingbeats {change.ramp[0]:g} to {change.ramp[1]:g}"


def _what(change: Steering) -> str:
    """Both wings' changes, in degrees; the amplitude's in percent."""
    parts: list[str] = []
    for side, wing in (("left", change.left), ("right", change.right)):
        angles = {
            "stroke": wing.stroke_offset,
            "deviation": wing.deviation_offset,
            "pitch, forward stroke": wing.pitch_offset,
        }
        said = [f"{name} {degrees(angle)}" for name, angle in angles.items() if angle]
        said += [f"amplitude {fixed(100 * wing.stroke_gain, 1, '%')}"] if wing.stroke_gain else []
        parts += [f"{side} wing: {', '.join(said)}"] if said else []
    return "; ".join(parts)

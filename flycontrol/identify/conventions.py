"""Which way the wing angles of a recording count, and which wing is which, by what they would do to the fly.

Each question sets the recording as it was mapped against one with a sign turned round: weight support for the wing's
pitch, roll for left against right, pitch for forward against backward. What the flight does not tell stays open.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.flight.aerodynamics import Load, QuasiSteadyModel, flight_loads
from flycontrol.identify.motion import Attitude, attitude, body_motion
from flycontrol.model.morphology import GRAVITY, Morphology
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.stroke import both_wings, derivative, wing_motion
from flycontrol.model.wingbeats import Wingbeats, segment_wingbeats, wingbeat_mean
from flycontrol.units import deg

FloatArray = NDArray[np.float64]
Finding = Literal["supported", "contradicted", "undetermined"]

SEED = 20101020
BLOCK = 5  #: wingbeats that a block of the bootstrap keeps together
RESAMPLES = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class SignTest:
    """One convention: what its measure says of the recording as mapped and of the alternative."""

    convention: str
    alternative: str
    measure: str
    as_mapped: float
    turned: float  #: the measure with the convention turned round
    difference_low: float  #: 95 % interval of as_mapped - turned, moving-block bootstrap over wingbeats
    difference_high: float
    finding: Finding

    @property
    def sentence(self) -> str:
        """What was found, in words."""
        return (
            f"{self.convention}: {self.measure} is {self.as_mapped:.2f} as mapped and {self.turned:.2f} "
            f"{self.alternative} (difference {self.difference_low:.2f} to {self.difference_high:.2f}): {self.finding}."
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameCheck:
    """v_S = Ry(angle) v_B, v_B from position and attitude, against the recorded velocity."""

    angle: float  #: as the morphology has it [rad]
    fitted_angle: float  #: that turns v_B into v_S with the least error [rad]
    residual: float  #: root mean square of v_S - Ry(angle) v_B [m/s]
    residual_reversed: float  #: the same with -angle [m/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class ConventionEvidence:
    """What a flight says of the conventions of its recording; arrays of one value a wingbeat for figures."""

    wing_pitch: SignTest
    stroke_sense: SignTest
    left_right: SignTest
    deviation: SignTest
    frame: FrameCheck | None
    time: FloatArray  #: (n,) middle of each wingbeat [s]
    vertical_force: FloatArray  #: (n,) predicted, over the weight [1]
    vertical_force_reversed: FloatArray  #: (n,) the same with eta -> 180 deg - eta [1]
    vertical_force_needed: FloatArray  #: (n,) 1 + a_z / g, from the measured motion [1]
    roll_torque: FloatArray  #: (n,) predicted [N m]
    roll_torque_swapped: FloatArray  #: (n,) predicted with left and right exchanged [N m]
    roll_acceleration: FloatArray  #: (n,) measured [rad/s^2]
    undetermined: tuple[str, ...]  #: sentences

    @property
    def tests(self) -> tuple[SignTest, ...]:
        """All sign tests."""
        return (self.wing_pitch, self.stroke_sense, self.left_right, self.deviation)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Predicted:
    """Means over each wingbeat for one reading of the wing angles."""

    vertical: FloatArray  # (n,) over the weight
    torque: FloatArray  # (n, 3) [N m]


def establish_conventions(
    recording: Recording,
    morphology: Morphology,
    beats: Wingbeats | None = None,
    model: QuasiSteadyModel | None = None,
) -> ConventionEvidence:
    """Set the recording as mapped against its alternatives, one convention at a time.

    Raises
    ------
    InvalidInputError
        Wing angles, angular velocity, quaternion or position are missing, or there are fewer than three wingbeats.
    """
    beats = beats or segment_wingbeats(recording)
    turned = attitude(recording, morphology)
    readings = {
        name: _predicted(recording, morphology, wings, (beats, turned), model)
        for name, wings in _readings(recording).items()
    }
    rates = body_motion(recording, morphology).angular_velocity
    acceleration = wingbeat_mean(derivative(rates, recording.rate), recording.time, beats)
    needed = 1.0 + _vertical_acceleration(recording, beats) / GRAVITY
    tests = _tests(readings, acceleration, needed)
    return ConventionEvidence(
        **tests,
        frame=_frame_check(recording, morphology, turned),
        time=beats.middles,
        vertical_force=readings["mapped"].vertical,
        vertical_force_reversed=readings["pitch reversed"].vertical,
        vertical_force_needed=needed,
        roll_torque=readings["mapped"].torque[:, 0],
        roll_torque_swapped=readings["swapped"].torque[:, 0],
        roll_acceleration=acceleration[:, 0],
        undetermined=_undetermined(tuple(tests.values())),
    )


def _readings(recording: Recording) -> dict[str, tuple[WingAngles, WingAngles]]:
    """Left and right wing as mapped, and with one convention turned round each."""
    left, right = both_wings(recording)
    return {
        "mapped": (left, right),
        "pitch reversed": (_pitch_reversed(left), _pitch_reversed(right)),
        "mirrored": (_fore_aft(left), _fore_aft(right)),
        "swapped": (right, left),
        "deviation reversed": (_deviation_reversed(left), _deviation_reversed(right)),
    }


def _tests(readings: dict[str, _Predicted], acceleration: FloatArray, needed: FloatArray) -> dict[str, SignTest]:
    mapped = readings["mapped"]
    sense = ("Stroke positive forward", "with forward and backward exchanged", 1)
    sides = ("Left and right wing", "with the wings exchanged", 0)
    above = ("Deviation positive above the stroke plane", "with its sign turned", 1)
    return {
        "wing_pitch": _weight_test(mapped, readings["pitch reversed"], needed),
        "stroke_sense": _torque_test(sense, mapped, readings["mirrored"], acceleration),
        "left_right": _torque_test(sides, mapped, readings["swapped"], acceleration),
        "deviation": _torque_test(above, mapped, readings["deviation reversed"], acceleration),
    }


def _predicted(
    recording: Recording,
    morphology: Morphology,
    wings: tuple[WingAngles, WingAngles],
    grid: tuple[Wingbeats, Attitude],
    model: QuasiSteadyModel | None,
) -> _Predicted:
    beats, turned = grid
    left, right = (wing_motion(angles, recording.rate) for angles in wings)
    load: Load = flight_loads(morphology, left, right, body_motion(recording, morphology), model).total
    upward = turned.world(load.force)[:, 2] / morphology.weight
    return _Predicted(
        vertical=wingbeat_mean(upward, recording.time, beats), torque=wingbeat_mean(load.torque, recording.time, beats)
    )


def _pitch_reversed(wing: WingAngles) -> WingAngles:
    return WingAngles(stroke=wing.stroke, deviation=wing.deviation, pitch=np.pi - wing.pitch)


def _fore_aft(wing: WingAngles) -> WingAngles:
    """Mirror image in the plane x = 0: weight support stays, the pitching torque turns round."""
    return WingAngles(stroke=-wing.stroke, deviation=wing.deviation, pitch=np.pi - wing.pitch)


def _deviation_reversed(wing: WingAngles) -> WingAngles:
    return WingAngles(stroke=wing.stroke, deviation=-wing.deviation, pitch=wing.pitch)


def _vertical_acceleration(recording: Recording, beats: Wingbeats) -> FloatArray:
    """(n,) upward acceleration over each wingbeat: the change of vertical velocity over its duration [m/s^2]."""
    if recording.position_W is None:
        raise InvalidInputError(
            f"{recording.name}: the body's position is needed for weight support and is not mapped."
        )
    velocity = derivative(recording.position_W[:, 2], recording.rate)
    return wingbeat_mean(derivative(velocity, recording.rate), recording.time, beats)


def _weight_test(mapped: _Predicted, reversed_pitch: _Predicted, needed: FloatArray) -> SignTest:
    """Mean vertical force over the force that the measured motion needs."""
    n = len(needed)
    picks = _blocks(n)
    ratio = mapped.vertical[picks].mean(axis=1) / needed[picks].mean(axis=1)
    turned = reversed_pitch.vertical[picks].mean(axis=1) / needed[picks].mean(axis=1)
    return _sign_test(
        ("Wing pitch", "with pitch eta -> 180 deg - eta", "predicted over needed vertical force"),
        float(mapped.vertical.mean() / needed.mean()),
        float(reversed_pitch.vertical.mean() / needed.mean()),
        ratio - turned,
    )


def _torque_test(
    names: tuple[str, str, int], mapped: _Predicted, other: _Predicted, acceleration: FloatArray
) -> SignTest:
    """Correlation over wingbeats of predicted torque with measured angular acceleration about one axis."""
    convention, alternative, axis = names
    predicted, turned, measured = mapped.torque[:, axis], other.torque[:, axis], acceleration[:, axis]
    picks = _blocks(len(measured))
    difference = _correlation(predicted[picks], measured[picks]) - _correlation(turned[picks], measured[picks])
    measure = f"correlation of predicted {('roll', 'pitch', 'yaw')[axis]} torque with measured acceleration"
    as_mapped, as_turned = (float(_correlation(p[None], measured[None])[0]) for p in (predicted, turned))
    return _sign_test((convention, alternative, measure), as_mapped, as_turned, difference)


def _sign_test(names: tuple[str, str, str], mapped: float, turned: float, difference: FloatArray) -> SignTest:
    """Decide where the interval of the difference leaves out zero and the better reading has the right sign."""
    convention, alternative, measure = names
    low, high = (float(v) for v in np.quantile(difference, [0.025, 0.975]))
    finding: Finding = "undetermined"
    if low > 0 and mapped > 0:
        finding = "supported"
    elif high < 0 and turned > 0:
        finding = "contradicted"
    return SignTest(
        convention=convention,
        alternative=alternative,
        measure=measure,
        as_mapped=mapped,
        turned=turned,
        difference_low=low,
        difference_high=high,
        finding=finding,
    )


def _blocks(n: int) -> NDArray[np.intp]:
    """(resamples, n) indices of a moving-block bootstrap, wrapped round at the end; fixed seed."""
    length = min(BLOCK, n)
    starts = np.random.default_rng(SEED).integers(0, n, size=(RESAMPLES, -(-n // length)))
    return ((starts[..., None] + np.arange(length)) % n).reshape(RESAMPLES, -1)[:, :n]


def _correlation(a: FloatArray, b: FloatArray) -> FloatArray:
    """Pearson's correlation along the last axis."""
    a = a - a.mean(axis=-1, keepdims=True)
    b = b - b.mean(axis=-1, keepdims=True)
    return np.sum(a * b, axis=-1) / np.sqrt(np.sum(a**2, axis=-1) * np.sum(b**2, axis=-1))


def _frame_check(recording: Recording, morphology: Morphology, turned: Attitude) -> FrameCheck | None:
    if recording.velocity_S is None or recording.position_W is None:
        return None
    v_B = turned.body_to_world.inv().apply(derivative(recording.position_W, recording.rate))
    v_S, frame = recording.velocity_S, turned.stroke_plane_from_body
    sine = np.sum(v_B[:, 2] * v_S[:, 0] - v_B[:, 0] * v_S[:, 2])
    cosine = np.sum(v_B[:, 0] * v_S[:, 0] + v_B[:, 2] * v_S[:, 2])
    return FrameCheck(
        angle=morphology.stroke_plane_angle,
        fitted_angle=float(np.arctan2(sine, cosine)),
        residual=float(np.sqrt(np.mean((v_S - v_B @ frame.T) ** 2))),
        residual_reversed=float(np.sqrt(np.mean((v_S - v_B @ frame) ** 2))),
    )


def frame_sentence(check: FrameCheck) -> str:
    """What the frame check found, in words."""
    return (
        f"Stroke-plane frame: with the stroke plane {check.angle / deg:.2f} deg nose down from the body, the body's "
        f"velocity becomes the recorded one to {check.residual * 1e3:.3g} mm/s rms "
        f"({check.residual_reversed * 1e3:.3g} mm/s with the angle turned round); the best angle is "
        f"{check.fitted_angle / deg:.2f} deg."
    )


def _undetermined(tests: tuple[SignTest, ...]) -> tuple[str, ...]:
    open_tests = [f"{t.convention} is not determined by this flight." for t in tests if t.finding == "undetermined"]
    always = [
        "The zero of the pitch angle is not determined: an offset common to both wings changes lift and drag little, "
        "and one that differs between the wings looks like paddling.",
        "The hinge's place along the body is not determined: it moves the mean pitching torque only.",
    ]
    return (*open_tests, *always)

"""A flight experiment as a value: the fly, how it beats its wings, what may move, and what is done to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.model.hinge import DampedSpring
from flycontrol.model.morphology import Morphology
from flycontrol.model.provenance import Provenance
from flycontrol.model.steering import Steering
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.units import ms

FloatArray = NDArray[np.float64]
Vector = tuple[float, float, float]
Freedom = Literal["forward", "sideways", "down", "roll", "pitch", "yaw"]
FREEDOMS: tuple[Freedom, ...] = get_args(Freedom)
FEWEST_STEPS = 20  #: of a wingbeat
_ROUNDING = 1e-9  #: of a time that is given in wingbeats


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueJoint:
    """Tau(p) = mean + amplitude cos(2 pi p + lead), p the phase [wingbeats]."""

    amplitude: float  #: [N m]
    mean: float = 0.0  #: [N m]
    lead: float = 0.0  #: [rad]

    def __call__(self, phase: FloatArray) -> FloatArray:
        """Torque at phases (N,) [N m]."""
        return self.mean + self.amplitude * np.cos(2 * np.pi * phase + self.lead)


Joint = DampedSpring | TorqueJoint | None  #: None: prescribed by the stroke


@dataclass(frozen=True, slots=True, kw_only=True)
class WingJoints:
    """What moves the three angles of one wing."""

    stroke: Joint = None
    deviation: Joint = None
    pitch: Joint = None

    @property
    def prescribed(self) -> bool:
        """Whether the stroke prescribes all three."""
        return self.stroke is None and self.deviation is None and self.pitch is None


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightTime:
    """A time in seconds and wingbeats: a trim may change how long a wingbeat is."""

    seconds: float = 0.0  #: [s]
    wingbeats: float = 0.0  #: [wingbeats]

    def at(self, frequency: float) -> float:
        """In seconds, at a wingbeat frequency [1/s]."""
        return self.seconds + self.wingbeats / frequency


@dataclass(frozen=True, slots=True, kw_only=True)
class TorquePulse:
    """A constant torque on the body for a while."""

    onset: FlightTime
    duration: FlightTime
    torque_S: Vector  #: about forward, right, down of the stroke-plane frame; [2] > 0 turns right [N m]


@dataclass(frozen=True, slots=True, kw_only=True)
class Air:
    """What the air does."""

    terms: tuple[str, ...] = ("translational", "rotational", "added_mass", "dissipative")
    coefficients: str = "dickinson1999"
    density: float = 1.19  #: [kg/m^3]
    nodes: int = 6  #: blades a wing


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Standard deviations of what is drawn for each flight of an ensemble, normal about the experiment's values."""

    mass: float = 0.0  #: relative, inertia with it
    wing_length: float = 0.0  #: relative, mean chord with it
    stroke_gain: float = 0.0  #: of the amplitude, both wings
    stroke_offset: float = 0.0  #: both wings [rad]
    deviation_offset: float = 0.0  #: both wings [rad]
    pitch_offset: float = 0.0  #: of each wing on its own, d_alpha on the forward stroke [rad]
    torque: float = 0.0  #: of pulses, relative
    onset: float = 0.0  #: of pulses [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ensemble:
    """Many flights of one experiment, each drawn anew."""

    flights: int
    seed: int
    spread: Spread


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightExperiment:
    """All that a simulated flight depends on."""

    name: str
    morphology: Morphology
    stroke: StrokeKinematics  #: unsteered, as it is to be flown, or where the trim begins
    trim: tuple[str, ...] = ()  #: three parameters that are moved until the fly hovers; none: the stroke stays as it is
    body_pitch: float = 0.0  #: of the stroke plane above the horizon, where the trim begins or stays [rad]
    wingbeats: int
    sources: Mapping[str, Provenance] = field(default_factory=dict[str, Provenance])  #: of the morphology's numbers
    free: tuple[Freedom, ...] = FREEDOMS  #: what may move of the body; the rest is held
    left: WingJoints = WingJoints()
    right: WingJoints = WingJoints()
    pulses: tuple[TorquePulse, ...] = ()
    steering: tuple[Steering, ...] = ()
    air: Air = Air()
    steps: int = 200  #: a wingbeat
    samples: int = 50  #: a wingbeat
    tolerance: float = 1e-3  #: of the error of a wingbeat [rad]
    ensemble: Ensemble | None = None
    file: str = ""  #: name of the file that it was read from
    sha256: str = ""  #: of the file's bytes

    def __post_init__(self) -> None:
        if not self.wingbeats >= 1:
            raise InvalidParameterError(f"A flight needs at least one wingbeat, got {self.wingbeats!r}.")
        if self.trim and not (self.left.prescribed and self.right.prescribed):
            raise InvalidInputError(
                "Only prescribed wings are trimmed; take hinges out, or say moves = [] under [trim]."
            )
        if self.ensemble is not None and not (self.left.prescribed and self.right.prescribed):
            raise InvalidInputError(
                "Only prescribed wings are flown as an ensemble; take hinges out, or take [ensemble] out and fly once."
            )
        known = [pulse for pulse in self.pulses if placed_before_trim(pulse, self.trim)]
        refuse_pulses_outside(known, self.wingbeats, self.stroke.frequency)

    def steered(self, stroke: StrokeKinematics) -> StrokeKinematics:
        """A stroke, once trimmed, with the experiment's steering."""
        for change in self.steering:
            stroke = change.applied(stroke)
        return stroke


def placed_before_trim(pulse: TorquePulse, trim: Sequence[str]) -> bool:
    """Whether a pulse's place in the flight is known before the trim, which may move the frequency."""
    return "frequency" not in trim or pulse.onset.seconds == pulse.duration.seconds == 0


def refuse_pulses_outside(pulses: Sequence[TorquePulse], wingbeats: int, frequency: float) -> None:
    """InvalidInputError where a pulse is not wholly within a flight of so many wingbeats at a frequency [1/s]."""
    end = wingbeats / frequency
    for pulse in pulses:
        start, duration = pulse.onset.at(frequency), pulse.duration.at(frequency)
        if not (start >= 0 and start + duration <= end * (1 + _ROUNDING)):
            lies = "lies outside" if start < 0 or start >= end else "sticks out of"
            raise InvalidInputError(
                f"A pulse from {start / ms:.6g} to {(start + duration) / ms:.6g} ms (wingbeats {start * frequency:.6g} "
                f"to {(start + duration) * frequency:.6g} at {frequency:.5g} Hz) {lies} the flight of {wingbeats} "
                f"wingbeats, 0 to {end / ms:.6g} ms; move it, shorten it, or fly on."
            )

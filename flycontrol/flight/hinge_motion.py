"""Passive pitching: stroke and deviation prescribed, pitch free on a damped spring, body held still.

    (M q'')_eta = N_air - kappa (eta - eta_0) - C eta',    (eta, eta') after a wingbeat = (eta, eta') before it

The periodic state of each wing is found by Newton's method on the map from one wingbeat to the next.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.drive import drive_table
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.march import LEFT, LEFT_RATE, RIGHT, RIGHT_RATE, SAMPLE, SPIN, march
from flycontrol.flight.multibody.constants import constants_of
from flycontrol.flight.multibody.freedoms import HELD, Hinge, Prescribed
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import level_start, packed, trajectory_of, unpacked
from flycontrol.model.hinge import DampedSpring, SteeredSpring
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState, Trajectory

FloatArray = NDArray[np.float64]

EVERY_STEP = MarchSettings(samples=200)
CLOSED = 1e-10  #: pitch and pitch rate over frequency at the end of a periodic wingbeat, less those at its beginning

_PITCH, _RATE = [LEFT + 2, RIGHT + 2], [LEFT_RATE + 2, RIGHT_RATE + 2]
_SETTLING = 6  # wingbeats before Newton's method
_DIFFERENCE = 1e-6
_MOST_ITERATIONS = 30


@dataclass(frozen=True, slots=True, kw_only=True)
class PassiveWingbeat:
    """The periodic wingbeat of a fly held still whose wings pitch passively."""

    trajectory: Trajectory  #: N instants of one wingbeat, its end not included
    start: FlightState  #: at phase 0, level, the body still or yawing: where a flight with these hinges begins
    multipliers: FloatArray  #: (2, 2) moduli by which each wing's disturbances of pitch grow in a wingbeat
    closure: float  #: what is left of pitch [rad] and pitch rate [frequency] after a wingbeat

    @property
    def settling(self) -> float:
        """Wingbeats in which the slowest disturbance of pitch falls to 1/e; infinite where it does not fall."""
        slowest = float(self.multipliers.max())
        return -1.0 / np.log(slowest) if slowest < 1 else np.inf


def passive_wingbeat(
    fly: FlappingFly, stroke: StrokeKinematics, settings: MarchSettings | None = None, *, yaw_rate: float = 0.0
) -> PassiveWingbeat:
    """Pitch of both wings on their springs in the steady state.

    Parameters
    ----------
    fly
        Both pitch joints on a `DampedSpring` or, with a `HingeStroke`, on a `SteeredSpring`; stroke and deviation
        prescribed. Its body is held level, whatever its freedoms.
    stroke
        Periodic. Pitch begins the search where the stroke has it at phase 0.
    settings
        Steps and samples a wingbeat, 200 of each by default.
    yaw_rate
        At which the body is turned, > 0 to the right [rad/s].

    Raises
    ------
    InvalidParameterError
        The hinges are others, the yaw rate is not finite, or no periodic wingbeat is found: the spring lets the wing
        tumble.
    """
    _refuse_other_hinges(fly, stroke)
    if not np.isfinite(yaw_rate):
        raise InvalidParameterError(f"passive_wingbeat needs a finite yaw rate in rad/s, got {yaw_rate!r}.")
    beat = _PitchMap(replace(fly, body=HELD), stroke, settings or EVERY_STEP)
    beat.rest[SPIN + 2] = yaw_rate
    x, jacobian, closure = _periodic(beat)
    return PassiveWingbeat(
        trajectory=beat.flown(x),
        start=unpacked(beat.state(x)),
        multipliers=np.abs(np.linalg.eigvals(jacobian)),
        closure=closure,
    )


def sprung(fly: FlappingFly, left: DampedSpring, right: DampedSpring | None = None) -> FlappingFly:
    """The fly with its wings' pitch on springs, the same one for both unless two are given; all else prescribed."""
    return replace(fly, left=Hinge(pitch=left), right=Hinge(pitch=right or left))


def _periodic(beat: _PitchMap) -> tuple[FloatArray, FloatArray, float]:
    """The fixed point x of the map, its Jacobian there, and what is left of map(x) - x."""
    x = beat.guess
    for _ in range(_SETTLING):
        x = beat(x)
    for _ in range(_MOST_ITERATIONS):
        end = beat(x)
        jacobian, closure = beat.jacobian(x, end), float(np.abs(end - x).max())
        if closure < CLOSED:
            return x, jacobian, closure
        x = x + np.linalg.solve(np.eye(2) - jacobian, (end - x)[..., None])[..., 0]
    raise InvalidParameterError(
        f"No periodic wingbeat was found in {_MOST_ITERATIONS} iterations: pitch does not come back to where it began. "
        "Stiffen the spring, add damping, or move the pitch axis forward."
    )


class _PitchMap:
    """(2, 2) pitch [rad] and pitch rate over frequency of the left and right wing, from one wingbeat to the next."""

    def __init__(self, fly: FlappingFly, stroke: StrokeKinematics, settings: MarchSettings) -> None:
        phase = np.arange(2 * settings.steps + 1) / (2 * settings.steps)
        self.stroke, self.settings = stroke, settings
        self.drive = drive_table(fly, stroke, phase)
        self.constants = constants_of(fly, stroke.frequency)
        self.rest = packed(level_start(stroke))
        self.outside = np.zeros((settings.steps, 6))

    @property
    def guess(self) -> FloatArray:
        """Where the stroke has it."""
        return self._of(self.rest)

    def __call__(self, x: FloatArray) -> FloatArray:
        """One wingbeat later."""
        return self._of(self._march(x)[0])

    def jacobian(self, x: FloatArray, end: FloatArray) -> FloatArray:
        """(2, 2, 2) of each wing; body held, the wings do not feel one another."""
        columns = [(self(x + step) - end) / _DIFFERENCE for step in _DIFFERENCE * np.eye(2)]
        return np.stack(columns, axis=-1)

    def flown(self, x: FloatArray) -> Trajectory:
        """The wingbeat from x."""
        per_beat = self.settings.samples
        flight = trajectory_of(self._march(x)[1], np.arange(per_beat) / per_beat, self.stroke.frequency, per_beat)
        return replace(flight, wingbeats=1)

    def state(self, x: FloatArray) -> FloatArray:
        """(25,) state with pitch and its rate from x."""
        y = self.rest.copy()
        y[_PITCH], y[_RATE] = x[:, 0], x[:, 1] * self.stroke.frequency
        return y

    def _of(self, y: FloatArray) -> FloatArray:
        return np.stack([y[_PITCH], y[_RATE] / self.stroke.frequency], axis=-1)

    def _march(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        y, steps = self.state(x), self.settings.steps
        samples = np.empty((self.settings.samples, SAMPLE))
        step = 1.0 / (self.stroke.frequency * steps)
        done = march(y, self.drive, step, self.outside, steps // len(samples), *self.constants.arguments, samples)
        if done < steps:
            raise InvalidParameterError(
                "A wing on its spring runs away within one wingbeat; take more steps a wingbeat or a softer spring."
            )
        return y, samples


def _refuse_other_hinges(fly: FlappingFly, stroke: StrokeKinematics) -> None:
    for hinge in (fly.left, fly.right):
        swept = isinstance(hinge.stroke, Prescribed) and isinstance(hinge.deviation, Prescribed)
        if not (swept and isinstance(hinge.pitch, DampedSpring | SteeredSpring)):
            raise InvalidParameterError(
                "Passive pitching needs stroke and deviation prescribed and pitch on a DampedSpring or SteeredSpring "
                "at both hinges; `sprung` makes such a fly."
            )
    if not (stroke.left.periodic and stroke.right.periodic):
        raise InvalidParameterError("A periodic wingbeat needs a periodic stroke, and this one changes with time.")

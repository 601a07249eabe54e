"""Flights under a fly's own yaw control: the wing level with the loop closed.

Between two readings of the delay line the command is known, so the march goes on in pieces no longer than the delay.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.delay_line import DelayLine
from flycontrol.flight.drive import drive_table
from flycontrol.flight.feedback import YawFeedback
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.heading import headings, yaw_rates
from flycontrol.flight.kernels.march import SAMPLE, march, sample_now
from flycontrol.flight.multibody.constants import constants_of
from flycontrol.flight.multibody.freedoms import Prescribed
from flycontrol.flight.pulses import BodyPulse, outside_loads, refuse_idle_pulses
from flycontrol.flight.quadrature_error import estimate_quadrature_error
from flycontrol.flight.sensors import BodyMotion
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import first_wingbeat, level_start, packed, trajectory_of
from flycontrol.flight.step_error import coarse_end, step_error_between
from flycontrol.flight.wingbeats import diverged, whole_wingbeats
from flycontrol.model.hinge import SteeredSpring
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState, StepError, Trajectory
from flycontrol.model.wing_stroke import PhasedAngles, WingStroke

FloatArray = NDArray[np.float64]

_WITHIN = 1e-9  # of a step: a delay of so many steps, but for rounding, is as long as that many steps


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlledFlight:
    """A flight, and what its controller asked for."""

    trajectory: Trajectory
    command: FloatArray  #: (N,) paddling angle or hinge bias that the wings are asked for [rad]

    @property
    def yaw(self) -> FloatArray:
        """(N,) heading less that at the beginning [rad]."""
        return self.trajectory.yaw - self.trajectory.yaw[0]

    def averaged(self, values: FloatArray) -> FloatArray:
        """(N,) mean over the wingbeat around each instant, by the trapezoidal rule; NaN in the first and last half.

        Parameters
        ----------
        values : (N,) at the trajectory's instants
        """
        n, instants = self.trajectory.samples_per_wingbeat, len(self.trajectory.time)
        if n % 2:
            raise InvalidParameterError(f"Wingbeat means need an even number of samples a wingbeat, got {n}.")
        if np.shape(values) != (instants,):
            raise InvalidParameterError(
                f"averaged needs one value at each of the flight's {instants} instants, got shape {np.shape(values)}."
            )
        if instants <= n:
            raise InvalidParameterError(f"Wingbeat means need a whole wingbeat, {n + 1} instants, got {instants}.")
        weights = np.full(n + 1, 1.0 / n)
        weights[[0, -1]] /= 2
        means = np.full(len(values), np.nan)
        means[n // 2 : len(values) - n // 2] = np.convolve(values, weights, mode="valid")
        return means

    @property
    def d_alpha(self) -> FloatArray:
        """(K,) paddling of each wingbeat, <phi'^2 (eta_R - eta_L)> / (2 <phi'^2>) [rad]."""
        flight = self.trajectory
        n = flight.samples_per_wingbeat
        beats = (len(flight.time) - 1) // n * n
        weight = (flight.left.stroke_rate**2 + flight.right.stroke_rate**2)[:beats].reshape(-1, n)
        apart = 0.5 * (flight.right.pitch - flight.left.pitch)[:beats].reshape(-1, n)
        return np.asarray((weight * apart).sum(axis=1) / weight.sum(axis=1), dtype=np.float64)


def controlled_flight(  # noqa: PLR0913 (simulate_flight's arguments and a controller)
    fly: FlappingFly,
    stroke: StrokeKinematics,
    feedback: YawFeedback,
    wingbeats: int,
    *,
    start: FlightState | None = None,
    pulses: Sequence[BodyPulse] = (),
    settings: MarchSettings | None = None,
) -> ControlledFlight:
    """Fly so many wingbeats under yaw control; the heading to hold is that of the start.

    Parameters
    ----------
    fly
        Its body must be free to yaw; its pitch joints take the command: prescribed ones as paddling, `SteeredSpring`s
        as a bias of their rest angle.
    stroke
        Of both wings without control; a `HingeStroke` on springs.
    feedback
        Sensor, gains, delay. The delay must be at least one step.
    wingbeats
        How many, at least one.
    start
        State at phase 0; by default at rest, stroke plane level, wings where the stroke begins.
    pulses
        Forces and torques from outside, each of them during the flight, at least in part.
    settings
        Steps and samples a wingbeat.

    Returns
    -------
    ControlledFlight
        Of wingbeats * samples + 1 instants; fewer if it diverges, and its trajectory's status says why.

    Raises
    ------
    InvalidParameterError
        No wingbeat, a delay below one step, a body that cannot yaw, pitch joints that take no command, a pulse that
        never acts, or a step too coarse.
    """
    wingbeats = whole_wingbeats(wingbeats)
    _refuse_held_yaw(fly)
    _refuse_deaf_hinges(fly)
    refuse_idle_pulses(pulses, wingbeats, stroke.frequency)
    loop = _ClosedLoop(fly, stroke, feedback, tuple(pulses), settings or MarchSettings(), wingbeats)
    return loop.flown(packed(start or level_start(stroke)))


class _ClosedLoop:
    """What a flight under control keeps from one piece to the next."""

    def __init__(
        self, fly: FlappingFly, stroke: StrokeKinematics, feedback: YawFeedback, pulses: tuple[BodyPulse, ...],
        settings: MarchSettings, wingbeats: int,
    ) -> None:  # fmt: skip
        self.fly, self.stroke, self.feedback, self.pulses = fly, stroke, feedback, pulses
        self.settings, self.wingbeats = settings, wingbeats
        self.step = 1.0 / (stroke.frequency * settings.steps)
        self.constants = constants_of(fly, stroke.frequency)
        self.samples = np.empty((wingbeats * settings.steps + 1, SAMPLE))
        self.line = DelayLine(self.step, len(self.samples))
        self.piece = self._longest_piece()
        self.sensed: FloatArray | None = None
        self.integral, self.aim, self.heading = 0.0, 0.0, 0.0

    def _longest_piece(self) -> int:
        """Steps for which a command is known in advance."""
        steps = int(self.feedback.total_delay / self.step * (1 + _WITHIN))
        if steps < 1:
            raise InvalidParameterError(
                f"A controller's delay must be at least one step of the simulation, {self.step:.3g} s here, got "
                f"{self.feedback.total_delay:.3g} s; take a longer delay or more steps a wingbeat."
            )
        return min(steps, self.settings.steps)

    def flown(self, y: FloatArray) -> ControlledFlight:
        """Piece after piece, none across the beginning of a wingbeat."""
        error = self._begin(y)
        per_beat, done, status = self.settings.steps, 0, "complete"
        while done < self.wingbeats * per_beat:
            count = min(self.piece, per_beat - done % per_beat)
            flown = self._march(y, done, count)
            done += flown
            if flown < count:
                beat = done // per_beat
                status = diverged(beat, y) or f"stopped in wingbeat {beat}: a free wing joint runs away."
                break
            self._sense(done - count, done)
        return self._result(done, status, error)

    def _begin(self, y: FloatArray) -> StepError | None:
        """Sense the start with unsteered wings; the step's error where it is asked for."""
        steps = self.settings.steps
        drive = drive_table(self.fly, self.stroke, np.arange(2 * steps + 1) / (2 * steps))
        outside = outside_loads(self.pulses, 0.0, self.step, steps)
        fine = y.copy()
        march(fine, drive, self.step, outside, steps, *self.constants.arguments, self.samples[:1])
        self.aim = self.heading = float(headings(self.samples[:1])[0, 0])
        self._sense(0, 0)
        if not self.settings.estimate_error:
            return None
        coarse = coarse_end(y, drive, self.step, outside, self.constants)
        return step_error_between(coarse, fine, self.step, self.settings)

    def _march(self, y: FloatArray, first: int, count: int) -> int:
        """Steps done of those from `first` on."""
        steps = self.settings.steps
        phase = (first + np.arange(2 * count + 1) / 2) / steps
        drive = drive_table(self.fly, self._steered(), phase)
        outside = outside_loads(self.pulses, first * self.step, self.step, count)
        room = self.samples[first : first + count]
        done = march(y, drive, self.step, outside, 1, *self.constants.arguments, room)
        if done == count:
            sample_now(y, drive, outside, *self.constants.arguments, self.samples[first + count])
        return done

    def _steered(self) -> StrokeKinematics:
        def command(phase: FloatArray) -> FloatArray:
            return self.feedback.command(self.line, phase, self.stroke.frequency)

        return replace(
            self.stroke,
            left=_SteeredPitch(stroke=self.stroke.left, command=command, sign=-1.0),
            right=_SteeredPitch(stroke=self.stroke.right, command=command, sign=1.0),
        )

    def _sense(self, first: int, last: int) -> None:
        """Write the demand at instants `first` to `last`, both included."""
        samples = self.samples[first : last + 1]
        heading = headings(samples)
        heading[0] += 2 * np.pi * np.round((self.heading - heading[0, 0]) / (2 * np.pi))  # no jump between pieces
        self.heading = float(heading[0, -1])
        heading[0] -= self.aim
        motion = BodyMotion(heading=heading, yaw_rate=yaw_rates(samples))
        sensed = self.feedback.sensor.sensed(motion, self.sensed, self.step)
        command, slope, self.integral = self.feedback.demand(sensed, self.integral, self.step)
        self.line.write(first, command, slope)
        self.sensed = sensed[:, -1]

    def _result(self, done: int, status: str, error: StepError | None) -> ControlledFlight:
        per_beat, stride = self.settings.samples, self.settings.steps // self.settings.samples
        end = done + 1 if status == "complete" else done
        phase = np.arange(0, end, stride) / self.settings.steps
        flight = trajectory_of(self.samples[:end:stride], phase, self.stroke.frequency, per_beat)
        command = self.feedback.command(self.line, phase, self.stroke.frequency)[0]
        flown = replace(flight, wingbeats=done // self.settings.steps, status=status, step_error=error)
        if self.settings.estimate_error:
            first = first_wingbeat(self.samples[:end:stride][:per_beat], self.stroke.frequency, per_beat)
            flown = replace(flown, quadrature_error=estimate_quadrature_error(self.fly, first))
        return ControlledFlight(trajectory=flown, command=command)


@dataclass(frozen=True, slots=True, kw_only=True)
class _SteeredPitch:
    """A stroke whose pitch, or rest angle, moves by what the controller asks for: right wing up, left wing down."""

    stroke: WingStroke
    command: Callable[[FloatArray], FloatArray]
    sign: float

    @property
    def periodic(self) -> bool:
        return False

    def __call__(self, phase: FloatArray) -> PhasedAngles:
        plain, asked = self.stroke(phase), self.sign * self.command(phase)
        angles, first, second = plain.angles.copy(), plain.first.copy(), plain.second.copy()
        angles[:, 2] += asked[0]
        first[:, 2] += asked[1]
        second[:, 2] += asked[2]
        return PhasedAngles(angles=angles, first=first, second=second)


def _refuse_held_yaw(fly: FlappingFly) -> None:
    if not fly.body.yaw:
        raise InvalidParameterError(
            "Yaw control needs a body that can yaw, and this one's yaw is held; fly it with body=YAW_ONLY, as on a "
            "magnetic tether, or FREE."
        )


def _refuse_deaf_hinges(fly: FlappingFly) -> None:
    kinds = {type(hinge.pitch) for hinge in (fly.left, fly.right)}
    if kinds not in ({Prescribed}, {SteeredSpring}):
        raise InvalidParameterError(
            "Yaw control moves the pitch of both wings: both pitch joints must be Prescribed (it paddles them) or both "
            "a SteeredSpring (it biases their rest angles)."
        )

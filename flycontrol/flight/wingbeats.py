"""The march through a flight, wingbeat by wingbeat, and what it keeps between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.drive import drive_table, repeats
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.march import FASTEST, FASTEST_SPIN, LEFT, SAMPLE, SPIN, VELOCITY, march, sample_now
from flycontrol.flight.multibody.constants import constants_of
from flycontrol.flight.pulses import BodyPulse, outside_loads
from flycontrol.flight.quadrature_error import estimate_quadrature_error
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import AT_REST, first_wingbeat, level_start, packed, trajectory_of, unpacked
from flycontrol.flight.step_error import coarse_end, halving_error, step_error_between
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState, QuadratureError, StepError, Trajectory

FloatArray = NDArray[np.float64]

#: The stroke of a wingbeat, given its number and the state at its beginning; the frequency must not change.
Steering = Callable[[int, FlightState], StrokeKinematics]


class Errors(TypedDict, total=False):
    """Fields of a trajectory that say how far it can be trusted."""

    step_error: StepError
    quadrature_error: QuadratureError | None


class March:
    """What the march keeps between wingbeats."""

    def __init__(
        self,
        fly: FlappingFly,
        stroke: StrokeKinematics | Steering,
        pulses: Sequence[BodyPulse],
        settings: MarchSettings,
        start: FlightState | None,
    ) -> None:
        self.fly, self.pulses, self.settings = fly, pulses, settings
        self.steering = None if isinstance(stroke, StrokeKinematics) else stroke
        self.stroke = stroke if isinstance(stroke, StrokeKinematics) else stroke(0, start or AT_REST)
        self.y = packed(start or level_start(self.stroke))
        self.constants = constants_of(fly, self.stroke.frequency)
        self.step = 1.0 / (self.stroke.frequency * settings.steps)
        self.drive: FloatArray | None = None
        self.calm = np.zeros((settings.steps, 6))

    def chunk(self, first: int, count: int) -> Trajectory:
        """Wingbeats `first` to `first + count`, or those before it diverged."""
        per_beat, steps = self.settings.samples, self.settings.steps
        samples = np.empty((count * per_beat + 1, SAMPLE))
        errors: Errors = {}
        status, stored = "complete", 0
        for beat in range(first, first + count):
            drive, outside = self._beat(beat)
            start = self.y.copy()
            room = samples[stored : stored + per_beat]
            done = march(self.y, drive, self.step, outside, steps // per_beat, *self.constants.arguments, room)
            stored += per_beat * done // steps
            if beat == 0 and self.settings.estimate_error:
                errors = self._errors(start, drive, outside, samples[:stored])
            if done < steps:
                status = diverged(beat, self.y) or f"stopped in wingbeat {beat}: a free wing joint runs away."
                break
            sample_now(self.y, drive, outside, *self.constants.arguments, samples[stored])
        phase = first + np.arange(stored + (status == "complete")) / per_beat
        trajectory = trajectory_of(samples[: len(phase)], phase, self.stroke.frequency, per_beat)
        return replace(trajectory, wingbeats=first + stored // per_beat, status=status, **errors)

    def step_error(self, beat: int) -> StepError:
        """What the steps get wrong in one wingbeat from the present state, which stays as it is."""
        drive, outside = self._beat(beat)
        fine, steps = self.y.copy(), self.settings.steps
        march(fine, drive, self.step, outside, steps, *self.constants.arguments, np.empty((1, SAMPLE)))
        return halving_error(coarse_end(self.y, drive, self.step, outside, self.constants), fine)

    def _errors(self, start: FloatArray, drive: FloatArray, outside: FloatArray, samples: FloatArray) -> Errors:
        """What steps and blades get wrong in the first wingbeat."""
        coarse = coarse_end(start, drive, self.step, outside, self.constants)
        step_error = step_error_between(coarse, self.y, self.step, self.settings)
        flown = first_wingbeat(samples, self.stroke.frequency, self.settings.samples)
        return {"step_error": step_error, "quadrature_error": estimate_quadrature_error(self.fly, flown)}

    def _beat(self, beat: int) -> tuple[FloatArray, FloatArray]:
        """Drive at half steps and loads from outside of one wingbeat."""
        if self.steering is not None and beat > 0:
            self.stroke, self.drive = self._steered(self.steering(beat, unpacked(self.y))), None
        if self.drive is None or not repeats(self.fly, self.stroke):
            phase = beat + np.arange(2 * self.settings.steps + 1) / (2 * self.settings.steps)
            self.drive = drive_table(self.fly, self.stroke, phase)
        if not self.pulses:
            return self.drive, self.calm
        return self.drive, outside_loads(self.pulses, beat / self.stroke.frequency, self.step, self.settings.steps)

    def _steered(self, stroke: StrokeKinematics) -> StrokeKinematics:
        if stroke.frequency != self.stroke.frequency:
            raise InvalidParameterError(
                f"Steering asked for {stroke.frequency!r} Hz in a flight of {self.stroke.frequency!r} Hz; the wingbeat "
                "frequency stays as it is within one flight."
            )
        return stroke


def whole_wingbeats(count: object) -> int:
    """How many wingbeats to fly; InvalidParameterError if that is no whole number of at least one."""
    if not (isinstance(count, int | float | np.integer | np.floating) and count >= 1 and count % 1 == 0):
        raise InvalidParameterError(f"A flight needs at least one wingbeat, and whole ones, got {count!r}.")
    return int(count)


def diverged(beat: int, y: FloatArray) -> str:
    """A sentence when a state (its first 13 entries are the body's) is none of a fly, else nothing."""
    speed, spin = float(np.linalg.norm(y[VELOCITY:SPIN])), float(np.linalg.norm(y[SPIN:LEFT]))
    if speed < FASTEST and spin < FASTEST_SPIN:
        return ""
    return (
        f"stopped in wingbeat {beat}: the body moves at {speed:.3g} m/s and turns at {spin:.3g} rad/s, which no fly "
        "does; what was flown until then is kept. Look at the forces before it, or take smaller steps."
    )

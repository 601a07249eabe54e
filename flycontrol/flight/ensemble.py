"""Many flights at once on one core: lanes of flies with prescribed wings, each with its own body, stroke and pulses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.drive import drive_table, repeats
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.lanes import BODY_STATES, LANE_DRIVE, LANES, march_lanes
from flycontrol.flight.kernels.march import LEFT, SAMPLE, STATES, VELOCITY
from flycontrol.flight.lanes import LaneConstants, drive_in_lanes, filled_up, in_lanes, lane_constants
from flycontrol.flight.pulses import BodyPulse, outside_loads
from flycontrol.flight.quadrature_error import estimate_quadrature_error
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import first_wingbeat, level_start, packed, trajectory_of
from flycontrol.flight.step_error import every_second, step_error_between
from flycontrol.flight.wingbeats import Errors, diverged, whole_wingbeats
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState, Trajectory

FloatArray = NDArray[np.float64]

SLOW = 50.0  #: m/s and rad/s: no need to look further whether a fly can be so fast
BODY_SAMPLE = BODY_STATES + 6  #: a state of the body and its accelerations


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightPlan:
    """One flight of an ensemble."""

    fly: FlappingFly
    stroke: StrokeKinematics
    start: FlightState | None = None  #: None: at rest, stroke plane level
    pulses: tuple[BodyPulse, ...] = ()


def simulate_flights(
    plans: Sequence[FlightPlan], wingbeats: int, *, settings: MarchSettings | None = None
) -> list[Trajectory]:
    """Fly all plans for so many wingbeats; the results are those of `simulate_flight`, several times as fast.

    Parameters
    ----------
    plans
        Flies, strokes, starts and pulses, any number. Wings are prescribed; body freedoms, gravity, coefficients and
        the number of blades are shared.
    wingbeats
        How many, at least one.
    settings
        Steps and samples a wingbeat.

    Returns
    -------
    list of Trajectory
        In the order of the plans. A flight that diverges keeps what it has and says so in its status.

    Raises
    ------
    InvalidParameterError
        Plans that cannot fly together, or a step too coarse for the tolerance.
    """
    if not plans:
        raise InvalidParameterError("An ensemble needs a plan, got none.")
    at_once = replace(settings or MarchSettings(), chunk=whole_wingbeats(wingbeats))  # everything is kept anyway
    groups = [plans[first : first + LANES] for first in range(0, len(plans), LANES)]
    return [flight for group in groups for flight in next(ensemble_chunks(group, wingbeats, settings=at_once))]


def ensemble_chunks(
    plans: Sequence[FlightPlan], wingbeats: int, *, settings: MarchSettings | None = None
) -> Iterator[list[Trajectory]]:
    """Up to LANES flights in pieces of `settings.chunk` wingbeats: memory does not grow with their length."""
    settings = settings or MarchSettings()
    if len(plans) > LANES:
        raise InvalidParameterError(f"At most {LANES} flights share the lanes, got {len(plans)}; use simulate_flights.")
    lanes = _Lanes(plans, settings)
    for first in range(0, wingbeats, settings.chunk):
        yield lanes.chunk(first, min(settings.chunk, wingbeats - first))[: len(plans)]


class _Lanes:
    """What the lanes keep between wingbeats."""

    def __init__(self, plans: Sequence[FlightPlan], settings: MarchSettings) -> None:
        self.settings, self.count = settings, len(plans)
        self.plans: list[FlightPlan] = filled_up(plans)
        self.constants: LaneConstants = lane_constants(
            [plan.fly for plan in self.plans], [plan.stroke for plan in self.plans]
        )
        starts = [packed(plan.start or level_start(plan.stroke)) for plan in self.plans]
        self.y = in_lanes([start[:BODY_STATES] for start in starts])
        self.step = np.array([1.0 / (plan.stroke.frequency * settings.steps) for plan in self.plans])
        self.repeating = all(repeats(plan.fly, plan.stroke) for plan in self.plans)
        self.pushed = any(plan.pulses for plan in self.plans)
        self.drive = self.wings = np.empty(0)
        self.outside = np.zeros((settings.steps, 6 * LANES))
        self.room = np.empty((settings.samples, BODY_SAMPLE * LANES))
        self.status = ["complete"] * LANES

    def chunk(self, first: int, count: int) -> list[Trajectory]:
        """Wingbeats `first` to `first + count` of every lane."""
        per_beat = self.settings.samples
        samples = np.empty((LANES, count * per_beat + 1, SAMPLE))
        errors: list[Errors] = [{}] * LANES
        flown = np.zeros(LANES, dtype=int)
        for beat in range(first, first + count):
            self._prepare(beat)
            coarse = self._coarsely() if beat == 0 and self.settings.estimate_error else None
            at = (beat - first) * per_beat
            self._fly(samples[:, at : at + per_beat + 1])
            flown += self._flying(beat)
            if coarse is not None:
                errors = filled_up([self._errors(k, coarse, samples[k, :per_beat]) for k in range(self.count)])
        self._sample_end(samples[:, -1:])
        return [self._trajectory(lane, first, flown[lane], samples[lane], errors[lane]) for lane in range(LANES)]

    def _prepare(self, beat: int) -> None:
        """Drive at half steps and loads from outside of one wingbeat."""
        steps, stride = self.settings.steps, self.settings.steps // self.settings.samples
        if beat == 0 or not self.repeating:
            phase = beat + np.arange(2 * steps + 1) / (2 * steps)
            drives = [drive_table(plan.fly, plan.stroke, phase) for plan in self.plans]
            self.drive = drive_in_lanes(drives)
            self.wings = np.stack([_by_kind(own[:: 2 * stride]) for own in drives])
        if self.pushed:
            loads = [
                outside_loads(plan.pulses, beat / plan.stroke.frequency, step, steps)
                for plan, step in zip(self.plans, self.step, strict=True)
            ]
            self.outside = np.ascontiguousarray(np.stack(loads, axis=-1)).reshape(steps, -1)

    def _fly(self, samples: FloatArray) -> None:
        """One wingbeat; its samples (LANES, n + 1, 37) are stored, but the body's at its end."""
        stride = self.settings.steps // self.settings.samples
        march_lanes(self.y, self.drive, self.step, self.outside, stride, *self.constants.arguments, self.room)
        _store_body(samples[:, :-1], self.room)
        samples[:, :, LEFT:STATES] = self.wings[:, :, : STATES - LEFT]
        samples[:, :, STATES + 6 :] = self.wings[:, :, STATES - LEFT :]

    def _coarsely(self) -> FloatArray:
        """Where a wingbeat ends with half the steps."""
        y, outside, drive = self.y.copy(), every_second(self.outside), np.ascontiguousarray(self.drive[::2])
        room = np.empty((1, BODY_SAMPLE * LANES))
        march_lanes(y, drive, 2 * self.step, outside, len(outside), *self.constants.arguments, room)
        return y.reshape(BODY_STATES, LANES)

    def _errors(self, lane: int, coarse: FloatArray, samples: FloatArray) -> Errors:
        """What steps and blades get wrong in the first wingbeat."""
        plan, fine = self.plans[lane], self.y.reshape(BODY_STATES, LANES)[:, lane]
        step_error = step_error_between(coarse[:, lane], fine, float(self.step[lane]), self.settings)
        flown = first_wingbeat(samples, plan.stroke.frequency, self.settings.samples)
        return {"step_error": step_error, "quadrature_error": estimate_quadrature_error(plan.fly, flown)}

    def _flying(self, beat: int) -> NDArray[np.bool_]:
        """Lanes that still fly after a wingbeat; the status of the others says where they stopped."""
        states = self.y.reshape(BODY_STATES, LANES)
        for lane in np.flatnonzero(~(np.max(np.abs(states[VELOCITY:]), axis=0) < SLOW)):
            if self.status[lane] == "complete":
                self.status[lane] = diverged(beat, states[:, lane]) or "complete"
        return np.array([status == "complete" for status in self.status])

    def _sample_end(self, samples: FloatArray) -> None:
        """The body's state and accelerations at the end: those at the beginning of a step that is not kept."""
        still, room = np.ascontiguousarray(np.repeat(self.drive[-1:], 3, axis=0)), self.room[:1]
        march_lanes(self.y.copy(), still, self.step, self.outside[-1:], 1, *self.constants.arguments, room)
        _store_body(samples, room)

    def _trajectory(self, lane: int, first: int, flown: int, samples: FloatArray, errors: Errors) -> Trajectory:
        per_beat, status = self.settings.samples, self.status[lane]
        kept = flown * per_beat + (status == "complete")
        phase = first + np.arange(kept) / per_beat
        flight = trajectory_of(samples[:kept], phase, self.plans[lane].stroke.frequency, per_beat)
        return replace(flight, wingbeats=first + flown, status=status, **errors)


def _store_body(samples: FloatArray, room: FloatArray) -> None:
    """States and accelerations of the body from rows in lanes (n, 19 * LANES) to (LANES, n, 37)."""
    body = room.reshape(len(room), BODY_SAMPLE, LANES).transpose(2, 0, 1)
    samples[:, :, :LEFT], samples[:, :, STATES : STATES + 6] = body[:, :, :LEFT], body[:, :, LEFT:]


def _by_kind(drive: FloatArray) -> FloatArray:
    """(n, 18) angles, rates, accelerations, each of the left and the right wing, from a drive table (n, 2, 12)."""
    return drive[:, :, :LANE_DRIVE].reshape(-1, 2, 3, 3).swapaxes(1, 2).reshape(len(drive), -1)

"""Many flights at once on one core: lanes of flies with prescribed wings, each with its own body, stroke and pulses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.drive import drive_table, repeats
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.lanes import BODY_STATES, LANES, march_lanes
from flycontrol.flight.kernels.march import LEFT, SAMPLE, STATES
from flycontrol.flight.lanes import LaneConstants, drive_in_lanes, filled_up, in_lanes, lane_constants
from flycontrol.flight.multibody.constants import constants_of
from flycontrol.flight.pulses import BodyPulse, outside_loads
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import joined
from flycontrol.flight.state_vector import level_start, packed, trajectory_of
from flycontrol.flight.step_error import estimate_step_error
from flycontrol.flight.wingbeats import diverged
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState, StepError, Trajectory

FloatArray = NDArray[np.float64]

SLOW = 50.0  #: no entry of a state beyond it: no need to look whether a fly can be so fast


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
    if not plans or wingbeats < 1:
        raise InvalidParameterError(f"An ensemble needs a plan and a wingbeat, got {len(plans)} and {wingbeats!r}.")
    flights: list[Trajectory] = []
    for first in range(0, len(plans), LANES):
        group = plans[first : first + LANES]
        pieces = zip(*ensemble_chunks(group, wingbeats, settings=settings), strict=True)
        flights += [_up_to_the_end(list(chunks)) for chunks in pieces]
    return flights


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
        self.starts = [packed(plan.start or level_start(plan.stroke)) for plan in self.plans]
        self.y = in_lanes([start[:BODY_STATES] for start in self.starts])
        self.step = np.array([1.0 / (plan.stroke.frequency * settings.steps) for plan in self.plans])
        self.drives: list[FloatArray] = []
        self.drive = np.empty(0)
        self.outside = self.calm = np.zeros((settings.steps, 6 * LANES))
        self.status = ["complete"] * LANES

    def chunk(self, first: int, count: int) -> list[Trajectory]:
        """Wingbeats `first` to `first + count` of every lane."""
        per_beat, stride = self.settings.samples, self.settings.steps // self.settings.samples
        samples = np.empty((count * per_beat + 1, 19 * LANES))
        wings = np.empty((LANES, count * per_beat + 1, 2, 12))
        errors: list[StepError | None] = [None] * LANES
        flown = np.zeros(LANES, dtype=int)
        for beat in range(first, first + count):
            self._prepare(beat)
            if beat == 0 and self.settings.estimate_error:
                errors = filled_up([self._step_error(lane) for lane in range(self.count)])
            at = (beat - first) * per_beat
            room = samples[at : at + per_beat]
            march_lanes(self.y, self.drive, self.step, self.outside, stride, *self.constants.arguments, room)
            for lane, own in enumerate(self.drives):
                wings[lane, at : at + per_beat + 1] = own[:: 2 * stride]
            flown += self._flying(beat)
        self._sample_end(samples[-1:])
        return [self._trajectory(lane, first, flown[lane], samples, wings[lane], errors[lane]) for lane in range(LANES)]

    def _prepare(self, beat: int) -> None:
        """Drive at half steps and loads from outside of one wingbeat."""
        steps = self.settings.steps
        if not self.drives or not all(repeats(plan.fly, plan.stroke) for plan in self.plans):
            phase = beat + np.arange(2 * steps + 1) / (2 * steps)
            self.drives = [drive_table(plan.fly, plan.stroke, phase) for plan in self.plans]
            self.drive = drive_in_lanes(self.drives)
        self.outside = self.calm
        if any(plan.pulses for plan in self.plans):
            loads = [
                outside_loads(plan.pulses, beat / plan.stroke.frequency, step, steps)
                for plan, step in zip(self.plans, self.step, strict=True)
            ]
            self.outside = np.ascontiguousarray(np.stack(loads, axis=-1)).reshape(steps, -1)

    def _step_error(self, lane: int) -> StepError:
        plan, step = self.plans[lane], float(self.step[lane])
        outside = outside_loads(plan.pulses, 0.0, step, self.settings.steps)
        constants = constants_of(plan.fly, plan.stroke.frequency)
        return estimate_step_error(self.starts[lane], self.drives[lane], step, outside, constants, self.settings)

    def _flying(self, beat: int) -> NDArray[np.bool_]:
        """Lanes that still fly after a wingbeat; the status of the others says where they stopped."""
        states = self.y.reshape(BODY_STATES, LANES)
        for lane in np.flatnonzero(~(np.max(np.abs(states), axis=0) < SLOW)):
            if self.status[lane] == "complete":
                self.status[lane] = diverged(beat, states[:, lane]) or "complete"
        return np.array([status == "complete" for status in self.status])

    def _sample_end(self, room: FloatArray) -> None:
        """States and accelerations at the end of a wingbeat: at the beginning of a step that is not kept."""
        still = np.ascontiguousarray(np.repeat(self.drive[-1:], 3, axis=0))
        march_lanes(self.y.copy(), still, self.step, self.outside[-1:], 1, *self.constants.arguments, room)

    def _trajectory(
        self, lane: int, first: int, flown: int, samples: FloatArray, wings: FloatArray, error: StepError | None
    ) -> Trajectory:
        per_beat, status = self.settings.samples, self.status[lane]
        kept = flown * per_beat + (status == "complete")
        phase = first + np.arange(kept) / per_beat
        body = samples.reshape(len(samples), -1, LANES)[:kept, :, lane]
        own = np.empty((kept, SAMPLE))
        own[:, :LEFT], own[:, STATES : STATES + 6] = body[:, :BODY_STATES], body[:, BODY_STATES:]
        own[:, LEFT:STATES] = wings[:kept, :, :6].reshape(kept, 2, 2, 3).swapaxes(1, 2).reshape(kept, 12)
        own[:, STATES + 6 :] = wings[:kept, :, 6:9].reshape(kept, 6)
        flight = trajectory_of(own, phase, self.plans[lane].stroke.frequency, per_beat)
        return replace(flight, wingbeats=first + flown, status=status, step_error=error)


def _up_to_the_end(chunks: list[Trajectory]) -> Trajectory:
    """Pieces of one flight until it stopped, if it did."""
    ended = next((k for k, chunk in enumerate(chunks) if not chunk.complete), len(chunks) - 1)
    return joined(chunks[: ended + 1])

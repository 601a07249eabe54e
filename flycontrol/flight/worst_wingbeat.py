"""Which wingbeat of a flight its steps suit worst: those with pulses, ramps and the last one are repeated too."""

from __future__ import annotations

from collections.abc import Mapping
from math import floor

import numpy as np

from flycontrol.flight.experiments import PlannedFlight
from flycontrol.flight.step_error import refuse_coarse
from flycontrol.flight.wingbeats import March
from flycontrol.model.trajectory import FlightState, StepError, Trajectory, wing_angles, wing_rates

_ONTO = 1e-9  #: wingbeats by which a pulse may begin before the one that it is meant for, by rounding


def steepest_wingbeats(planned: PlannedFlight) -> tuple[int, ...]:
    """Those in which the strongest pulse begins and in which each ramp is half done."""
    asked, plan = planned.experiment, planned.plan
    beats = {floor(sum(change.ramp) / 2) for change in asked.steering if change.ramp is not None}
    if plan.pulses:
        strongest = max(plan.pulses, key=lambda pulse: float(np.linalg.norm(pulse.torque_S)))
        beats.add(floor(strongest.start * planned.frequency + _ONTO))
    return tuple(sorted(beat for beat in beats if 0 <= beat < asked.wingbeats))


def step_errors(planned: PlannedFlight, piece: Trajectory) -> dict[int, StepError]:
    """Errors of the steepest wingbeats, and of the flight's last one, that a piece holds.

    Raises
    ------
    InvalidParameterError
        The steps are too coarse for a pulse or a ramp. What grows in a flight without control is told, not refused.
    """
    first, last = (round(float(piece.phase[k])) for k in (0, -1))
    steepest = steepest_wingbeats(planned)
    found: dict[int, StepError] = {}
    for beat in {*steepest, planned.experiment.wingbeats - 1}:
        if not first <= beat < min(last, piece.wingbeats):
            continue
        start = _state(piece, (beat - first) * piece.samples_per_wingbeat)
        march = March(planned.plan.fly, planned.plan.stroke, planned.plan.pulses, planned.settings, start)
        found[beat] = march.step_error(beat)
        if beat in steepest:
            refuse_coarse(found[beat], march.step, planned.settings, beat)
    return found


def worst(errors: Mapping[int, StepError]) -> tuple[int, StepError] | None:
    """Number and error of the wingbeat whose angles err most."""
    if not errors:
        return None
    return max(errors.items(), key=lambda one: (max(one[1].attitude, one[1].wing_angle), one[1].angular_velocity))


def _state(flight: Trajectory, index: int) -> FlightState:
    left, right = flight.left, flight.right
    return FlightState(
        position_W=flight.position_W[index],
        q_WS=flight.q_WS[index],
        velocity_S=flight.velocity_S[index],
        angular_velocity_S=flight.angular_velocity_S[index],
        left_angles=wing_angles(left)[index],
        left_rates=wing_rates(left)[index],
        right_angles=wing_angles(right)[index],
        right_rates=wing_rates(right)[index],
    )

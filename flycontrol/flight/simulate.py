"""Flights of a flapping fly, wingbeat by wingbeat.

    M(x) (v', w', q'') = forces(x, t),  x = (position, attitude, v, w, q, q')

by classical Runge-Kutta steps of 1 / (frequency * steps), attitude a unit quaternion.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.pulses import BodyPulse, refuse_idle_pulses
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.wingbeats import March, Steering, whole_wingbeats
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState, Trajectory


def simulate_flight(
    fly: FlappingFly,
    stroke: StrokeKinematics | Steering,
    wingbeats: int,
    *,
    start: FlightState | None = None,
    pulses: Sequence[BodyPulse] = (),
    settings: MarchSettings | None = None,
) -> Trajectory:
    """Fly so many wingbeats.

    Parameters
    ----------
    fly
        Morphology, air, freedoms of body and hinges.
    stroke
        What prescribed joints follow, or a function that is asked for it before every wingbeat (a controller); its
        strokes are read at the flight's own phase, k to k + 1 for wingbeat k.
    wingbeats
        How many, at least one.
    start
        State at phase 0; by default `level_start`: at rest, stroke plane level, wings where the stroke begins.
    pulses
        Forces and torques from outside, each of them during the flight, at least in part.
    settings
        Steps and samples a wingbeat.

    Returns
    -------
    Trajectory
        N = wingbeats * samples + 1 instants. A diverging run stops; its status says at which wingbeat and why, and
        what was flown until then is kept.

    Raises
    ------
    InvalidParameterError
        The step is too coarse for the tolerance (with the number of steps that would do), a pulse never acts, or an
        input is impossible.
    """
    at_once = replace(settings or MarchSettings(), chunk=whole_wingbeats(wingbeats))  # everything is kept anyway
    (flight,) = flight_chunks(fly, stroke, wingbeats, start=start, pulses=pulses, settings=at_once)
    return flight


def flight_chunks(
    fly: FlappingFly,
    stroke: StrokeKinematics | Steering,
    wingbeats: int,
    *,
    start: FlightState | None = None,
    pulses: Sequence[BodyPulse] = (),
    settings: MarchSettings | None = None,
) -> Iterator[Trajectory]:
    """`simulate_flight` in pieces of `settings.chunk` wingbeats, as they are flown: memory does not grow with it.

    The last instant of a piece is the first of the next one.
    """
    wingbeats, settings = whole_wingbeats(wingbeats), settings or MarchSettings()
    march = March(fly, stroke, pulses, settings, start)
    refuse_idle_pulses(pulses, wingbeats, march.stroke.frequency)
    for first in range(0, wingbeats, settings.chunk):
        chunk = march.chunk(first, min(settings.chunk, wingbeats - first))
        yield chunk
        if not chunk.complete:
            return

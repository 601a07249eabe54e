"""An experiment flown many times, each time by another fly, stroke and pulse drawn about its own."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import cast

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.ensemble import FlightPlan
from flycontrol.flight.experiments import PlannedFlight
from flycontrol.flight.monte_carlo import ensemble_work
from flycontrol.jobs.packed import Result
from flycontrol.jobs.work import Work
from flycontrol.model.flight_experiment import Ensemble
from flycontrol.model.morphology import Matrix, Morphology
from flycontrol.model.steering import Steering
from flycontrol.model.trajectory import Trajectory
from flycontrol.model.wing_stroke import Modulation

FloatArray = NDArray[np.float64]

_MOST_INSTANTS = 200  #: kept of each flight
ANGLES = ("yaw", "nose_up", "roll")


@dataclass(frozen=True, slots=True, kw_only=True)
class FlownEnsemble:
    """What M flights of an ensemble did, at K instants; NaN after a flight stopped."""

    phase: FloatArray  #: (K,) [wingbeats]
    yaw: FloatArray  #: (M, K) heading, to the right [rad]
    nose_up: FloatArray  #: (M, K) [rad]
    roll: FloatArray  #: (M, K) right side down [rad]
    wingbeats: NDArray[np.int64]  #: (M,) flown
    status: tuple[str, ...]  #: "complete", or a sentence

    @property
    def flights(self) -> int:
        """How many."""
        return len(self.status)


def experiment_ensemble(planned: PlannedFlight, ensemble: Ensemble) -> Work:
    """The ensemble of an experiment as work for all cores; `flown_ensemble` reads its results."""
    beats = planned.experiment.wingbeats
    return ensemble_work(
        partial(drawn_plan, planned=planned, ensemble=ensemble),
        flights=ensemble.flights,
        wingbeats=beats,
        seed=ensemble.seed,
        fold=partial(_attitude, apart=_apart(planned)),
        settings=replace(planned.settings, estimate_error=False),
    )


def flown_ensemble(planned: PlannedFlight, groups: list[Result]) -> FlownEnsemble:
    """Gather the results of `experiment_ensemble`."""
    flights = [cast("dict[str, Result]", flight) for group in groups for flight in cast("list[Result]", group)]
    apart = _apart(planned)
    count = planned.experiment.wingbeats // apart + 1
    angles = {name: np.full((len(flights), count), np.nan) for name in ANGLES}
    for row, flight in enumerate(flights):
        for name in ANGLES:
            values = np.asarray(flight[name])
            angles[name][row, : len(values)] = values
    return FlownEnsemble(
        phase=apart * np.arange(count, dtype=np.float64),
        **angles,
        wingbeats=np.array([int(cast(int, flight["wingbeats"])) for flight in flights]),
        status=tuple(str(flight["status"]) for flight in flights),
    )


def drawn_plan(generator: np.random.Generator, *, planned: PlannedFlight, ensemble: Ensemble) -> FlightPlan:
    """One flight, drawn: mass, wings, both wings' stroke, each wing's pitch, the pulses."""
    spread, plan = ensemble.spread, planned.plan
    mass, length, gain, offset, deviation, left, right, torque, onset = generator.standard_normal(9)
    stroke = Modulation(
        stroke_gain=spread.stroke_gain * gain,
        stroke_offset=spread.stroke_offset * offset,
        deviation_offset=spread.deviation_offset * deviation,
    )
    steering = Steering(
        left=replace(stroke, pitch_offset=spread.pitch_offset * left),
        right=replace(stroke, pitch_offset=spread.pitch_offset * right),
    )
    pulses = tuple(
        replace(
            pulse,
            start=pulse.start + spread.onset * onset,
            torque_S=cast(
                "tuple[float, float, float]", tuple((1 + spread.torque * torque) * n for n in pulse.torque_S)
            ),
        )
        for pulse in plan.pulses
    )
    morphology = _drawn(plan.fly.morphology, 1 + spread.mass * mass, 1 + spread.wing_length * length)
    return replace(
        plan, fly=replace(plan.fly, morphology=morphology), stroke=steering.applied(plan.stroke), pulses=pulses
    )


def _drawn(morphology: Morphology, mass: float, length: float) -> Morphology:
    """Inertia goes with the mass, the chord with the wing's length."""
    inertia = tuple(tuple(mass * value for value in row) for row in morphology.inertia)
    return replace(
        morphology,
        mass=mass * morphology.mass,
        inertia=cast(Matrix, inertia),
        wing_length=length * morphology.wing_length,
        mean_chord=length * morphology.mean_chord,
    )


def _apart(planned: PlannedFlight) -> int:
    """Wingbeats between the instants that are kept."""
    return math.ceil(planned.experiment.wingbeats / _MOST_INSTANTS)


def _attitude(before: Result, piece: Trajectory, *, apart: int) -> Result:
    """Keep the attitude at the beginning of every so manyth wingbeat, and at the end."""
    per_beat = piece.samples_per_wingbeat * apart
    known = cast("dict[str, Result]", before) if isinstance(before, dict) else None
    if known is not None and known["status"] != "complete":
        return known
    first = round(float(piece.phase[0]) * piece.samples_per_wingbeat) if len(piece.phase) else 0
    number = first + np.arange(len(piece.phase))
    wanted = number % per_beat == 0
    wanted[:1] &= known is None
    found: dict[str, Result] = {"wingbeats": piece.wingbeats, "status": piece.status}
    for name in ANGLES:
        values = getattr(piece, name)[wanted]
        if known is not None:
            earlier = np.asarray(known[name], dtype=np.float64)
            values = np.concatenate([earlier, values])
        found[name] = np.unwrap(values) if name != "nose_up" else values
    return found

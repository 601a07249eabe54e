"""A flight experiment as the simulator takes it: the flapping fly, its pulses, how finely it is flown."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import cast

from flycontrol.flight.coefficients import CoefficientName
from flycontrol.flight.ensemble import FlightPlan
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.multibody.freedoms import FREE, BodyFreedoms, Hinge, Prescribed, TorqueDriven
from flycontrol.flight.multibody.freedoms import Joint as HingeJoint
from flycontrol.flight.pulses import BodyPulse
from flycontrol.flight.quasi_steady import QuasiSteadyModel, Term
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import flight_chunks
from flycontrol.flight.trim import HoverTrim, hover_trim, tethered_trim
from flycontrol.model.flight_experiment import (
    FREEDOMS,
    Air,
    FlightExperiment,
    Joint,
    TorqueJoint,
    WingJoints,
    refuse_pulses_outside,
)
from flycontrol.model.trajectory import Trajectory


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedFlight:
    """An experiment ready to be flown."""

    experiment: FlightExperiment
    plan: FlightPlan
    settings: MarchSettings
    trim: HoverTrim | None  #: None: the stroke is flown as the experiment has it

    @property
    def frequency(self) -> float:
        """Wingbeats a second [1/s]."""
        return self.plan.stroke.frequency

    def chunks(self) -> Iterator[Trajectory]:
        """Fly, piece by piece."""
        plan = self.plan
        return flight_chunks(
            plan.fly,
            plan.stroke,
            self.experiment.wingbeats,
            start=plan.start,
            pulses=plan.pulses,
            settings=self.settings,
        )


def planned_flight(experiment: FlightExperiment) -> PlannedFlight:
    """Trim the stroke if the experiment asks for it, steer it, and place the pulses.

    A body that is free in all six ways is trimmed on its periodic orbit, any other one as if it were held.

    Raises
    ------
    InvalidParameterError
        No hover is found, or the steps do not suit.
    InvalidInputError
        A pulse lies outside the flight at the trimmed frequency.
    """
    fly, settings = flapping_fly(experiment), march_settings(experiment)
    found = _trimmed(fly, experiment, settings)
    stroke = experiment.stroke if found is None else found.kinematics
    refuse_pulses_outside(experiment.pulses, experiment.wingbeats, stroke.frequency)
    plan = FlightPlan(
        fly=fly,
        stroke=experiment.steered(stroke),
        start=None if found is None else found.start,
        pulses=body_pulses(experiment, stroke.frequency),
    )
    return PlannedFlight(experiment=experiment, plan=plan, settings=settings, trim=found)


def body_pulses(experiment: FlightExperiment, frequency: float) -> tuple[BodyPulse, ...]:
    """The pulses at a wingbeat frequency [1/s]."""
    return tuple(
        BodyPulse(start=pulse.onset.at(frequency), duration=pulse.duration.at(frequency), torque_S=pulse.torque_S)
        for pulse in experiment.pulses
    )


def _trimmed(fly: FlappingFly, experiment: FlightExperiment, settings: MarchSettings) -> HoverTrim | None:
    if not experiment.trim:
        return None
    trim = hover_trim if fly.body == FREE else tethered_trim
    first, second, third = experiment.trim
    return trim(fly, experiment.stroke, (first, second, third), body_pitch=experiment.body_pitch, settings=settings)


def flapping_fly(experiment: FlightExperiment) -> FlappingFly:
    """Body, wings, air, and what may move."""
    left = _hinge(experiment.left)
    return FlappingFly(
        morphology=experiment.morphology,
        air=_air(experiment.air),
        body=BodyFreedoms(**{name: name in experiment.free for name in FREEDOMS}),
        left=left,
        right=left if experiment.right == experiment.left else _hinge(experiment.right),
    )


def march_settings(experiment: FlightExperiment) -> MarchSettings:
    """Steps, samples and tolerance."""
    return MarchSettings(steps=experiment.steps, samples=experiment.samples, tolerance=experiment.tolerance)


def _air(air: Air) -> QuasiSteadyModel:
    return QuasiSteadyModel(
        coefficients=cast(CoefficientName, air.coefficients),
        air_density=air.density,
        nodes=air.nodes,
        terms=cast("tuple[Term, ...]", air.terms),
    )


def _hinge(joints: WingJoints) -> Hinge:
    return Hinge(stroke=_joint(joints.stroke), deviation=_joint(joints.deviation), pitch=_joint(joints.pitch))


def _joint(joint: Joint) -> HingeJoint:
    if joint is None:
        return Prescribed()
    return TorqueDriven(torque=joint) if isinstance(joint, TorqueJoint) else joint

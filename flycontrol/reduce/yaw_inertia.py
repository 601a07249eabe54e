"""Inertia that a yaw torque has to turn: body, wings and the air that they carry.

    J = I_body + <I_wings> + <I_air>,    I = n J n about the axis n,    1 / (n J^-1 n) where the body may roll too

The body's share is that of a rigid fly; the wings' and the air's are means over the wingbeat, found together by inverse
dynamics of a body that is accelerated about each axis while its wings beat.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.multibody.inverse import inverse_dynamics
from flycontrol.flight.quasi_steady import VACUUM
from flycontrol.reduce.steady_turn import steady_turn
from flycontrol.reduce.yaw_torque import YawExperiment

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class YawInertia:
    """Inertia about the axis through the body's centre of mass, by what has it [kg m^2]."""

    body: float  #: without wings
    wings: float  #: both, mean over the wingbeat
    air: float  #: that they carry along, mean over the wingbeat
    free: float  #: what a short torque meets when nothing holds the body from rolling

    @property
    def total(self) -> float:
        """I, of a body that turns about the axis alone [kg m^2]."""
        return self.body + self.wings + self.air


def yaw_inertia(experiment: YawExperiment) -> YawInertia:
    """About the experiment's axis, with its fly's stroke."""
    axis = np.array(experiment.axis_S)
    body = experiment.fly.morphology.inertia_S
    rigid = _tensor(replace(experiment, fly=replace(experiment.fly, air=VACUUM)))
    whole = _tensor(experiment)
    return YawInertia(
        body=float(axis @ body @ axis),
        wings=float(axis @ (rigid - body) @ axis),
        air=float(axis @ (whole - rigid) @ axis),
        free=float(1.0 / (axis @ np.linalg.solve(whole, axis))),
    )


def _tensor(experiment: YawExperiment) -> FloatArray:
    """(3, 3) mean torque per acceleration; linear, so that one acceleration of flight's own size tells it."""
    rate = experiment.kinematics.frequency**2
    columns = [_mean_torque(experiment, rate * axis) - _mean_torque(experiment, -rate * axis) for axis in np.eye(3)]
    return np.stack(columns, axis=1) / (2 * rate)


def _mean_torque(experiment: YawExperiment, acceleration: FloatArray) -> FloatArray:
    turned = steady_turn(experiment.kinematics, np.zeros(3), experiment.instants, acceleration)
    return inverse_dynamics(experiment.fly, turned).body_torque.mean(axis=0)

"""Stroke-averaged aerodynamic derivatives, and the averaged flight that they make.

    <(F, N)>(v, w) = (F, N)_0 + D (v, w),            D = d<(F, N)>/d(v, w), body at rest and level
    <M> (v', w') = D (v, w) + m g (-theta, phi, 0; ...),    phi' = p,    theta' = q

M is the mass matrix of body, wings and the air that they carry. This is flight averaged to first order in the wingbeat
over the time of the body's motion; `linearised_flight` says what the next order adds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.body_coordinates import PITCH, ROLL, attitude, natural_scales, state_at
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.flight_modes import FlightMode, modes_of_generator
from flycontrol.flight.kernels.march import QUATERNION, STATES, VELOCITY
from flycontrol.flight.multibody.freedoms import HELD
from flycontrol.flight.multibody.inverse import inverse_dynamics
from flycontrol.flight.periodic_orbit import DIFFERENCE, FINE
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import trajectory_of
from flycontrol.flight.wing_loads import loads_along
from flycontrol.flight.wingbeat_map import WingbeatMap
from flycontrol.model.stroke_kinematics import StrokeKinematics

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class StrokeDerivatives:
    """Mean loads of the air at rest, and how they answer to the body's motion; frame S, about the centre of mass."""

    fly: FlappingFly
    kinematics: StrokeKinematics
    force: FloatArray  #: (3,) at rest [N]
    torque: FloatArray  #: (3,) at rest [N m]
    matrix: FloatArray  #: (6, 6) D: rows F [N], N [N m]; columns u, v, w [m/s], p, q, r [rad/s]
    error: FloatArray  #: (6, 6) what a difference twice as wide and half as many instants change of it
    inertia: FloatArray  #: (6, 6) <M> [kg, kg m, kg m^2]
    gravity: FloatArray  #: (6, 2) force and torque of the weight by roll and pitch [N/rad, N m/rad]

    @property
    def yaw_damping(self) -> float:
        """Beta = -dN_z/dr, about the stroke plane's normal [N m s]."""
        return float(-self.matrix[5, 5])

    @property
    def state_matrix(self) -> FloatArray:
        """(8, 8) A of x' = A x, x = (u, v, w, p, q, r, phi, theta), by averaging to first order."""
        A = np.zeros((8, 8))
        A[:ROLL] = np.linalg.solve(self.inertia, np.hstack([self.matrix, self.gravity]))
        A[ROLL, 3] = A[PITCH, 4] = 1.0
        return A

    @property
    def modes(self) -> tuple[FlightMode, ...]:
        """Of the averaged flight, fastest growth first."""
        return modes_of_generator(self.state_matrix, natural_scales(self.fly, self.kinematics))


def stroke_derivatives(
    fly: FlappingFly, kinematics: StrokeKinematics, *, settings: MarchSettings = FINE
) -> StrokeDerivatives:
    """Central differences of the mean loads by body velocity and rotation, wings prescribed.

    Parameters
    ----------
    fly
        Its body freedoms do not count: the body moves steadily.
    kinematics
        A periodic stroke; of a trimmed one if the averaged flight is to be that of hover.
    settings
        The loads are averaged over `steps` instants of a wingbeat.
    """
    rest = _at_rest(fly, kinematics, settings.steps)
    coarse = np.ascontiguousarray(rest[::2])
    matrix = _derivatives(fly, kinematics, rest, DIFFERENCE)
    others = (_derivatives(fly, kinematics, rest, 2 * DIFFERENCE), _derivatives(fly, kinematics, coarse, DIFFERENCE))
    loads = _air(fly, kinematics, rest)
    return StrokeDerivatives(
        fly=fly,
        kinematics=kinematics,
        force=loads[:3],
        torque=loads[3:],
        matrix=matrix,
        error=np.sum([np.abs(other - matrix) for other in others], axis=0),
        inertia=_inertia(fly, kinematics, rest),
        gravity=_gravity(fly, kinematics, rest),
    )


def _at_rest(fly: FlappingFly, kinematics: StrokeKinematics, steps: int) -> FloatArray:
    """(steps, 37) samples of a wingbeat, body held at rest."""
    every = MarchSettings(steps=steps, samples=steps, estimate_error=False)
    return WingbeatMap(replace(fly, body=HELD), kinematics, every)(state_at(kinematics, np.zeros(8))).samples


def _air(fly: FlappingFly, kinematics: StrokeKinematics, samples: FloatArray) -> FloatArray:
    """(6,) mean force and torque of the air on both wings."""
    phase = np.arange(len(samples)) / len(samples)
    total = loads_along(fly, trajectory_of(samples, phase, kinematics.frequency, len(samples))).total
    return np.concatenate([total.force.mean(axis=0), total.torque.mean(axis=0)])


def _required(fly: FlappingFly, kinematics: StrokeKinematics, samples: FloatArray) -> FloatArray:
    """(6,) mean force and torque that must act on the body from outside."""
    phase = np.arange(len(samples)) / len(samples)
    needed = inverse_dynamics(fly, trajectory_of(samples, phase, kinematics.frequency, len(samples)))
    return np.concatenate([needed.body_force.mean(axis=0), needed.body_torque.mean(axis=0)])


def _derivatives(fly: FlappingFly, kinematics: StrokeKinematics, rest: FloatArray, difference: float) -> FloatArray:
    columns = []
    for k, step in enumerate(difference * natural_scales(fly, kinematics)[:ROLL]):
        ahead, back = rest.copy(), rest.copy()
        ahead[:, VELOCITY + k] += step
        back[:, VELOCITY + k] -= step
        columns.append((_air(fly, kinematics, ahead) - _air(fly, kinematics, back)) / (2 * step))
    return np.stack(columns, axis=1)


def _inertia(fly: FlappingFly, kinematics: StrokeKinematics, rest: FloatArray) -> FloatArray:
    """Loads by accelerations, in which they are linear: of the size that flight has, for the sake of rounding."""
    still, columns = _required(fly, kinematics, rest), []
    for k, rate in enumerate(kinematics.frequency * natural_scales(fly, kinematics)[:ROLL]):
        accelerated = rest.copy()
        accelerated[:, STATES + k] += rate
        columns.append((_required(fly, kinematics, accelerated) - still) / rate)
    return np.stack(columns, axis=1)


def _gravity(fly: FlappingFly, kinematics: StrokeKinematics, rest: FloatArray) -> FloatArray:
    """Loads of the weight of body and wings by small tilts: the rest of what acts does not know the attitude."""
    columns = []
    for tilt in np.eye(2) * 1e-3:
        ahead, back = rest.copy(), rest.copy()
        ahead[:, QUATERNION:VELOCITY] = attitude(tilt[0], tilt[1], np.zeros(()))
        back[:, QUATERNION:VELOCITY] = attitude(-tilt[0], -tilt[1], np.zeros(()))
        columns.append((_required(fly, kinematics, back) - _required(fly, kinematics, ahead)) / 2e-3)
    return np.stack(columns, axis=1)

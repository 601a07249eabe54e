"""The torque that an insect exerts about its wing's pitch axis, by inverse dynamics, and its work loop.

    tau = inertia - sum over terms of the air,    W = integral of tau eta' over a wingbeat

Against pitch, tau makes a loop: counter-clockwise (W < 0) the wing works on the hinge, clockwise the hinge on the wing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.multibody.freedoms import HELD, Hinge
from flycontrol.flight.multibody.inverse import inverse_dynamics
from flycontrol.flight.quasi_steady import TERMS
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import level_start, packed, trajectory_of
from flycontrol.flight.wingbeat_map import WingbeatMap
from flycontrol.model.stroke import Side
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import Trajectory

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class PitchTorques:
    """Torques about one wing's pitch axis at N evenly spaced instants of whole wingbeats, each (N,)."""

    pitch: FloatArray  #: eta [rad]
    pitch_rate: FloatArray  #: eta' [rad/s]
    duration: float  #: of all N samples [s]
    wingbeats: int  #: in that time
    hinge: FloatArray  #: tau: what hinge and muscles exert on the wing [N m]
    inertia: FloatArray  #: what the wing's mass asks for: its turning, its hinge's motion, its weight [N m]
    air: Mapping[str, FloatArray]  #: on the wing: translational, rotational, added_mass, dissipative [N m]

    def work(self, torque: FloatArray) -> float:
        """Mean over the wingbeats of the integral of a torque (N,) times eta' over a wingbeat [J]."""
        return float(np.mean(torque * self.pitch_rate)) * self.duration / self.wingbeats


def pitch_torques(fly: FlappingFly, trajectory: Trajectory, side: Side = "right") -> PitchTorques:
    """Torques about the pitch axis along a motion, simulated or measured.

    The equations of motion are linear in each term of the air, so a term's torque is what it takes off the hinge.

    Parameters
    ----------
    fly
        Morphology (pitch axis, wing mass) and air; springs at its hinges do not count.
    trajectory
        Whole wingbeats, evenly sampled, the first instant not repeated at the end.
    side
        Which wing.
    """
    if side not in ("left", "right"):
        raise InvalidParameterError(f"pitch_torques is for the 'left' or the 'right' wing, got {side!r}.")
    beats = len(trajectory.time) / trajectory.samples_per_wingbeat
    if not (beats >= 1 and beats == int(beats)):
        raise InvalidInputError(
            f"A work loop needs whole wingbeats of {trajectory.samples_per_wingbeat} samples, got "
            f"{len(trajectory.time)} samples; cut the trajectory before the instant that begins the next wingbeat."
        )

    def hinge(terms: tuple[str, ...]) -> FloatArray:
        forces = inverse_dynamics(replace(fly, air=replace(fly.air, terms=terms)), trajectory)
        return (forces.left_hinge if side == "left" else forces.right_hinge)[:, 2]

    inertia, motion = hinge(()), trajectory.wing(side)
    air = {term: inertia - hinge((term,)) if term in fly.air.terms else np.zeros_like(inertia) for term in TERMS}
    return PitchTorques(
        pitch=motion.pitch,
        pitch_rate=motion.pitch_rate,
        duration=beats / trajectory.frequency,
        wingbeats=int(beats),
        hinge=hinge(fly.air.terms),
        inertia=inertia,
        air=air,
    )


def held_wingbeat(fly: FlappingFly, stroke: StrokeKinematics, settings: MarchSettings | None = None) -> Trajectory:
    """One wingbeat of a periodic stroke, all three angles as given and the body held level and at rest.

    What a measured wingbeat is to inverse dynamics: N instants of 200 by default, its end not included.
    """
    settings = settings or MarchSettings(samples=200)
    beat = WingbeatMap(replace(fly, body=HELD, left=Hinge(), right=Hinge()), stroke, settings)
    samples = beat(packed(level_start(stroke))).samples
    phase = np.arange(settings.samples) / settings.samples
    return replace(trajectory_of(samples, phase, stroke.frequency, settings.samples), wingbeats=1)


def rest_angle(torques: PitchTorques, stiffness: float) -> float:
    """eta_0 = <eta> + <tau> / kappa [rad] of a spring of known kappa: over whole wingbeats a damper takes no part."""
    if not 0 < stiffness < np.inf:  # refuses NaN too
        raise InvalidParameterError(
            f"A rest angle needs the stiffness of a spring, finite and > 0 N m/rad, got {stiffness!r}; work_loop finds "
            "one."
        )
    return float(torques.pitch.mean() + torques.hinge.mean() / stiffness)


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkLoop:
    """What a work loop looks like to somebody who takes it for a damped spring. Fitted, so kappa and C may be < 0."""

    stiffness: float  #: kappa of tau = -kappa (eta - eta_0) - C eta', least squares [N m/rad]
    damping: float  #: C of the same fit [N m s/rad]
    rest_angle: float  #: eta_0 of the same fit [rad]
    explained: float  #: R^2 of the same fit
    explained_by_line: float  #: R^2 of tau = -kappa (eta - eta_0) alone
    work: float  #: of the hinge on the wing per wingbeat, the loop's area, > 0 clockwise [J]
    peak: float  #: largest |tau| [N m]


def work_loop(torques: PitchTorques) -> WorkLoop:
    """Least-squares spring and damper through the hinge's torque; over whole wingbeats eta and eta' are orthogonal."""
    eta, rate, tau = torques.pitch, torques.pitch_rate, torques.hinge
    scale = float(np.std(rate))
    design = np.stack([eta, rate / scale, np.ones_like(eta)], axis=1)
    damped = np.linalg.lstsq(design, tau, rcond=None)[0]
    line = np.linalg.lstsq(design[:, [0, 2]], tau, rcond=None)[0]
    return WorkLoop(
        stiffness=-float(damped[0]),
        damping=-float(damped[1]) / scale,
        rest_angle=-float(damped[2] / damped[0]),
        explained=_explained(tau, design @ damped),
        explained_by_line=_explained(tau, design[:, [0, 2]] @ line),
        work=torques.work(tau),
        peak=float(np.max(np.abs(tau))),
    )


def _explained(values: FloatArray, model: FloatArray) -> float:
    return 1.0 - float(np.sum((values - model) ** 2) / np.sum((values - values.mean()) ** 2))

"""The stroke as the march wants it: angles, rates, accelerations and torques of both wings at half steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.multibody.freedoms import Hinge, Prescribed, TorqueDriven
from flycontrol.model.hinge import SteeredSpring
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import WingStroke

FloatArray = NDArray[np.float64]


def drive_table(fly: FlappingFly, stroke: StrokeKinematics, phase: FloatArray) -> FloatArray:
    """(N, 2, 12) left and right wing at phases (N,): angles, rates, accelerations, torques, else 0."""
    left = _wing_drive(fly.left, stroke.left, stroke.frequency, phase)
    right = left if _same(fly, stroke) else _wing_drive(fly.right, stroke.right, stroke.frequency, phase)
    return np.ascontiguousarray(np.stack([left, right], axis=1))


def repeats(fly: FlappingFly, stroke: StrokeKinematics) -> bool:
    """Whether every wingbeat is driven alike."""
    torques = [joint for hinge in (fly.left, fly.right) for joint in hinge.joints if isinstance(joint, TorqueDriven)]
    return stroke.left.periodic and stroke.right.periodic and all(joint.periodic for joint in torques)


def _same(fly: FlappingFly, stroke: StrokeKinematics) -> bool:
    return fly.left is fly.right and stroke.left is stroke.right


def _wing_drive(hinge: Hinge, stroke: WingStroke, frequency: float, phase: FloatArray) -> FloatArray:
    at = stroke(phase)
    drive = np.zeros((len(phase), 12))
    for k, joint in enumerate(hinge.joints):
        if isinstance(joint, Prescribed):
            drive[:, k] = at.angles[:, k]
            drive[:, 3 + k] = at.first[:, k] * frequency
            drive[:, 6 + k] = at.second[:, k] * frequency**2
        if isinstance(joint, TorqueDriven):
            drive[:, 9 + k] = joint.torque(phase)
        if isinstance(joint, SteeredSpring):  # -kappa (eta - eta_0) = kappa eta_0 - kappa eta
            drive[:, 9 + k] = joint.stiffness * at.angles[:, k]
    if not np.all(np.isfinite(drive)):
        raise InvalidParameterError(
            "The stroke or a hinge torque is not a finite number at some phase; check its parameters."
        )
    return drive

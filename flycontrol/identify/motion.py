"""Body motion of a recording, as the blade elements and Newton want it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flycontrol.errors import InvalidInputError
from flycontrol.flight.aerodynamics import BodyMotion
from flycontrol.model.morphology import Morphology, pitch_rotation
from flycontrol.model.recording import Recording
from flycontrol.model.stroke import derivative

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Attitude:
    """Where the stroke-plane frame points in the world."""

    body_to_world: Rotation
    stroke_plane_from_body: FloatArray  #: (3, 3) v_S = this v_B

    def world(self, vectors_S: FloatArray) -> FloatArray:
        """Vectors (N, 3) from the stroke-plane frame to the world."""
        return self.body_to_world.apply(vectors_S @ self.stroke_plane_from_body)

    def stroke_plane(self, vectors_W: FloatArray) -> FloatArray:
        """Vectors (N, 3) from the world to the stroke-plane frame."""
        return self.body_to_world.inv().apply(vectors_W) @ self.stroke_plane_from_body.T


def attitude(recording: Recording, morphology: Morphology) -> Attitude:
    """Attitude from the quaternion; a sentence when it was not measured."""
    if recording.q_WB is None:
        raise InvalidInputError(f"{recording.name}: the body's quaternion is needed; map it, or leave this check out.")
    return Attitude(
        body_to_world=Rotation.from_quat(recording.q_WB[:, [1, 2, 3, 0]]),
        stroke_plane_from_body=pitch_rotation(morphology.stroke_plane_angle),
    )


def angular_velocity(recording: Recording) -> FloatArray:
    """(N, 3) roll, pitch, yaw rate in the stroke-plane frame [rad/s]; a sentence when they were not measured."""
    if recording.angular_velocity_S is None:
        raise InvalidInputError(
            f"{recording.name}: the body's angular velocity in the stroke-plane frame is needed and is not mapped."
        )
    return recording.angular_velocity_S


def body_motion(recording: Recording, morphology: Morphology) -> BodyMotion:
    """Velocity as recorded, else from position and attitude; angular velocity as recorded."""
    velocity = recording.velocity_S
    if velocity is None and recording.position_W is not None:
        velocity = attitude(recording, morphology).stroke_plane(derivative(recording.position_W, recording.rate))
    if velocity is None:
        raise InvalidInputError(f"{recording.name}: velocity or position of the body is needed and neither is mapped.")
    return BodyMotion(velocity=velocity, angular_velocity=angular_velocity(recording))


def required_torque(recording: Recording, morphology: Morphology) -> FloatArray:
    """I w' + w x I w, the torque that the body's rotation asks for, frame S, (N, 3) [N m]."""
    rates = angular_velocity(recording)
    momentum = rates @ morphology.inertia_S.T
    return derivative(momentum, recording.rate) + np.cross(rates, momentum)

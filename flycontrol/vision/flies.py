"""The fly that a tracker follows, from what is known of its body and wings."""

from __future__ import annotations

from flycontrol.model.morphology import Morphology
from flycontrol.vision.fly_shape import fly_shape
from flycontrol.vision.follower import Fly


def fly_of(morphology: Morphology, *, body_length: float | None = None, stroke_plane_angle: float | None = None) -> Fly:
    """A fly with the wings of a morphology and the package's own drawing of a body.

    Parameters
    ----------
    morphology : for the wings, and the stroke plane
    body_length : [m]; None: as long as a wing
    stroke_plane_angle : v_S = Ry(angle) v_B [rad]; None: that of the morphology
    """
    shape = fly_shape(morphology.planform, body_length=body_length, pitch_axis=morphology.pitch_axis)
    angle = morphology.stroke_plane_angle if stroke_plane_angle is None else stroke_plane_angle
    return Fly(shape=shape, stroke_plane_angle=angle)

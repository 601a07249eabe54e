"""Every way in which a fly may hold its wings, coarsely."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.pose import Pose
from flycontrol.units import deg
from flycontrol.vision.fit_shape import FitShape
from flycontrol.vision.stance import stances_of

FloatArray = NDArray[np.float64]

_STROKES, _DEVIATIONS = np.array([-75, -50, -25, 0, 25, 50, 70]) * deg, np.array([-20, 5, 30]) * deg
_PITCHES = np.array([40, 90, 140]) * deg


def wing_grid(shape: FitShape, stroke_plane_angle: float) -> Iterator[FloatArray]:
    """Axes (2, 3, 3) of left and right wing in body axes, each the other's mirror image; v_S = Ry(angle) v_B [rad]."""
    angles = np.array(list(product(_STROKES, _DEVIATIONS, _PITCHES)))
    X = np.hstack([np.zeros((len(angles), 6)), angles, angles, np.tile(shape.bases_B.ravel(), (len(angles), 1))])
    return (stance.wings_B for stance in stances_of(Pose(coordinates=X, stroke_plane_angle=stroke_plane_angle)))

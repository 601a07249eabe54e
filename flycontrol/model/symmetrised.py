"""Symmetrised wing motion: angle by angle, both wings are given the mean of both.  Review, section 4.

    x_L, x_R  ->  (x_L + x_R) / 2    for every angle x of stroke, deviation, pitch that is not kept as measured

Three angles, each kept or symmetrised, make eight versions of a motion: from none kept, which is mirror-symmetric, to
all kept, which is the motion as it was measured.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.stroke import ANGLES, Angle
from flycontrol.model.trajectory import Trajectory, wing_angles, wing_motion_of, wing_rates

FloatArray = NDArray[np.float64]

#: Which angles are kept as measured; version k keeps angle i where bit i of k is set, so that 0 is symmetric, 7 as is.
VERSIONS: tuple[tuple[Angle, ...], ...] = tuple(
    tuple(angle for i, angle in enumerate(ANGLES) if k >> i & 1) for k in range(8)
)


def symmetrised(trajectory: Trajectory, kept: Collection[Angle] = ()) -> Trajectory:
    """The same flight with every angle but those in `kept` symmetrised, rates and accelerations with it.

    The motion of the body stays as it is: set it to rest apart, or keep what was measured.

    Raises
    ------
    InvalidParameterError
        `kept` names something else than stroke, deviation and pitch.
    """
    if unknown := set(kept) - set(ANGLES):
        raise InvalidParameterError(f"Wing angles {sorted(unknown)} are not known; keep some of {', '.join(ANGLES)}.")
    shared = np.array([angle not in kept for angle in ANGLES])

    def halved(left: FloatArray, right: FloatArray) -> tuple[FloatArray, FloatArray]:
        mean = 0.5 * (left + right)
        return np.where(shared, mean, left), np.where(shared, mean, right)

    wings = (trajectory.left, trajectory.right)
    angles, rates = (halved(*map(read, wings)) for read in (wing_angles, wing_rates))
    left_acceleration, right_acceleration = halved(trajectory.left_acceleration, trajectory.right_acceleration)
    return replace(
        trajectory,
        left=wing_motion_of(angles[0], rates[0]),
        right=wing_motion_of(angles[1], rates[1]),
        left_acceleration=left_acceleration,
        right_acceleration=right_acceleration,
    )

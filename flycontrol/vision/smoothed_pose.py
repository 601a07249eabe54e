"""The coordinates of a fly as smooth functions of time, with what is known of them and of their derivatives."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.pose import Pose

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SmoothedPose:
    """N instants of a tracked fly, smoothed; NaN where nothing is known."""

    pose: Pose
    uncertainty: FloatArray  #: (N, 18) standard deviations of the coordinates [m, rad]
    rate: FloatArray  #: (N, 18) first derivatives of the coordinates [m/s, rad/s]
    rate_uncertainty: FloatArray  #: (N, 18)
    acceleration: FloatArray  #: (N, 18) second derivatives [m/s^2, rad/s^2]
    acceleration_uncertainty: FloatArray  #: (N, 18)
    angular_velocity_B: FloatArray  #: (N, 3) about forward, right, down of the body [rad/s]
    angular_velocity_uncertainty: FloatArray  #: (N, 3)
    #: (N, 18) seen and believed by the tracker, but set aside: too far from what the other frames tell
    set_aside: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 18), dtype=np.bool_))

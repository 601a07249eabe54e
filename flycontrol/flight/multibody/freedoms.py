"""What each of the twelve degrees of freedom does: prescribed, driven by a torque, a damped spring; free or held."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.hinge import DampedSpring, SteeredSpring

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Prescribed:
    """The angle follows the stroke, whatever torque that takes."""


@dataclass(frozen=True, slots=True)
class TorqueDriven:
    """The angle follows from a torque at the hinge, given over the phase (N,) [wingbeats] -> (N,) [N m]."""

    torque: Callable[[FloatArray], FloatArray]
    periodic: bool = True  #: whether the torque of every wingbeat is that of phases 0 to 1


Joint = Prescribed | TorqueDriven | DampedSpring | SteeredSpring


@dataclass(frozen=True, slots=True, kw_only=True)
class Hinge:
    """The three joints of one wing."""

    stroke: Joint = Prescribed()
    deviation: Joint = Prescribed()
    pitch: Joint = Prescribed()

    @property
    def joints(self) -> tuple[Joint, Joint, Joint]:
        """Stroke, deviation, pitch."""
        return (self.stroke, self.deviation, self.pitch)


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyFreedoms:
    """Which components of the body's velocity and angular velocity in S are free; held ones keep their value."""

    forward: bool = True
    sideways: bool = True
    down: bool = True
    roll: bool = True
    pitch: bool = True
    yaw: bool = True

    @property
    def mask(self) -> FloatArray:
        """(6,) 1 where free."""
        return np.array([self.forward, self.sideways, self.down, self.roll, self.pitch, self.yaw], dtype=np.float64)


FREE = BodyFreedoms()  #: free flight
HELD = BodyFreedoms(forward=False, sideways=False, down=False, roll=False, pitch=False, yaw=False)  #: tethered
YAW_ONLY = BodyFreedoms(forward=False, sideways=False, down=False, roll=False, pitch=False)  #: on a magnetic tether

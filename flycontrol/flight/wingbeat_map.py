"""The map from a state at the beginning of a wingbeat to the state at its end, wings prescribed and periodic.

    y -> y + integral of f(y, t) over one wingbeat

It commutes with shifts of the world and with turns about the vertical.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.drive import drive_table
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.march import SAMPLE, march
from flycontrol.flight.multibody.constants import constants_of
from flycontrol.flight.multibody.freedoms import Prescribed
from flycontrol.flight.settings import MarchSettings
from flycontrol.model.stroke_kinematics import StrokeKinematics

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlownBeat:
    """One wingbeat, as the march keeps it."""

    end: FloatArray  #: (25,) state after it
    samples: FloatArray  #: (n, 37) states and accelerations at n evenly spaced phases, its beginning included


class WingbeatMap:
    """One wingbeat of a fly with prescribed periodic wings."""

    def __init__(self, fly: FlappingFly, stroke: StrokeKinematics, settings: MarchSettings | None = None) -> None:
        """Tabulate the stroke; InvalidParameterError where it is not periodic or a hinge is not prescribed."""
        _refuse_what_does_not_repeat(fly, stroke)
        settings = settings or MarchSettings()
        phase = np.arange(2 * settings.steps + 1) / (2 * settings.steps)
        self.fly, self.stroke, self.settings = fly, stroke, settings
        self.drive = drive_table(fly, stroke, phase)
        self.constants = constants_of(fly, stroke.frequency)
        self.outside = np.zeros((settings.steps, 6))

    @property
    def period(self) -> float:
        """Of the wingbeat [s]."""
        return 1.0 / self.stroke.frequency

    def __call__(self, y: FloatArray) -> FlownBeat:
        """Fly one wingbeat from y (25,); InvalidParameterError where the state runs away within it."""
        steps, samples = self.settings.steps, self.settings.samples
        end, room = y.copy(), np.empty((samples, SAMPLE))
        step = self.period / steps
        done = march(end, self.drive, step, self.outside, steps // samples, *self.constants.arguments, room)
        if done < steps:
            raise InvalidParameterError(
                "The state runs away within one wingbeat: no periodic flight is near it; begin nearer to hover."
            )
        return FlownBeat(end=end, samples=room)


def _refuse_what_does_not_repeat(fly: FlappingFly, stroke: StrokeKinematics) -> None:
    if not (stroke.left.periodic and stroke.right.periodic):
        raise InvalidParameterError(
            "A periodic flight needs a periodic stroke, and this one changes between wingbeats; give one that repeats."
        )
    if not all(isinstance(joint, Prescribed) for hinge in (fly.left, fly.right) for joint in hinge.joints):
        raise InvalidParameterError(
            "Periodic flight is sought with prescribed wings; give the fly hinges that follow the stroke."
        )

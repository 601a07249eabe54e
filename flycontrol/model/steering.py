"""What steering changes of both wings' strokes: from the first wingbeat on, or along a ramp."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flycontrol.errors import InvalidParameterError
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import ModulatedStroke, Modulation, WingStroke


@dataclass(frozen=True, slots=True, kw_only=True)
class Steering:
    """A change of each wing's stroke."""

    left: Modulation
    right: Modulation
    ramp: tuple[float, float] | None = None  #: from where to where it comes [wingbeats]; None: it is always there

    def __post_init__(self) -> None:
        if self.ramp is not None and not (np.all(np.isfinite(self.ramp)) and self.ramp[0] < self.ramp[1]):
            raise InvalidParameterError(
                f"A ramp of steering must end after it starts, both in wingbeats, got {list(self.ramp)}."
            )

    def applied(self, kinematics: StrokeKinematics) -> StrokeKinematics:
        """The strokes with this change laid over them."""
        left, right = self._steered(kinematics.left, self.left), self._steered(kinematics.right, self.right)
        return replace(kinematics, left=left, right=right)

    def _steered(self, stroke: WingStroke, change: Modulation) -> WingStroke:
        if change == Modulation():
            return stroke
        if self.ramp is None:
            return ModulatedStroke(stroke=stroke, before=change, after=change)
        return ModulatedStroke(stroke=stroke, after=change, ramp=self.ramp)

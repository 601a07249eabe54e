"""Perturbations of an experiment: a torque pulse, as a coil and a magnetic pin make it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flycontrol.errors import InvalidParameterError


@dataclass(frozen=True, slots=True, kw_only=True)
class TorquePulse:
    """N_ext = torque from onset 0 until `duration`, zero after."""

    duration: float  #: [s]
    torque: float = 1.0  #: [N m]

    def __post_init__(self) -> None:
        if not (self.duration > 0 and np.isfinite(self.duration)):
            raise InvalidParameterError(f"TorquePulse.duration must be > 0 s, got {self.duration!r}.")
        if not np.isfinite(self.torque):
            raise InvalidParameterError(f"TorquePulse.torque must be a finite number, got {self.torque!r}.")

    def times(self, factor: float) -> TorquePulse:
        """The same pulse, stronger by a factor."""
        return replace(self, torque=self.torque * factor)

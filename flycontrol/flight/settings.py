"""How finely a flight is computed and how much of it is kept."""

from __future__ import annotations

from dataclasses import dataclass

from flycontrol.errors import InvalidParameterError
from flycontrol.model.flight_experiment import FEWEST_STEPS


@dataclass(frozen=True, slots=True, kw_only=True)
class MarchSettings:
    """Runge-Kutta steps and samples a wingbeat."""

    steps: int = 200  #: RK4 steps a wingbeat, even
    samples: int = 50  #: stored instants a wingbeat; divides `steps`
    tolerance: float = 1e-3  #: largest estimated error of attitude and free wing angles after one wingbeat [rad]
    estimate_error: bool = True  #: repeat the first wingbeat with half the steps, its loads with many blades
    chunk: int = 50  #: wingbeats between which results are handed on

    def __post_init__(self) -> None:
        if not (self.steps >= FEWEST_STEPS and self.steps % 2 == 0):
            raise InvalidParameterError(
                f"MarchSettings.steps must be an even number of at least {FEWEST_STEPS} a wingbeat, got {self.steps!r}."
            )
        if not (self.samples >= 1 and self.steps % self.samples == 0):
            raise InvalidParameterError(
                f"MarchSettings.samples must divide the {self.steps} steps a wingbeat, got {self.samples!r}."
            )
        if not (self.tolerance > 0 and self.chunk >= 1):
            raise InvalidParameterError("MarchSettings.tolerance must be > 0 and chunk at least 1.")

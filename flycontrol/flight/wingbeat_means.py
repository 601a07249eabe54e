"""Forces, torques, rates and power of a flight, averaged wingbeat by wingbeat."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.multibody.inverse import inverse_dynamics
from flycontrol.flight.quasi_steady import TERMS
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.trajectory import Trajectory, rotation_matrices, wing_rates

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class WingbeatMeans:
    """Means over K wingbeats, each over the samples of one; terms in the order of `TERMS`."""

    phase: FloatArray  #: (K,) middle of the wingbeat [wingbeats]
    force_S: FloatArray  #: (K, terms, 3) of the air on both wings [N]
    torque_S: FloatArray  #: (K, terms, 3) about the body's centre of mass [N m]
    lift: FloatArray  #: (K, terms) component of the force along the world's vertical, upward [N]
    angular_velocity_S: FloatArray  #: (K, 3) roll, pitch, yaw rate [rad/s]
    power: FloatArray  #: (K,) of hinges and muscles on both wings [W]

    def __len__(self) -> int:
        """How many wingbeats."""
        return len(self.phase)

    def __add__(self, other: WingbeatMeans) -> WingbeatMeans:
        """Row by row."""
        return self._each(lambda name: getattr(self, name) + getattr(other, name))

    def rows(self, index: NDArray[np.bool_]) -> WingbeatMeans:
        """Some of the wingbeats."""
        return self._each(lambda name: getattr(self, name)[index])

    def total(self) -> WingbeatMeans:
        """Sum over the wingbeats, one row."""
        return self._each(lambda name: getattr(self, name).sum(axis=0, keepdims=True))

    def over(self, count: int) -> WingbeatMeans:
        """Everything divided by a count."""
        return self._each(lambda name: getattr(self, name) / count)

    @staticmethod
    def joined(parts: Sequence[WingbeatMeans]) -> WingbeatMeans:
        """One after another."""
        return parts[0]._each(lambda name: np.concatenate([getattr(part, name) for part in parts]))

    def _each(self, value: Callable[[str], FloatArray]) -> WingbeatMeans:
        return WingbeatMeans(**{field.name: value(field.name) for field in fields(self)})


def wingbeat_means(fly: FlappingFly, flight: Trajectory) -> WingbeatMeans:
    """Averages of the whole wingbeats of a flight that begins with one."""
    per_beat = flight.samples_per_wingbeat
    beats = len(flight.time) // per_beat
    loads, needed = loads_along(fly, flight), inverse_dynamics(fly, flight)
    terms = [[getattr(loads, side).terms[term] for side in ("left", "right")] for term in TERMS]
    force = np.stack([left.force + right.force for left, right in terms], axis=1)
    torque = np.stack([left.torque + right.torque for left, right in terms], axis=1)
    upward = rotation_matrices(flight.q_WS)[:, 2]
    power = needed.left_hinge * wing_rates(flight.left) + needed.right_hinge * wing_rates(flight.right)

    def mean(samples: FloatArray) -> FloatArray:
        return samples[: beats * per_beat].reshape(beats, per_beat, *samples.shape[1:]).mean(axis=1)

    return WingbeatMeans(
        phase=mean(flight.phase) + 0.5 / per_beat,
        force_S=mean(force),
        torque_S=mean(torque),
        lift=mean(np.einsum("ntk,nk->nt", force, upward)),
        angular_velocity_S=mean(flight.angular_velocity_S),
        power=mean(power.sum(axis=1)),
    )

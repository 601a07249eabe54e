"""What a hover trim balances: mean loads on a held body, or a wingbeat of a free one that ends where it began."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.body_coordinates import LONGITUDINAL, PITCH, coordinates_of, natural_scales, state_at
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.march import QUATERNION
from flycontrol.flight.multibody.freedoms import FREE, HELD
from flycontrol.flight.multibody.inverse import inverse_dynamics
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import trajectory_of
from flycontrol.flight.trim_parameters import FlownStroke
from flycontrol.flight.wingbeat_map import WingbeatMap

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Balance:
    """Net loads on the fly, averaged over the wingbeat, and whether it stays in place."""

    forward: float  #: force over weight
    down: float  #: force over weight
    pitch: float  #: torque about the body's centre of mass over weight times wing length, > 0 nose up
    drift: tuple[float, float] = (0.0, 0.0)  #: mean velocity forward and up; none where the body is held [m/s]

    @property
    def largest_load(self) -> float:
        """Of the three."""
        return max(abs(self.forward), abs(self.down), abs(self.pitch))


def held_balance(fly: FlappingFly, flown: FlownStroke, settings: MarchSettings) -> Balance:
    """Loads of air and weight on a fly that is held at rest: what the holder bears, turned about."""
    every_step = replace(settings, samples=settings.steps)
    beat = WingbeatMap(replace(fly, body=HELD), flown.kinematics, every_step)
    samples = beat(state_at(flown.kinematics, _level(flown.body_pitch))).samples
    phase = np.arange(settings.steps) / settings.steps
    borne = inverse_dynamics(fly, trajectory_of(samples, phase, flown.kinematics.frequency, settings.steps))
    weight = fly.morphology.weight
    forward, _, down = -borne.body_force.mean(axis=0) / weight
    pitch = -borne.body_torque[:, 1].mean() / (weight * fly.morphology.wing_length)
    return Balance(forward=float(forward), down=float(down), pitch=float(pitch))


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeBeat:
    """A wingbeat of the free body from (u, w, q, theta), everything over R f, f and 1."""

    begin: FloatArray  #: (25,) state
    balance: Balance
    tilt: float  #: change of pitch [rad]
    nod: float  #: mean pitch less the one that is wanted [rad]
    shift: tuple[float, float]  #: forward and up [wing lengths]

    @property
    def residuals(self) -> FloatArray:
        """(7,) all 0 on a periodic orbit that stays in place."""
        balance = self.balance
        return np.array([balance.forward, balance.down, balance.pitch, self.tilt, self.nod, *self.shift])


def free_beat(fly: FlappingFly, flown: FlownStroke, scaled: FloatArray, settings: MarchSettings) -> FreeBeat:
    """Fly one wingbeat from `scaled` (4,) and compare its end with its beginning."""
    beat = WingbeatMap(replace(fly, body=FREE), flown.kinematics, settings)
    scales, along = natural_scales(fly, flown.kinematics), list(LONGITUDINAL)
    x = np.zeros(len(scales))
    x[along] = scaled * scales[along]
    y = state_at(flown.kinematics, x)
    flight = beat(y)
    forward, down, rate, tilt = (coordinates_of(flight.end) - x)[along]
    morphology, drop = fly.morphology, fly.morphology.weight / fly.morphology.mass * beat.period
    inertia = morphology.inertia_S[1, 1]
    moved = (flight.end - y)[:QUATERNION]
    balance = Balance(
        forward=float(forward / drop),
        down=float(down / drop),
        pitch=float(rate * inertia / (drop * morphology.mass * morphology.wing_length)),
        drift=(float(moved[0] / beat.period), float(moved[2] / beat.period)),
    )
    nod = float(coordinates_of(flight.samples)[:, PITCH].mean() - flown.body_pitch)
    shift = moved / morphology.wing_length
    return FreeBeat(begin=y, balance=balance, tilt=float(tilt), nod=nod, shift=(float(shift[0]), float(shift[2])))


def _level(pitch: float) -> FloatArray:
    x = np.zeros(8)
    x[PITCH] = pitch
    return x

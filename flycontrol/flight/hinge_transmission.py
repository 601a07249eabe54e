"""What biased springs do: opposite biases of the rest angles paddle the wings and turn the fly.

    mu = d(d_alpha) / d(d_eta_0),    d_alpha = <phi'^2 (eta_R - eta_L)> / (2 <phi'^2>)

with eta_0 + d_eta_0 on the right and eta_0 - d_eta_0 on the left: as for d_alpha itself, > 0 turns right.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.hinge_motion import PassiveWingbeat, passive_wingbeat, sprung
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.hinge import DampedSpring
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import Trajectory
from flycontrol.units import deg

FloatArray = NDArray[np.float64]

SMALL_BIAS = 1 * deg
_RATE = 1.0  # yaw rate of the differences [rad/s], against wing rates of 1000 rad/s


@dataclass(frozen=True, slots=True, kw_only=True)
class BiasedWingbeat:
    """The periodic wingbeat of a held fly with opposite biases of its springs."""

    bias: float  #: d_eta_0, > 0: right wing's rest angle up [rad]
    d_alpha: float  #: <phi'^2 (eta_R - eta_L)> / (2 <phi'^2>) [rad]
    plain_mean: float  #: <eta_R - eta_L> / 2 over time [rad]
    at_mid_stroke: float  #: (eta_R - eta_L) / 2, mean of the instants of fastest forward and backward sweep [rad]
    torque: FloatArray  #: (3,) mean torque of the air about the centre of mass, frame S; [2] > 0 turns right [N m]
    force: FloatArray  #: (3,) mean force of the air, frame S [N]
    passive: PassiveWingbeat


def biased_wingbeat(
    fly: FlappingFly,
    stroke: StrokeKinematics,
    spring: DampedSpring,
    bias: float,
    settings: MarchSettings | None = None,
) -> BiasedWingbeat:
    """Passive pitching with the right spring's rest angle up by the bias and the left one's down by it.

    Raises
    ------
    InvalidParameterError
        The bias is beyond +-pi/2, or there is no periodic wingbeat.
    """
    if not abs(bias) <= np.pi / 2:  # `not <=` also refuses NaN
        raise InvalidParameterError(
            f"A bias of the rest angles is in radians, within +-pi/2, got {bias!r}; write 5 * deg for 5 degrees "
            "(flycontrol.units)."
        )
    left, right = (replace(spring, rest_angle=spring.rest_angle + sign * bias) for sign in (-1, 1))
    passive = passive_wingbeat(sprung(fly, left, right), stroke, settings)
    flight = passive.trajectory
    apart = 0.5 * (flight.right.pitch - flight.left.pitch)
    sweep = 0.5 * (flight.left.stroke_rate + flight.right.stroke_rate)
    air = loads_along(fly, flight).total
    return BiasedWingbeat(
        bias=bias,
        d_alpha=float(np.average(apart, weights=sweep**2)),
        plain_mean=float(apart.mean()),
        at_mid_stroke=float(0.5 * (apart[np.argmax(sweep)] + apart[np.argmin(sweep)])),
        torque=air.torque.mean(axis=0),
        force=air.force.mean(axis=0),
        passive=passive,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class HingeTransmission:
    """From bias to paddling to yaw torque, by central differences about no bias."""

    mu: float  #: d(d_alpha)/d(d_eta_0), d_alpha weighted by phi'^2: the package's definition
    mu_plain: float  #: the same, d_alpha the mean over time
    mu_mid_stroke: float  #: the same, d_alpha at mid-stroke
    mu_torque: float  #: torque per bias over torque per direct paddling: what a yaw loop feels
    torque_per_bias: float  #: yaw [N m/rad]
    torque_per_paddling: float  #: gamma: yaw, the hover's passive pitch shifted as it is [N m/rad]
    damping: float  #: beta with wings that pitch passively as the body turns [N m s]
    damping_at_given_pitch: float  #: beta with the hover's passive pitch as it is [N m s]


def hinge_transmission(
    fly: FlappingFly,
    stroke: StrokeKinematics,
    spring: DampedSpring,
    *,
    bias: float = SMALL_BIAS,
    settings: MarchSettings | None = None,
) -> HingeTransmission:
    """Mu by four definitions, and the torques between them.

    Parameters
    ----------
    fly, stroke, spring
        As for `biased_wingbeat`.
    bias
        Step of the differences, to either side; not 0 [rad].

    Raises
    ------
    InvalidParameterError
        The bias is 0 or beyond +-pi/2, or there is no periodic wingbeat.
    """
    if bias == 0:
        raise InvalidParameterError(
            f"hinge_transmission takes differences over a bias other than 0 rad, got {bias!r}; leave it out for 1 deg."
        )
    up, down = (biased_wingbeat(fly, stroke, spring, sign * bias, settings) for sign in (1, -1))
    held = sprung(fly, spring)
    hover = passive_wingbeat(held, stroke, settings).trajectory
    right, left = (passive_wingbeat(held, stroke, settings, yaw_rate=rate).trajectory for rate in (_RATE, -_RATE))
    per_bias = float(up.torque[2] - down.torque[2]) / (2 * bias)
    per_paddling = (_paddled_torque(fly, hover, bias) - _paddled_torque(fly, hover, -bias)) / (2 * bias)
    return HingeTransmission(
        mu=(up.d_alpha - down.d_alpha) / (2 * bias),
        mu_plain=(up.plain_mean - down.plain_mean) / (2 * bias),
        mu_mid_stroke=(up.at_mid_stroke - down.at_mid_stroke) / (2 * bias),
        mu_torque=per_bias / per_paddling,
        torque_per_bias=per_bias,
        torque_per_paddling=per_paddling,
        damping=-(_yaw_torque(fly, right) - _yaw_torque(fly, left)) / (2 * _RATE),
        damping_at_given_pitch=-(_turned_torque(fly, hover, _RATE) - _turned_torque(fly, hover, -_RATE)) / (2 * _RATE),
    )


def _paddled_torque(fly: FlappingFly, hover: Trajectory, angle: float) -> float:
    """Mean yaw torque when each wing's pitch is shifted, right up and left down [N m]."""
    left, right = (
        replace(motion, pitch=motion.pitch + sign * angle) for sign, motion in ((-1, hover.left), (1, hover.right))
    )
    return _yaw_torque(fly, replace(hover, left=left, right=right))


def _turned_torque(fly: FlappingFly, hover: Trajectory, yaw_rate: float) -> float:
    """Mean yaw torque when the body yaws under wings that pitch as in hover [N m]."""
    turning = hover.angular_velocity_S + np.array([0.0, 0.0, yaw_rate])
    return _yaw_torque(fly, replace(hover, angular_velocity_S=turning))


def _yaw_torque(fly: FlappingFly, flight: Trajectory) -> float:
    return float(loads_along(fly, flight).total.torque[:, 2].mean())

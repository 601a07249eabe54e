"""A fly on a magnetic tether that controls its yaw at the wing level, and the reduced loop made of its coefficients."""

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from simulated_fly import FLY

from flycontrol.flight.feedback import YawFeedback
from flycontrol.flight.feedback_flight import ControlledFlight, controlled_flight
from flycontrol.flight.multibody.freedoms import YAW_ONLY
from flycontrol.flight.pulses import BodyPulse
from flycontrol.flight.settings import MarchSettings
from flycontrol.model.perturbation import TorquePulse
from flycontrol.model.recovery import pulse_response
from flycontrol.model.stroke_kinematics import hover_stroke
from flycontrol.model.yaw import PDController, PIDController, YawLoop
from flycontrol.reduce.reduced_yaw import ReducedYaw, reduced_yaw

STROKE = hover_stroke()
FREQUENCY = STROKE.frequency
TETHERED = replace(FLY, body=YAW_ONLY)
DELAY = 3 / FREQUENCY
QUICK = MarchSettings(estimate_error=False)
TORQUE = 1e-10  # turns it by half a degree


@cache
def reduced() -> ReducedYaw:
    return reduced_yaw(FLY, STROKE)


def gains(kp: float = 3050.0, kd: float = 45.0, ki: float = 0.0) -> PDController | PIDController:
    """Of paddling [rad], from ratios of torque gains to the inertia [1/s^2, 1/s, 1/s^3]."""
    per = reduced().inertia.total / reduced().paddling
    if ki:
        return PIDController(proportional=kp * per, integral=ki * per, derivative=kd * per)
    return PDController(proportional=kp * per, derivative=kd * per)


def feedback(**changes: object) -> YawFeedback:
    return replace(YawFeedback(gains=gains(), delay=DELAY), **changes)


def pulse(phase: float = 0.0, torque: float = TORQUE, duration: float = 1.0) -> BodyPulse:
    """Onset one wingbeat and a phase after the start, duration in wingbeats."""
    return BodyPulse(start=(1 + phase) / FREQUENCY, duration=duration / FREQUENCY, torque_S=(0.0, 0.0, torque))


def flown(
    control: YawFeedback, push: BodyPulse, wingbeats: int = 16, settings: MarchSettings = QUICK
) -> ControlledFlight:
    return controlled_flight(TETHERED, STROKE, control, wingbeats, pulses=[push], settings=settings)


def predicted(loop: YawLoop, push: BodyPulse, time: NDArray[np.float64]) -> NDArray[np.float64]:
    """Yaw of the reduced loop at times of the flight."""
    after = time - push.start
    response = pulse_response(
        loop.closed_loop(), TorquePulse(duration=push.duration, torque=push.torque_S[2]), after[-1]
    )
    return np.where(after > 0, response(np.clip(after, 0.0, None))[0], 0.0)


def misfit(control: YawFeedback, loop: YawLoop, push: BodyPulse) -> float:
    """Largest difference of both levels as a share of the reduced loop's peak."""
    flight = flown(control, push)
    expected = predicted(loop, push, flight.trajectory.time)
    return float(np.abs(flight.yaw - expected).max() / np.abs(expected).max())

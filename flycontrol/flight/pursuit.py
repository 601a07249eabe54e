"""A simulated fly that turns as another one did: each wingbeat is steered after wanted rates of roll, pitch and yaw.

    u_k = u_{k-1} + g J^-1 ((w*_{k+1} - w_k) - (w_k - w_{k-1})),

w_k the rates at the beginning of wingbeat k, w* the wanted ones, J the change of rates over a wingbeat for a unit of
steering: a model-based increment that corrects what the last wingbeat lacked. Nothing of it is a fly's own controller.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.flight.state_vector import level_start
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState, Trajectory
from flycontrol.model.wing_stroke import ModulatedStroke, Modulation

FloatArray = NDArray[np.float64]

_GAIN = 0.9  # g: less than 1, since a modulation arrives during its wingbeat
_RAMP = 0.5  # wingbeats that a modulation takes
_LARGEST = np.array([0.25, 0.3, 0.35])  # what wings could do: relative amplitude, mean position, paddling [1, rad, rad]
_PROBE = 0.02


def pursued_flight(
    fly: FlappingFly,
    stroke: StrokeKinematics,
    rates_S: FloatArray,
    start: FlightState,
    settings: MarchSettings | None = None,
) -> Trajectory:
    """Fly n wingbeats whose rates at each beginning follow the wanted ones.

    Roll is steered by the difference of stroke amplitudes, pitch by the mean stroke position, yaw by paddling.

    Parameters
    ----------
    fly
        Its roll, pitch and yaw must be free.
    stroke
        Of both wings before steering.
    rates_S
        (n + 1, 3) wanted roll, pitch and yaw rate at the beginning of each wingbeat and at the end [rad/s].
    start
        Where the body begins; the wings begin where the stroke does.
    settings
        Steps and samples a wingbeat.

    Raises
    ------
    InvalidInputError
        `rates_S` is no (n + 1, 3) with n >= 1, or the fly cannot be steered.
    """
    if rates_S.ndim != 2 or rates_S.shape[1] != 3 or len(rates_S) < 2:
        raise InvalidInputError(f"Rates to follow must be of shape (n + 1, 3), got {rates_S.shape}.")
    wings = level_start(stroke)
    start = replace(
        start,
        left_angles=wings.left_angles,
        left_rates=wings.left_rates,
        right_angles=wings.right_angles,
        right_rates=wings.right_rates,
    )
    drift, effect = _steering_effect(fly, stroke, start)
    if not np.linalg.cond(effect) < 1e4:
        raise InvalidInputError("This fly cannot be steered about all three axes; free its roll, pitch and yaw.")
    inverse = np.asarray(np.linalg.inv(effect), dtype=np.float64)
    first = inverse @ (rates_S[1] - rates_S[0] - drift)
    pilot = _Pilot(stroke=stroke, wanted=rates_S, inverse=inverse, steering=np.clip(first, -_LARGEST, _LARGEST))
    return simulate_flight(fly, pilot, len(rates_S) - 1, start=start, settings=settings)


@dataclass(slots=True, kw_only=True)
class _Pilot:
    stroke: StrokeKinematics
    wanted: FloatArray
    inverse: FloatArray
    steering: FloatArray
    last: FloatArray | None = field(default=None)

    def __call__(self, beat: int, state: FlightState) -> StrokeKinematics:
        rates, before = state.angular_velocity_S, self.steering
        if self.last is not None:
            lacking = (self.wanted[beat + 1] - rates) - (rates - self.last)
            self.steering = np.clip(before + _GAIN * self.inverse @ lacking, -_LARGEST, _LARGEST)
        self.last = rates
        return _steered(self.stroke, before, self.steering, (float(beat), beat + _RAMP))


def _steered(
    stroke: StrokeKinematics, before: FloatArray, after: FloatArray, ramp: tuple[float, float]
) -> StrokeKinematics:
    (left_0, right_0), (left_1, right_1) = _modulations(before), _modulations(after)
    return replace(
        stroke,
        left=ModulatedStroke(stroke=stroke.left, before=left_0, after=left_1, ramp=ramp),
        right=ModulatedStroke(stroke=stroke.right, before=right_0, after=right_1, ramp=ramp),
    )


def _modulations(steering: FloatArray) -> tuple[Modulation, Modulation]:
    """Left and right wing."""
    roll, pitch, yaw = (float(v) for v in steering)
    return (
        Modulation(stroke_gain=roll, stroke_offset=pitch, pitch_offset=-yaw),
        Modulation(stroke_gain=-roll, stroke_offset=pitch, pitch_offset=yaw),
    )


def _steering_effect(fly: FlappingFly, stroke: StrokeKinematics, start: FlightState) -> tuple[FloatArray, FloatArray]:
    """Change of the rates over a wingbeat that is not steered (3,), and for a unit of each steering (3, 3)."""

    def gained(steering: FloatArray) -> FloatArray:
        steered = stroke.modulated(*_modulations(steering))
        quick = MarchSettings(steps=100, samples=1, estimate_error=False)
        rates = simulate_flight(fly, steered, 1, start=start, settings=quick).angular_velocity_S
        return rates[-1] - rates[0]

    probes = _PROBE * np.eye(3)
    return gained(np.zeros(3)), np.stack([(gained(p) - gained(-p)) / (2 * _PROBE) for p in probes], axis=1)

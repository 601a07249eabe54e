"""What no fly does: the door refuses recordings whose numbers must have another unit than the mapping says."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.channels import Clock
from flycontrol.io.frames import turning_rate
from flycontrol.io.samples import Samples
from flycontrol.model.recording import Recording
from flycontrol.model.wingbeats import FEWEST_WINGBEATS, SMALLEST_STROKE, dominant_frequency
from flycontrol.units import deg, ms

FloatArray = NDArray[np.float64]

FASTEST_TURN = 500.0  #: the fastest rolls published are below 100 rad/s [rad/s]
FASTEST_FLIGHT = 10.0  #: [m/s]
LARGEST_WING_ANGLE = 2 * math.pi  #: [rad]
LARGEST_HEADING = 8 * math.pi  #: four turns [rad]
SLOWEST_WINGBEAT = 100.0  #: assumed where neither wings nor the mapping tell the wingbeat [1/s]
QUATERNION_NORM = 1e-3  #: largest deviation from 1 that rounding to four digits explains
A_WINGBEAT = 5 * ms  #: time over which rates are compared: noise of the tracking averages out [s]
FACTOR = 8.0  #: two measurements of one motion that differ by more have different units (57.3, 1000)


def refuse_fast_turning(samples: Samples) -> None:
    """Refuse an angular velocity that no fly reaches."""
    _refuse_beyond(samples, FASTEST_TURN, "rad/s", "no fly turns so fast; are the numbers deg/s?")


def refuse_fast_flight(samples: Samples) -> None:
    """Refuse a velocity that no fly reaches."""
    _refuse_beyond(samples, FASTEST_FLIGHT, "m/s", "no fly is so fast; are the numbers mm/s?")


def refuse_large_wing_angle(samples: Samples) -> None:
    """Refuse a wing angle of more than a full turn."""
    _refuse_beyond(samples, LARGEST_WING_ANGLE, "rad", "a wing turns by less than that; are the numbers degrees?")


def refuse_still_stroke(samples: Samples) -> None:
    """Refuse a stroke angle that moves less than any wingbeat."""
    span = float(np.ptp(samples.values))
    if span < SMALLEST_STROKE:
        raise InvalidInputError(
            f"{samples.table.file.name}: {samples.channel.key} moves by {span / deg:.3g} deg in all, less than any "
            f"wingbeat; are the numbers of {samples.table.kind} {samples.channel.place} radians, or another channel?"
        )


def refuse_implausible_heading(samples: Samples, rate: float) -> None:
    """Refuse a heading that winds up or turns as no fly does."""
    _refuse_beyond(samples, LARGEST_HEADING, "rad", "that is more than four turns; are the numbers degrees?")
    _refuse_steps(samples, np.unwrap(samples.values), rate, FASTEST_TURN, "rad/s; are the numbers degrees?")


def refuse_fast_position(samples: Samples, rate: float) -> None:
    """Refuse a position that moves faster than any fly."""
    _refuse_steps(samples, samples.values, rate, FASTEST_FLIGHT, "m/s; are the numbers mm?")


def refuse_other_than_unit_norm(components: list[Samples]) -> None:
    """Refuse quaternions whose norm is not 1."""
    norm = np.linalg.norm([part.values for part in components], axis=0)
    bad = np.flatnonzero(np.abs(norm - 1) > QUATERNION_NORM)
    if bad.size:
        sample = int(bad[0])
        raise components[0].refusal(
            sample,
            f"is part of a quaternion of norm {norm[sample]:.6g}; unit quaternions are needed: check the mapping",
        )


def refuse_inconsistent_units(recording: Recording) -> None:
    """Refuse rates that differ by a unit's factor from the motion that they are the rates of."""
    over = max(1, round(A_WINGBEAT * recording.rate))
    if over >= len(recording.time):
        return
    if recording.q_WB is not None and recording.angular_velocity_S is not None:
        turned = turning_rate(recording.q_WB, recording.rate, over)
        _refuse_factor(recording.name, "angular velocity", recording.angular_velocity_S, turned, "attitude", "rad/s")
    if recording.position_W is not None and recording.velocity_S is not None:
        moved = np.linalg.norm(recording.position_W[over:] - recording.position_W[:-over], axis=1)
        _refuse_factor(
            recording.name, "velocity", recording.velocity_S, moved * recording.rate / over, "position", "m/s"
        )


def refuse_short(recording: Recording, clock: Clock) -> None:
    """Refuse a recording of less than three wingbeats, counted from the strokes or else from an expected frequency."""
    duration = len(recording.time) / recording.rate
    wings = [wing.stroke for wing in (recording.left, recording.right) if wing is not None]
    if wings:
        frequency = dominant_frequency(np.mean(wings, axis=0), recording.rate)
        how = f"at the {frequency:.0f} Hz of its stroke"
    else:
        frequency = clock.wingbeat_frequency or SLOWEST_WINGBEAT
        how = f"at {frequency:g} Hz (no wing is mapped; clock.wingbeat_frequency in the mapping may say more)"
    if duration * frequency < FEWEST_WINGBEATS:
        raise InvalidInputError(
            f"{recording.name} lasts {duration / ms:.3g} ms, that is {duration * frequency:.2g} wingbeats {how}; "
            f"at least {FEWEST_WINGBEATS} are needed: use a longer recording, or check the clock in the mapping."
        )


def _refuse_beyond(samples: Samples, limit: float, unit: str, hint: str) -> None:
    largest = int(np.argmax(np.abs(samples.values)))
    if abs(samples.values[largest]) > limit:
        raise samples.refusal(largest, f"reaches {samples.values[largest]:.4g} {unit}; {hint}")


def _refuse_steps(samples: Samples, values: FloatArray, rate: float, limit: float, unit_and_hint: str) -> None:
    over = min(max(1, round(A_WINGBEAT * rate)), len(values) - 1)
    speed = np.abs(values[over:] - values[:-over]) * rate / over
    largest = int(np.argmax(speed))
    if speed[largest] > limit:
        raise samples.refusal(largest, f"changes by {speed[largest]:.4g} {unit_and_hint}")


def _refuse_factor(name: str, what: str, given: FloatArray, moved: FloatArray, other: str, unit: str) -> None:
    """Compare root mean squares; a motion too slow to tell from the tracking's noise is not judged."""
    said = float(np.sqrt(np.mean(np.sum(given**2, axis=1))))
    seen = float(np.sqrt(np.mean(moved**2)))
    noticeable = {"rad/s": 2.0, "m/s": 0.01}[unit]
    if max(said, seen) > noticeable and not 1 / FACTOR < said / max(seen, 1e-12) < FACTOR:
        raise InvalidInputError(
            f"{name}: the {what} is {said:.3g} {unit} (root mean square) where the {other} "
            f"changes at {seen:.3g} {unit}; "
            f"check the unit of the {what} and the clock in the mapping."
        )

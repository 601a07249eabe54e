"""Periodic flight with prescribed wings: a state that a wingbeat repeats, up to a shift and a turn.

    P(x*) = x*,    x = (u, v, w, p, q, r, phi, theta)

by Newton's method on the wingbeat map P, whose derivative is that of `floquet`. Position and heading are free to move:
a stroke that is not trimmed has periodic flights too, which drift or turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.body_coordinates import (
    COORDINATES,
    attitude_angles,
    coordinates_of,
    natural_scales,
    state_at,
)
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.march import QUATERNION, VELOCITY
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import packed, unpacked
from flycontrol.flight.wingbeat_map import WingbeatMap
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState

FloatArray = NDArray[np.float64]

#: Steps fine enough for derivatives: kinks at reversals cost them more than they cost the flight itself.
FINE = MarchSettings(steps=800, samples=400, estimate_error=False)
DIFFERENCE = 1e-2  #: of central differences, in natural units; smaller ones would see or miss single kinks
CLOSED = 1e-9  #: largest change of a coordinate over the wingbeat, in natural units
_MOST_ITERATIONS = 25


@dataclass(frozen=True, slots=True, kw_only=True)
class PeriodicOrbit:
    """A periodic flight."""

    fly: FlappingFly
    kinematics: StrokeKinematics
    start: FlightState  #: at phase 0, at the origin, heading along x
    closure: float  #: largest change of a coordinate over the wingbeat [R f, f, rad]
    drift_W: FloatArray  #: (3,) mean velocity [m/s]
    turning: float  #: mean rate of heading, > 0 to the right [rad/s]
    iterations: int

    @property
    def coordinates(self) -> FloatArray:
        """(8,) at phase 0 [m/s, rad/s, rad]."""
        return coordinates_of(packed(self.start))

    @property
    def scales(self) -> FloatArray:
        """(8,) natural units of the coordinates."""
        return natural_scales(self.fly, self.kinematics)


def periodic_orbit(
    fly: FlappingFly,
    kinematics: StrokeKinematics,
    start: FlightState | None = None,
    *,
    settings: MarchSettings = FINE,
) -> PeriodicOrbit:
    """Newton's method on the wingbeat map.

    Parameters
    ----------
    fly
        With prescribed wings and all body freedoms that its periodic flight may use; held ones keep their value.
    kinematics
        A periodic stroke, symmetric or not.
    start
        Where the search begins; by default at rest, stroke plane level. That of a `hover_trim` is best.
    settings
        Steps a wingbeat.

    Raises
    ------
    InvalidParameterError
        No periodic flight is found from there.
    """
    beat, scales = WingbeatMap(fly, kinematics, settings), natural_scales(fly, kinematics)
    z = np.zeros(len(COORDINATES)) if start is None else coordinates_of(packed(start)) / scales
    left = np.inf
    for iteration in range(_MOST_ITERATIONS):
        y = state_at(kinematics, z * scales)
        end = beat(y).end
        change = coordinates_of(end) / scales - z
        before, left = left, float(np.max(np.abs(change)))
        if left < CLOSED and not left < 0.1 * before:  # Newton goes on while it gains
            return _orbit(beat, y, end, left, iteration)
        slope = np.eye(len(z)) - scaled_monodromy(beat, z, DIFFERENCE)
        z = z + np.linalg.lstsq(slope, change, rcond=1e-9)[0]  # held coordinates do not change: they stay
    raise InvalidParameterError(
        f"No periodic flight was found in {_MOST_ITERATIONS} Newton steps: a wingbeat still changes the state by "
        f"{left:.2g} (wing lengths or radians a wingbeat). Trim the stroke first, and begin at the trim's start."
    )


def scaled_monodromy(beat: WingbeatMap, z: FloatArray, difference: float) -> FloatArray:
    """(8, 8) central differences of the wingbeat map at z (8,), in natural units."""
    scales = natural_scales(beat.fly, beat.stroke)

    def ended(at: FloatArray) -> FloatArray:
        return coordinates_of(beat(state_at(beat.stroke, at * scales)).end) / scales

    steps = difference * np.eye(len(z))
    return np.stack([(ended(z + step) - ended(z - step)) / (2 * difference) for step in steps], axis=1)


def _orbit(beat: WingbeatMap, y: FloatArray, end: FloatArray, left: float, iterations: int) -> PeriodicOrbit:
    heading = attitude_angles(end[QUATERNION:VELOCITY])[2]
    return PeriodicOrbit(
        fly=beat.fly,
        kinematics=beat.stroke,
        start=unpacked(y),
        closure=left,
        drift_W=(end - y)[:QUATERNION] / beat.period,
        turning=float(heading) / beat.period,
        iterations=iterations,
    )

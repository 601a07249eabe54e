"""The trimmed fly of the stability tests, with what was found of it; each piece is computed once."""

from functools import cache

from simulated_fly import FLY

from flycontrol.flight.floquet import FloquetModes, floquet_modes
from flycontrol.flight.linearised_flight import LinearisedFlight, linearised_flight
from flycontrol.flight.periodic_orbit import PeriodicOrbit, periodic_orbit
from flycontrol.flight.stroke_derivatives import StrokeDerivatives, stroke_derivatives
from flycontrol.flight.trim import HoverTrim, hover_trim
from flycontrol.model.stroke_kinematics import hover_stroke


@cache
def trim() -> HoverTrim:
    return hover_trim(FLY, hover_stroke())


@cache
def orbit() -> PeriodicOrbit:
    return periodic_orbit(FLY, trim().kinematics, trim().start)


@cache
def floquet() -> FloquetModes:
    return floquet_modes(orbit())


@cache
def linearised() -> LinearisedFlight:
    return linearised_flight(orbit())


@cache
def derivatives() -> StrokeDerivatives:
    return stroke_derivatives(FLY, trim().kinematics)

"""Floquet analysis of a periodic flight: does a small disturbance grow from wingbeat to wingbeat?

    delta x(k T) = M^k delta x(0),    M = dP/dx at x*,    mu = eigenvalues of M,    lambda = f ln mu

P is the wingbeat map in the eight coordinates of `body_coordinates`; position and heading add four multipliers that are
exactly 1. M comes from central differences. Lift changes sign with the flow where its coefficient is not 0, so that it
jumps at reversal; when it jumps depends on the state, and a difference that is too small between two steps of time
misses that. Hence wide differences (0.01 in natural units) and many steps, and the error of every exponent is stated:
what differences twice as wide change, and what half as many steps change.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.flight_modes import FlightMode, flight_modes
from flycontrol.flight.periodic_orbit import DIFFERENCE, FINE, PeriodicOrbit, scaled_monodromy
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.wingbeat_map import WingbeatMap

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, kw_only=True)
class FloquetModes:
    """How a periodic flight answers small disturbances."""

    orbit: PeriodicOrbit
    monodromy: FloatArray  #: (8, 8) M in the coordinates' SI units
    modes: tuple[FlightMode, ...]  #: fastest growth first
    errors: tuple[float, ...]  #: of each exponent [1/s]

    @property
    def period(self) -> float:
        """Of the wingbeat [s]."""
        return 1.0 / self.orbit.kinematics.frequency

    @property
    def multipliers(self) -> ComplexArray:
        """(8,) eigenvalues of M."""
        return np.linalg.eigvals(self.monodromy).astype(np.complex128)

    @property
    def stable(self) -> bool:
        """Whether every disturbance of velocity and attitude decays."""
        return all(mode.stable for mode in self.modes)


def floquet_modes(orbit: PeriodicOrbit, *, settings: MarchSettings = FINE) -> FloquetModes:
    """Linearise the wingbeat map about an orbit that was found with the same settings.

    Parameters
    ----------
    orbit
        Of `periodic_orbit`.
    settings
        Steps a wingbeat.
    """
    coarse = replace(settings, steps=2 * (settings.steps // 4), samples=1)
    monodromy = _monodromy(orbit, settings, DIFFERENCE)
    others = [_monodromy(orbit, settings, 2 * DIFFERENCE), _monodromy(orbit, coarse, DIFFERENCE)]
    frequency = orbit.kinematics.frequency
    multipliers, vectors = np.linalg.eig(monodromy)
    modes = flight_modes(_exponents(multipliers, frequency), vectors.astype(np.complex128))
    apart = [_exponents(np.linalg.eigvals(other), frequency) for other in others]
    errors = tuple(float(sum(np.min(np.abs(other - mode.exponent)) for other in apart)) for mode in modes)
    scales = orbit.scales
    return FloquetModes(orbit=orbit, monodromy=monodromy * scales[:, None] / scales, modes=modes, errors=errors)


def _exponents(multipliers: np.ndarray, frequency: float) -> ComplexArray:
    return np.asarray(frequency * np.log(multipliers.astype(np.complex128)), dtype=np.complex128)


def _monodromy(orbit: PeriodicOrbit, settings: MarchSettings, difference: float) -> FloatArray:
    beat = WingbeatMap(orbit.fly, orbit.kinematics, settings)
    return scaled_monodromy(beat, orbit.coordinates / orbit.scales, difference)

"""Flight linearised about a periodic orbit, phase by phase, and averaged over the wingbeat.

    x' = A(t) x,    A(t + T) = A(t)
    first order:   A_1 = <A>
    second order:  A_2 = <A> + <A~ U>,    A~ = A - <A>,  U' = A~,  <U> = 0

What first-order averaging leaves out is rectified: a motion makes a load that alternates between half strokes, the load
makes a motion in quadrature with it, and that motion, times the alternating load again, has a mean. The transition
matrix of x' = A(t) x is the wingbeat map's derivative: an independent computation of the same multipliers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.body_coordinates import PITCH, ROLL, attitude, attitude_rates, coordinates_of
from flycontrol.flight.flight_modes import FlightMode, modes_of_generator
from flycontrol.flight.kernels.inverse import generalised_forces
from flycontrol.flight.kernels.march import QUATERNION, SPIN, STATES, VELOCITY
from flycontrol.flight.multibody.constants import Constants, constants_of
from flycontrol.flight.periodic_orbit import DIFFERENCE, FINE, PeriodicOrbit
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import packed
from flycontrol.flight.wingbeat_map import WingbeatMap

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearisedFlight:
    """A(t) of x = (u, v, w, p, q, r, phi, theta), SI units, at even phases of the wingbeat."""

    matrices: FloatArray  #: (n, 8, 8), n even
    period: float  #: [s]
    scales: FloatArray  #: (8,) natural units

    @property
    def first_order(self) -> FloatArray:
        """(8, 8) <A>."""
        return self.matrices.mean(axis=0)

    @property
    def second_order(self) -> FloatArray:
        """(8, 8) <A> + <A~ U>."""
        swing = self.matrices - self.first_order
        beats = np.fft.fftfreq(len(swing)) * len(swing)
        beats[0] = 1.0  # the swing has no mean, and so <U> = 0
        spectrum = np.fft.fft(swing, axis=0) / (2j * np.pi * beats / self.period)[:, None, None]
        return self.first_order + np.real(swing @ np.fft.ifft(spectrum, axis=0)).mean(axis=0)

    @property
    def transition(self) -> FloatArray:
        """(8, 8) X(T) of X' = A(t) X, X(0) = 1, by Runge-Kutta steps of two phases."""
        X, h = np.eye(len(self.scales)), 2 * self.period / len(self.matrices)
        ends = np.roll(self.matrices, -2, axis=0)
        for a, b, c in zip(self.matrices[::2], self.matrices[1::2], ends[::2], strict=True):
            k1 = a @ X
            k2 = b @ (X + h / 2 * k1)
            k3 = b @ (X + h / 2 * k2)
            k4 = c @ (X + h * k3)
            X = X + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return X

    def modes(self, order: int) -> tuple[FlightMode, ...]:
        """Of the flight averaged to first or second order, fastest growth first."""
        return modes_of_generator(self.first_order if order == 1 else self.second_order, self.scales)


def linearised_flight(orbit: PeriodicOrbit, *, settings: MarchSettings = FINE) -> LinearisedFlight:
    """Differentiate the accelerations along a periodic orbit: M(t) dx' = -d(required loads), central differences.

    Parameters
    ----------
    orbit
        Found with the same settings; freedoms that the fly holds stay held.
    settings
        `steps` is the number of phases.
    """
    every = MarchSettings(steps=settings.steps, samples=settings.steps, estimate_error=False)
    samples = WingbeatMap(orbit.fly, orbit.kinematics, every)(packed(orbit.start)).samples
    constants = constants_of(orbit.fly, orbit.kinematics.frequency)
    x, scales = coordinates_of(samples), orbit.scales
    matrices, period = np.zeros((len(x), 8, 8)), 1.0 / orbit.kinematics.frequency
    free = np.flatnonzero(orbit.fly.body.mask)
    inertia = _inertia(constants, samples, scales[:ROLL] / period)[:, free[:, None], free]
    for k, step in enumerate(DIFFERENCE * scales):
        ahead, back = (_at(samples, x + sign * step * np.eye(8)[k]) for sign in (1, -1))
        loads = (_required(constants, ahead) - _required(constants, back)) / (2 * step)
        matrices[:, free, k] = -np.linalg.solve(inertia, loads[:, free, None])[..., 0]
        turned = attitude_rates(coordinates_of(ahead)) - attitude_rates(coordinates_of(back))
        matrices[:, ROLL:, k] = turned / (2 * step)
    return LinearisedFlight(matrices=matrices, period=period, scales=scales)


def _required(constants: Constants, samples: FloatArray) -> FloatArray:
    """(n, 6) loads that must act on the body for its accelerations to be as they are."""
    forces = np.empty((len(samples), 12))
    c = constants
    generalised_forces(samples, c.gravity, c.body, c.wings, c.blades, c.polynomials, forces)
    return forces[:, :6]


def _inertia(constants: Constants, samples: FloatArray, accelerations: FloatArray) -> FloatArray:
    """(n, 6, 6) mass matrix: loads are linear in the accelerations."""
    as_flown = _required(constants, samples)
    columns = []
    for k, rate in enumerate(accelerations):
        accelerated = samples.copy()
        accelerated[:, STATES + k] += rate
        columns.append((_required(constants, accelerated) - as_flown) / rate)
    return np.stack(columns, axis=2)


def _at(samples: FloatArray, x: FloatArray) -> FloatArray:
    """Samples with the body's coordinates replaced, accelerations as they were."""
    moved = samples.copy()
    moved[:, VELOCITY : SPIN + 3] = x[:, :ROLL]
    moved[:, QUATERNION:VELOCITY] = attitude(x[:, ROLL], x[:, PITCH], np.zeros(len(x)))
    return moved

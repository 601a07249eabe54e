"""A plate that falls freely through still fluid in two dimensions: flutter and tumbling.  Review, Fig. 3a.

An ellipse with semi-axes a > b and density rho_s in a fluid of density rho_f; u and v its velocity along the major and
the minor axis, theta the angle of the major axis above the horizontal, w = theta'. With lengths in a, speeds in
U = sqrt((rho_s / rho_f - 1) g b), I* = rho_s b / (rho_f a) and beta = b / a (andersen2005transitions, Eq. 4.4-4.9, S2):

    (I* + beta^2) u' = (I* + 1) w v - G v - sin(theta) - F_u
    (I* + 1) v' = -(I* + beta^2) w u + G u - cos(theta) - F_v
    (I* (1 + beta^2) + (1 - beta^2)^2 / 2) / 4 w' = (beta^2 - 1) u v - (mu_1 + mu_2 |w|) w

    circulation  G = 2 / pi (C_R w - C_T u v / |(u, v)|)
    drag  (F_u, F_v) = (A - B (u^2 - v^2) / (u^2 + v^2)) |(u, v)| (u, v) / pi

Added masses are those of an ellipse in an ideal fluid; beta = 0 is the limit of a thin card. The circulation does no
work. I* is not that of andersen2005, which is (1 + beta^2) / 2 times as large.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import cos, hypot, inf, pi, sin, sqrt
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.morphology import GRAVITY

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlateCoefficients:
    """What the fluid does to a plate; without rotation its lift and drag are those of wang2004.

    mu_1 and mu_2 were chosen by their authors for falls that look right, and not fitted.
    """

    translation: float = 1.2  #: C_T, circulation of a plate that does not rotate
    rotation: float = pi  #: C_R, circulation of a plate that rotates
    drag: float = 1.4  #: A, mean of the broadside and the edgewise drag
    drag_swing: float = 1.0  #: B, half their difference
    dissipation: tuple[float, float] = (0.2, 0.2)  #: mu_1, mu_2

    def __post_init__(self) -> None:
        if not self.drag >= abs(self.drag_swing):
            raise InvalidParameterError(
                f"PlateCoefficients.drag must be at least |drag_swing|, or drag would push; got {self.drag!r} and "
                f"{self.drag_swing!r}."
            )
        if not min(self.dissipation) >= 0:
            raise InvalidParameterError(f"PlateCoefficients.dissipation must be >= 0, got {self.dissipation!r}.")


IDEAL_FLUID = PlateCoefficients(translation=0.0, rotation=0.0, drag=0.0, drag_swing=0.0, dissipation=(0.0, 0.0))
"""Neither circulation nor dissipation: Kirchhoff's equations."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FallingPlate:
    """An elliptic plate; where half width and speed are left at 1, every result is dimensionless."""

    inertia_ratio: float  #: I* = rho_s b / (rho_f a)
    thickness_ratio: float = 0.0  #: beta = b / a
    half_width: float = 1.0  #: a [m]
    speed: float = 1.0  #: U [m/s]
    coefficients: PlateCoefficients = field(default_factory=PlateCoefficients)

    def __post_init__(self) -> None:
        for name in ("inertia_ratio", "half_width", "speed"):
            value = getattr(self, name)
            if not 0 < value < inf:  # refuses NaN too
                raise InvalidParameterError(f"FallingPlate.{name} must be > 0, got {value!r}.")
        if not 0 <= self.thickness_ratio < 1:
            raise InvalidParameterError(
                f"FallingPlate.thickness_ratio is thickness over width, from 0 to 1, got {self.thickness_ratio!r}."
            )

    @property
    def time(self) -> float:
        """a / U [s]."""
        return self.half_width / self.speed

    @property
    def edgewise_speed(self) -> float:
        """V = U sqrt(pi / (A - B)): steady fall along the major axis, Eq. 6.1 [m/s]."""
        return self.speed * sqrt(pi / (self.coefficients.drag - self.coefficients.drag_swing))

    @property
    def broadside_speed(self) -> float:
        """W = U sqrt(pi / (A + B)): steady fall along the minor axis, Eq. 6.2 [m/s]."""
        return self.speed * sqrt(pi / (self.coefficients.drag + self.coefficients.drag_swing))


def plate_of(
    width: float,
    thickness: float,
    density: float,
    fluid_density: float,
    coefficients: PlateCoefficients | None = None,
) -> FallingPlate:
    """I* = rho_s b / (rho_f a), beta = b / a, U = sqrt((rho_s / rho_f - 1) g b) of a plate of some material.

    Parameters
    ----------
    width, thickness : 2a and 2b [m]
    density, fluid_density : rho_s and rho_f [kg/m^3]
    """
    if not density > fluid_density > 0:
        raise InvalidParameterError(
            f"A plate that falls is denser than its fluid; got {density!r} in a fluid of {fluid_density!r} kg/m^3."
        )
    if not width > thickness > 0:
        raise InvalidParameterError(f"A plate is wider than it is thick; got {width!r} m and {thickness!r} m.")
    return FallingPlate(
        inertia_ratio=density * thickness / (fluid_density * width),
        thickness_ratio=thickness / width,
        half_width=width / 2,
        speed=sqrt((density / fluid_density - 1) * GRAVITY * thickness / 2),
        coefficients=coefficients or PlateCoefficients(),
    )


def effective_inertias(plate: FallingPlate) -> tuple[float, float, float]:
    """I* + beta^2, I* + 1, (I* (1 + beta^2) + (1 - beta^2)^2 / 2) / 4: along, across and about, carried fluid included.

    Over pi rho_f a^2, and about the centre over pi rho_f a^4, a unit of span.
    """
    inertia, square = plate.inertia_ratio, plate.thickness_ratio**2
    return inertia + square, inertia + 1, (inertia * (1 + square) + (1 - square) ** 2 / 2) / 4


def plate_acceleration(plate: FallingPlate, u: float, v: float, w: float, theta: float) -> tuple[float, float, float]:
    """u', v', w' by Eq. 4.4-4.9, from u, v, w and theta, all dimensionless: speeds over U, times over a / U."""
    along, across, about = effective_inertias(plate)
    c = plate.coefficients
    speed = hypot(u, v)
    stall, slip = (u * v / speed, (u * u - v * v) / speed) if speed else (0.0, 0.0)
    circulation = 2 / pi * (c.rotation * w - c.translation * stall)
    drag = (c.drag * speed - c.drag_swing * slip) / pi
    friction = (c.dissipation[0] + c.dissipation[1] * abs(w)) * w
    return (
        (across * w * v - circulation * v - sin(theta) - drag * u) / along,
        (-along * w * u + circulation * u - cos(theta) - drag * v) / across,
        ((along - across) * u * v - friction) / about,
    )


def steady_fall_modes(plate: FallingPlate, attitude: Literal["edgewise", "broadside"]) -> ComplexArray:
    """Eigenvalues (4,) of small departures in u, v, w and theta from a steady fall, rightmost first [1/s].

    By central differences of `plate_acceleration`, good to about 1e-9 of U / a; |w| w has no slope at rest and is left
    out, since its differences would have one.
    """
    smooth = replace(plate.coefficients, dissipation=(plate.coefficients.dissipation[0], 0.0))
    linear = replace(plate, coefficients=smooth)
    edgewise = (-plate.edgewise_speed / plate.speed, 0.0, 0.0, pi / 2)
    broadside = (0.0, -plate.broadside_speed / plate.speed, 0.0, 0.0)
    steady = np.array(edgewise if attitude == "edgewise" else broadside)
    jacobian = np.zeros((4, 4))
    jacobian[3, 2] = 1.0  # theta' = w
    step = 1e-5
    for k, departure in enumerate(step * np.eye(4)):
        ahead = plate_acceleration(linear, *(steady + departure).tolist())
        behind = plate_acceleration(linear, *(steady - departure).tolist())
        jacobian[:3, k] = (np.array(ahead) - behind) / (2 * step)
    modes = np.linalg.eigvals(jacobian).astype(np.complex128)
    return modes[np.argsort(-modes.real)] / plate.time

"""What the air is taken to do to a flapping wing: which terms, with which coefficients."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.coefficients import COEFFICIENTS, CoefficientName

Term = Literal["translational", "rotational", "added_mass", "dissipative"]
TERMS: tuple[Term, ...] = ("translational", "rotational", "added_mass", "dissipative")

AIR_DENSITY = 1.19  #: at 24 degrees Celsius and 101.3 kPa [kg/m^3]


@dataclass(frozen=True, slots=True, kw_only=True)
class QuasiSteadyModel:
    """Coefficients by name, density, blades a wing, and the terms beyond steady translation.

    Per unit of span, u the blade's velocity at the pitch axis, w_s the wing's angular velocity about its span:

    - translational: 1/2 rho c |u| (C_D (-u) + C_L across u), a the attack angle (dickinson1999);
    - rotational: rho C_R c^2 w_s (-u_n, u_c), C_R = pi (0.75 - x0) (sane2002);
    - added mass: m22 = pi rho c^2 / 4 on the normal acceleration of mid-chord, I_a = pi rho c^4 / 128 on w_s'
      (andersen2005); it is part of the mass matrix, so no acceleration has to be known beforehand;
    - dissipative: -pi rho c^4 / 16 (mu_1 f + mu_2 |w_s|) w_s (berman2007).

    Translational and rotational force act at the centre of pressure, (d_0 + d_1 a / pi) of the chord from the leading
    edge, a from 0 to 180 deg.
    """

    coefficients: CoefficientName = "dickinson1999"
    air_density: float = AIR_DENSITY  #: [kg/m^3]
    nodes: int = 6  #: blades a wing
    rotational_coefficient: float | None = None  #: C_R; None: pi (0.75 - x0) of the fly's pitch axis
    centre_of_pressure: tuple[float, float] = (0.05, 0.82)  #: d_0, d_1 [chords]
    dissipation: tuple[float, float] = (0.2, 0.2)  #: mu_1, mu_2
    terms: tuple[Term, ...] = TERMS

    def __post_init__(self) -> None:
        if self.coefficients not in COEFFICIENTS:
            known = ", ".join(COEFFICIENTS)
            raise InvalidParameterError(f"Coefficients {self.coefficients!r} are not known; choose one of {known}.")
        if not self.air_density > 0:
            raise InvalidParameterError(f"QuasiSteadyModel.air_density must be > 0 kg/m^3, got {self.air_density!r}.")
        if not self.nodes >= 1:
            raise InvalidParameterError(f"QuasiSteadyModel.nodes must be at least 1, got {self.nodes!r}.")
        if unknown := set(self.terms) - set(TERMS):
            raise InvalidParameterError(f"Terms {sorted(unknown)} are not known; choose from {', '.join(TERMS)}.")

    def rotation(self, pitch_axis: float) -> float:
        """C_R at the pitch axis x0 [chords from the leading edge]."""
        if self.rotational_coefficient is not None:
            return self.rotational_coefficient
        return np.pi * (0.75 - pitch_axis)


VACUUM = QuasiSteadyModel(terms=())  #: no air

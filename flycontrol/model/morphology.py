"""What a fly is to the air and to Newton: mass, wings, hinges and inertia, in the stroke-plane frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.units import mg, mm

FloatArray = NDArray[np.float64]
Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

GRAVITY = 9.81  #: [m/s^2]


@dataclass(frozen=True, slots=True, kw_only=True)
class Morphology:
    """A fly with two mirror-image wings; the stroke-plane frame S is fixed to the body: x forward, y right, z down."""

    species: str
    mass: float  #: [kg]
    wing_length: float  #: hinge to tip, R [m]
    mean_chord: float  #: one wing's area over R [m]
    second_moment_radius: float  #: r2 / R of the wing's area
    right_hinge: Vector  #: from the centre of mass, frame S [m]; the left hinge is its mirror image
    inertia: Matrix  #: about the centre of mass, frame S [kg m^2]
    stroke_plane_angle: float  #: v_S = Ry(angle) v_B [rad]
    source: str = ""  #: where the numbers come from and how certain they are

    def __post_init__(self) -> None:
        for name in ("mass", "wing_length", "mean_chord"):
            value = getattr(self, name)
            if not value > 0:  # `not >` also refuses NaN
                raise InvalidParameterError(f"Morphology.{name} must be > 0, got {value!r}.")
        if not 0.4 < self.second_moment_radius < 0.8:
            raise InvalidParameterError(
                "Morphology.second_moment_radius must lie in 0.4..0.8 of the wing length, "
                f"got {self.second_moment_radius!r}."
            )
        inertia = self.inertia_S
        if not np.allclose(inertia, inertia.T) or not np.all(np.linalg.eigvalsh(inertia) > 0):
            raise InvalidParameterError("Morphology.inertia must be a symmetric matrix with positive eigenvalues.")

    @property
    def weight(self) -> float:
        """M g [N]."""
        return self.mass * GRAVITY

    @property
    def wing_area(self) -> float:
        """Area of one wing [m^2]."""
        return self.wing_length * self.mean_chord

    @property
    def inertia_S(self) -> FloatArray:
        """(3, 3) inertia about the centre of mass in the stroke-plane frame [kg m^2]."""
        return np.array(self.inertia, dtype=np.float64)

    @property
    def yaw_inertia(self) -> float:
        """I about the stroke-plane normal, wings and products of inertia left out [kg m^2]."""
        return self.inertia[2][2]


def pitch_rotation(angle: float) -> FloatArray:
    """Ry(angle) = [[c, 0, s], [0, 1, 0], [-s, 0, c]], (3, 3); v_S = Ry(stroke_plane_angle) v_B."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def slender_inertia(roll: float, pitch: float, yaw: float) -> Matrix:
    """I_xz = sqrt((I_yy - I_xx) (I_yy - I_zz)): the product of inertia of a body of revolution that is pitched nose up.

    A body of revolution about its long axis n has I = I_t 1 - (I_t - I_n) n n^T. Given its three moments about axes
    pitched in its plane of symmetry, I_t = I_yy and the product follows. Arguments and result in [kg m^2], frame S.
    """
    if not (pitch >= roll > 0 and pitch >= yaw > 0 and roll + yaw > pitch):
        raise InvalidParameterError(
            f"Moments of inertia {roll!r}, {pitch!r}, {yaw!r} kg m^2 are not those of a slender body of revolution."
        )
    product = float(np.sqrt((pitch - roll) * (pitch - yaw)))
    return ((roll, 0.0, product), (0.0, pitch, 0.0), (product, 0.0, yaw))


def drosophila_hydei(wingbeat_frequency: float = 189.0) -> Morphology:
    """*D. hydei* as the laboratory of the free-flight recordings takes it.

    Inertia is published as (0.64, 1.07, 0.57) m g R / f^2 about the stroke plane's axes; `wingbeat_frequency` [1/s]
    is the f of that scaling. The product of inertia is not published: it is that of a body of revolution
    (`slender_inertia`), which puts the long axis 47 deg above the stroke plane. The hinge is that of *D. melanogaster*
    scaled with wing length 3.0 / 2.4 and pitched into the stroke plane: uncertain by 0.3 mm forward or back.
    """
    mass, length = 1.8 * mg, 3.0 * mm
    scale = mass * GRAVITY * length / wingbeat_frequency**2
    angle = np.radians(55.0)
    hinge_B = np.array([0.22, 0.45, -0.375]) * mm * (3.0 / 2.4)
    return Morphology(
        species="Drosophila hydei",
        mass=mass,
        wing_length=length,
        mean_chord=length / 3.158,
        second_moment_radius=0.58,
        right_hinge=cast(Vector, tuple(float(v) for v in pitch_rotation(angle) @ hinge_B)),
        inertia=slender_inertia(0.64 * scale, 1.07 * scale, 0.57 * scale),
        stroke_plane_angle=float(angle),
        source="mass, wing and moments of inertia S2 (the recordings' laboratory); hinge scaled from D. melanogaster",
    )

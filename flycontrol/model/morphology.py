"""What a fly is to the air and to Newton: mass, wings, hinges and inertia, in the stroke-plane frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.planform import ChordTable, Planform
from flycontrol.model.wing_body import WingBody, refuse_beyond_outline, thin_plate
from flycontrol.units import mg, mm, ug

FloatArray = NDArray[np.float64]
Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

GRAVITY = 9.81  #: [m/s^2]
WING_MASS_OVER_MASS = 2.4 * ug / (1.1 * mg)  #: one wing (berman2007) over the fly (cheng2009)

#: From beyond the smallest wasp to beyond the largest moth: lowest, highest, unit, and how else it may be written.
_SIZES = {
    "mass": (1e-10, 0.1, "kilograms", "1.1 * mg for 1.1 milligrams"),
    "wing_length": (5e-5, 0.2, "metres", "2.4 * mm for 2.4 millimetres"),
    "mean_chord": (1e-6, 0.2, "metres", "0.7 * mm for 0.7 millimetres"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Morphology:
    """A fly with two mirror-image wings; the stroke-plane frame S is fixed to the body: x forward, y right, z down."""

    species: str
    mass: float  #: of the whole fly, wings included [kg]
    wing_length: float  #: hinge to tip, R [m]
    mean_chord: float  #: one wing's area over R [m]
    second_moment_radius: float  #: r2 / R of the wing's area
    right_hinge: Vector  #: from the centre of mass, frame S [m]; the left hinge is its mirror image
    inertia: Matrix  #: of the body without wings about its centre of mass, frame S [kg m^2]
    stroke_plane_angle: float  #: v_S = Ry(angle) v_B [rad]
    pitch_axis: float = 0.25  #: x0, from the leading edge, in chords
    chord_table: ChordTable | None = None  #: in place of the beta distribution with r2
    wing: WingBody | None = None  #: in place of a plate of even thickness with the published share of the mass

    def __post_init__(self) -> None:
        for name, (low, high, unit, example) in _SIZES.items():
            value = getattr(self, name)
            if not low <= value <= high:  # `not <=` also refuses NaN
                raise InvalidParameterError(
                    f"Morphology.{name} must lie in {low:g}..{high:g} {unit}, as that of anything that flaps does, got "
                    f"{value!r}; write {example} (flycontrol.units)."
                )
        if not 0.4 < self.second_moment_radius < 0.8:
            raise InvalidParameterError(
                "Morphology.second_moment_radius must lie in 0.4..0.8 of the wing length, "
                f"got {self.second_moment_radius!r}."
            )
        if not 0.0 <= self.pitch_axis <= 1.0:
            raise InvalidParameterError(f"Morphology.pitch_axis must lie in 0..1 chords, got {self.pitch_axis!r}.")
        _refuse_hinge(self.right_hinge)
        if not np.isfinite(self.stroke_plane_angle):
            raise InvalidParameterError(
                f"Morphology.stroke_plane_angle must be finite, got {self.stroke_plane_angle!r} rad."
            )
        _refuse_impossible(self.inertia_S)
        if self.wing is not None:
            _refuse_heavy_wings(self.wing, self.mass)
            refuse_beyond_outline(self.wing, self.planform, self.pitch_axis)

    @property
    def weight(self) -> float:
        """M g [N]."""
        return self.mass * GRAVITY

    @property
    def wing_area(self) -> float:
        """Area of one wing [m^2]."""
        return self.wing_length * self.mean_chord

    @property
    def planform(self) -> Planform:
        """Outline of one wing."""
        return Planform(
            length=self.wing_length,
            mean_chord=self.mean_chord,
            second_moment_radius=self.second_moment_radius,
            table=self.chord_table,
        )

    @property
    def wing_body(self) -> WingBody:
        """Mass and inertia of one wing."""
        if self.wing is not None:
            return self.wing
        return thin_plate(self.planform, WING_MASS_OVER_MASS * self.mass, self.pitch_axis)

    @property
    def inertia_S(self) -> FloatArray:
        """(3, 3) inertia about the centre of mass in the stroke-plane frame [kg m^2]."""
        return np.array(self.inertia, dtype=np.float64)

    @property
    def yaw_inertia(self) -> float:
        """I about the stroke-plane normal, wings and products of inertia left out [kg m^2]."""
        return self.inertia[2][2]


def _refuse_hinge(right_hinge: Vector) -> None:
    if not (len(right_hinge) == 3 and np.all(np.isfinite(right_hinge)) and right_hinge[1] >= 0):
        raise InvalidParameterError(
            "Morphology.right_hinge must be three finite lengths of which the second, to the right, is >= 0 m, got "
            f"{right_hinge!r}; is it the left one?"
        )


def _refuse_heavy_wings(wing: WingBody, mass: float) -> None:
    if not 2 * wing.mass < mass:
        raise InvalidParameterError(
            f"Two wings of {wing.mass!r} kg do not fit into a fly of {mass!r} kg; check their units."
        )


def _refuse_impossible(inertia: FloatArray) -> None:
    if not (inertia.shape == (3, 3) and np.all(np.isfinite(inertia))):
        raise InvalidParameterError(
            f"Morphology.inertia must be three rows of three finite numbers, got {inertia.tolist()!r}."
        )
    if not np.allclose(inertia, inertia.T, rtol=1e-9, atol=0.0):
        raise InvalidParameterError("Morphology.inertia must be a symmetric matrix.")
    low, middle, high = np.linalg.eigvalsh(inertia)
    if not (low > 0 and low + middle >= high):
        raise InvalidParameterError(
            "Morphology.inertia must have positive principal moments of which the largest is at most the sum of the "
            f"other two, as every body has; got {low:.3g}, {middle:.3g}, {high:.3g} kg m^2. Check units and products."
        )


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


def morphology_from_table(
    table: Mapping[str, float | tuple[float, ...]], species: str, wingbeat_frequency: float
) -> Morphology:
    """Complete the [morphology] section of a fly file; what it leaves out is that of *D. melanogaster*, scaled.

    Parameters
    ----------
    table
        mass [kg], wing_length [m], wing_length_over_mean_chord, and where known second_moment_radius, right_hinge
        (body axes, [m]), stroke_plane_angle [rad], stroke_plane_inertia_over_mgr_per_f2 (moments about x, y, z of the
        stroke-plane frame over m g R / f^2; the product of inertia is that of a body of revolution).
    species
        Its name.
    wingbeat_frequency
        f of the inertia's scaling [1/s].
    """
    mass, length = float(cast(float, table["mass"])), float(cast(float, table["wing_length"]))
    angle = float(cast(float, table.get("stroke_plane_angle", np.radians(55.0))))
    hinge_B = np.array(table.get("right_hinge", tuple(np.array(_HINGE_OVER_R) * length)))
    moments = table.get("stroke_plane_inertia_over_mgr_per_f2")
    if moments is None:
        inertia = _scaled_inertia(mass, length, angle)
    else:
        roll, pitch, yaw = np.array(moments) * mass * GRAVITY * length / wingbeat_frequency**2
        inertia = slender_inertia(float(roll), float(pitch), float(yaw))
    return Morphology(
        species=species,
        mass=mass,
        wing_length=length,
        mean_chord=length / float(cast(float, table["wing_length_over_mean_chord"])),
        second_moment_radius=float(cast(float, table.get("second_moment_radius", 0.58))),
        right_hinge=_vector(pitch_rotation(angle) @ hinge_B),
        inertia=inertia,
        stroke_plane_angle=angle,
    )


def drosophila_hydei(wingbeat_frequency: float = 189.0) -> Morphology:
    """*D. hydei* as the laboratory of the free-flight recordings takes it (freeflightplots, S2).

    The product of inertia is not published: that of a body of revolution puts the long axis 47 deg above the stroke
    plane. The hinge is that of *D. melanogaster* scaled with wing length: uncertain by some 0.3 mm forward or back.
    `wingbeat_frequency` [1/s] scales the inertia.
    """
    table: dict[str, float | tuple[float, ...]] = {
        "mass": 1.8 * mg,
        "wing_length": 3.0 * mm,
        "wing_length_over_mean_chord": 3.158,
        "stroke_plane_angle": float(np.radians(55.0)),
        "stroke_plane_inertia_over_mgr_per_f2": (0.64, 1.07, 0.57),
    }
    return morphology_from_table(table, "Drosophila hydei", wingbeat_frequency)


_HINGE_OVER_R = (0.22 / 2.4, 0.465 / 2.4, -0.375 / 2.4)  # D. melanogaster, body axes


def _scaled_inertia(mass: float, length: float, angle: float) -> Matrix:
    """I = I_t 1 - (I_t - I_n) n n^T with cheng2009's moments of *D. melanogaster*, over m R^2."""
    scale = mass * length**2 / (1.1 * mg * (2.4 * mm) ** 2)
    nose = pitch_rotation(angle) @ np.array([1.0, 0.0, 0.0])
    inertia = scale * (5.06e-13 * np.eye(3) - (5.06e-13 - 1.145e-13) * np.outer(nose, nose))
    return (_vector(inertia[0]), _vector(inertia[1]), _vector(inertia[2]))


def _vector(values: FloatArray) -> Vector:
    x, y, z = (float(v) for v in values)
    return (x, y, z)

"""Mass and inertia of one wing, about its hinge and along its own axes: span, chord, normal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.errors import InvalidParameterError
from flycontrol.model.planform import Planform

#: Moments of real bodies keep the triangle inequality; a flat wing meets it with equality, up to rounding.
_FLAT = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class WingBody:
    """A rigid wing, mirror-symmetric about its own plane; chord counts towards the leading edge from the pitch axis."""

    mass: float  #: [kg]
    centre: tuple[float, float]  #: centre of mass along span and chord, from the hinge [m]
    span_inertia: float  #: about the pitch axis [kg m^2]
    chord_inertia: float  #: about the chord through the hinge [kg m^2]
    normal_inertia: float  #: about the normal through the hinge [kg m^2]
    product: float = 0.0  #: - sum of m s c [kg m^2]

    def __post_init__(self) -> None:
        if not (self.mass > 0 and np.isfinite(self.mass)):
            raise InvalidParameterError(f"WingBody.mass must be > 0 kg, got {self.mass!r}.")
        s, c = self.centre
        m = self.mass
        central = np.array([[self.span_inertia - m * c * c, self.product + m * s * c], [0.0, 0.0]])
        central[1] = [central[0, 1], self.chord_inertia - m * s * s]
        low, high = np.linalg.eigvalsh(central)
        third = self.normal_inertia - m * (s * s + c * c)
        if not (low > 0 and low + high >= third * (1 - _FLAT) and low + third >= high * (1 - _FLAT)):
            raise InvalidParameterError(
                "No wing has these moments about its centre of mass: two of them must be positive and the sum of any "
                f"two at least the third, got {low:.3g}, {high:.3g}, {third:.3g} kg m^2; check masses and units."
            )


def thin_plate(planform: Planform, mass: float, pitch_axis: float) -> WingBody:
    """Mass spread evenly over the planform, whose pitch axis lies at the fraction x0 of every chord.

    I_ss = sigma integral of c^3 (x0^3 + (1 - x0)^3) / 3 dr, I_cc = sigma integral of c r^2 dr, I_nn = I_ss + I_cc,
    sigma = m / S.

    Parameters
    ----------
    planform : the wing's outline
    mass : of one wing [kg]
    pitch_axis : x0, from the leading edge, in chords
    """
    x0 = pitch_axis
    density = mass / planform.moment(1)
    about_span = density * planform.moment(3) * (x0**3 + (1 - x0) ** 3) / 3
    about_chord = density * planform.moment(1, 2)
    return WingBody(
        mass=mass,
        centre=(density * planform.moment(1, 1) / mass, density * planform.moment(2) * (x0 - 0.5) / mass),
        span_inertia=about_span,
        chord_inertia=about_chord,
        normal_inertia=about_span + about_chord,
        product=-density * planform.moment(2, 1) * (x0 - 0.5),
    )


def refuse_beyond_outline(wing: WingBody, planform: Planform, pitch_axis: float) -> None:
    """0 <= s <= R and -(1 - x0) c_max <= c <= x0 c_max hold all mass, so I_ss <= m c^2 and I_cc <= m R^2 at the most.

    Raises
    ------
    InvalidParameterError
        If the mass of the wing must lie outside its outline.
    """
    R, m, c_max = planform.length, wing.mass * (1 + _FLAT), planform.largest_chord * (1 + _FLAT)
    s, c = wing.centre
    if not (0 <= s <= R * (1 + _FLAT) and -(1 - pitch_axis) * c_max <= c <= pitch_axis * c_max):
        raise InvalidParameterError(
            f"The wing's centre of mass, {s:.3g} m along the span and {c:.3g} m before the pitch axis, lies outside "
            f"the wing, which is {R:.3g} m long and at most {planform.largest_chord:.3g} m wide; check units and signs."
        )
    widest = max(pitch_axis, 1 - pitch_axis) * c_max
    for name, inertia, arm in (("span", wing.span_inertia, widest), ("chord", wing.chord_inertia, R * (1 + _FLAT))):
        if not inertia <= m * arm**2:
            raise InvalidParameterError(
                f"The wing's {name}_inertia of {inertia:.3g} kg m^2 is more than all its mass, {wing.mass:.3g} kg, has "
                f"at its outermost {arm:.3g} m, {m * arm**2:.3g} kg m^2; check units and axes."
            )

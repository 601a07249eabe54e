"""Blade elements of one wing in its own axes (span, chord, normal), attack angles from velocity ratios.

Coefficients come as P(z^2) + z Q(z^2) with z = sin(a - 45 deg) = (|u_n| - |u_c|) / (sqrt(2) |u|): no arctangent and no
sine, and whatever is smooth in the attack angle a from 0 to 90 deg converges 5.8-fold per term.
The mathematics stands in `flycontrol.flight.quasi_steady`.
"""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.flight.kernels.vectors import COMPILED

#: Rows of the blades: radius [m]; 1/2 rho c dr [kg/m]; 1/2 rho c^2 dr [kg]; C_R rho c^2 dr [kg]; C_R rho c^3 dr [kg m].
RADIUS, PRESSURE, PRESSURE_ARM, CIRCULATION, CIRCULATION_ARM = range(5)
#: Rows of the polynomials in z^2.
LIFT_EVEN, LIFT_ODD, DRAG_EVEN, DRAG_ODD, CENTRE_ODD = range(5)
_ROOT_HALF = np.sqrt(0.5)
_STILL = 1e-40  # [m^2/s^2]: keeps a blade at rest from dividing by zero


@numba.njit(**COMPILED)
def blade_loads(u_c, u_n, by_radius_c, by_radius_n, spin, blades, polynomials, centre):
    """Sum translational and rotational forces over the blades.

    A blade at r moves with (u_c + r by_radius_c, u_n + r by_radius_n); `spin` is the wing's angular velocity about its
    span; `centre` = (pitch axis less centre of pressure at 90 deg, a quarter of its travel), in chords. Returns two
    tuples (F_c, F_n, N_s, N_c, N_n), forces [N] and torques about the hinge [N m].
    """
    t_c, t_n, t_span, t_cr, t_nr = 0.0, 0.0, 0.0, 0.0, 0.0
    r_c, r_n, r_span, r_cr, r_nr = 0.0, 0.0, 0.0, 0.0, 0.0
    ahead, quarter = centre
    terms = polynomials.shape[1]
    for j in range(blades.shape[1]):
        r = blades[RADIUS, j]
        c = u_c + r * by_radius_c
        n = u_n + r * by_radius_n
        square = c * c + n * n + _STILL
        speed = np.sqrt(square)
        z = _ROOT_HALF * (abs(n) - abs(c)) / speed
        z2 = z * z
        lift_even, lift_odd = polynomials[LIFT_EVEN, terms - 1], polynomials[LIFT_ODD, terms - 1]
        drag_even, drag_odd = polynomials[DRAG_EVEN, terms - 1], polynomials[DRAG_ODD, terms - 1]
        travel = polynomials[CENTRE_ODD, terms - 1]
        for k in range(terms - 2, -1, -1):
            lift_even = lift_even * z2 + polynomials[LIFT_EVEN, k]
            lift_odd = lift_odd * z2 + polynomials[LIFT_ODD, k]
            drag_even = drag_even * z2 + polynomials[DRAG_EVEN, k]
            drag_odd = drag_odd * z2 + polynomials[DRAG_ODD, k]
            travel = travel * z2 + polynomials[CENTRE_ODD, k]
        lift = np.copysign(1.0, c * n) * (lift_even + z * lift_odd)
        drag = drag_even + z * drag_odd
        arm = ahead + np.copysign(1.0, c) * (quarter - z * travel)  # a wing moving backwards: a = 180 deg - a
        p_c = -speed * (drag * c - lift * n)
        p_n = -speed * (drag * n + lift * c)
        pressure = blades[PRESSURE, j]
        t_c += pressure * p_c
        t_n += pressure * p_n
        t_cr += pressure * r * p_c
        t_nr += pressure * r * p_n
        t_span += blades[PRESSURE_ARM, j] * arm * p_n
        circulation = blades[CIRCULATION, j] * spin
        r_c -= circulation * n
        r_n += circulation * c
        r_cr -= circulation * r * n
        r_nr += circulation * r * c
        r_span += blades[CIRCULATION_ARM, j] * spin * arm * c
    return (t_c, t_n, t_span, -t_nr, t_cr), (r_c, r_n, r_span, -r_nr, r_cr)

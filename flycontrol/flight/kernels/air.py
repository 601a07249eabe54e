"""Blade elements of one wing in its own axes (span, chord, normal), attack angles from velocity ratios.

Coefficients come as P(z^2) + z Q(z^2) with z = sin(a - 45 deg) = (|u_n| - |u_c|) / (sqrt(2) |u|): no arctangent and no
sine, and whatever is smooth in the attack angle a from 0 to 90 deg converges 5.8-fold per term.
The mathematics stands in `flycontrol.flight.quasi_steady`.
"""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.flight.kernels.vectors import INLINED

#: Rows of the blades: radius [m]; 1/2 rho c dr [kg/m]; 1/2 rho c^2 dr [kg]; C_R rho c^3 dr [kg m].
RADIUS, PRESSURE, PRESSURE_ARM, CIRCULATION_ARM = range(4)
#: Rows of the polynomials in z^2.
LIFT_EVEN, LIFT_ODD, DRAG_EVEN, DRAG_ODD, CENTRE_ODD = range(5)
#: Terms of each polynomial; constant, so that the blades run in lanes.
TERMS = 9
_ROOT_HALF = np.sqrt(0.5)
_STILL = 1e-40  # [m^2/s^2]: keeps a blade at rest from dividing by zero


@numba.njit(**INLINED)
def blade(c, n, polynomials, centre):
    """Pressures along chord and normal over 1/2 rho c dr [m^2/s^2], and their arm ahead of the pitch axis [chords].

    The blade moves with c along its chord and n along its normal.
    """
    ahead, quarter = centre
    speed = np.sqrt(c * c + n * n + _STILL)
    z = _ROOT_HALF * (abs(n) - abs(c)) / speed
    z2 = z * z
    lift_even, lift_odd = polynomials[LIFT_EVEN, TERMS - 1], polynomials[LIFT_ODD, TERMS - 1]
    drag_even, drag_odd = polynomials[DRAG_EVEN, TERMS - 1], polynomials[DRAG_ODD, TERMS - 1]
    travel = polynomials[CENTRE_ODD, TERMS - 1]
    for k in range(TERMS - 2, -1, -1):
        lift_even = lift_even * z2 + polynomials[LIFT_EVEN, k]
        lift_odd = lift_odd * z2 + polynomials[LIFT_ODD, k]
        drag_even = drag_even * z2 + polynomials[DRAG_EVEN, k]
        drag_odd = drag_odd * z2 + polynomials[DRAG_ODD, k]
        travel = travel * z2 + polynomials[CENTRE_ODD, k]
    lift = np.copysign(lift_even + z * lift_odd, c * n)
    drag = drag_even + z * drag_odd
    arm = ahead + np.copysign(quarter - z * travel, c)  # a wing moving backwards: a = 180 deg - a
    return speed * (lift * n - drag * c), -speed * (drag * n + lift * c), arm


@numba.njit(**INLINED)
def rotational_load(u, by_radius, spin, circulation, arms):
    """(F_c, F_n, N_s, N_c, N_n) of C_R rho c^2 w_s (-u_n, u_c); `arms` = sum of C_R rho c^3 dr arm u_c."""
    g_0, g_1, g_2 = circulation[0] * spin, circulation[1] * spin, circulation[2] * spin
    return (
        -(g_0 * u[1] + g_1 * by_radius[1]),
        g_0 * u[0] + g_1 * by_radius[0],
        spin * arms,
        -(g_1 * u[0] + g_2 * by_radius[0]),
        -(g_1 * u[1] + g_2 * by_radius[1]),
    )


@numba.njit(**INLINED)
def blade_loads(u, by_radius, spin, side, blades, polynomials, centre, circulation):
    """Sum translational and rotational forces over the blades.

    A blade at r moves with u + r by_radius, along chord and normal; `spin` is the wing's angular velocity about its
    span, `side` 0 for the left wing's blades, `centre` = (pitch axis less centre of pressure at 90 deg, a quarter of
    its travel) in chords, `circulation` = integrals of C_R rho c^2 r^k dr. Returns two tuples (F_c, F_n, N_s, N_c,
    N_n), forces [N] and torques about the hinge [N m]. The rotational force is linear in u: only its arm needs blades.
    """
    t_c, t_n, t_span, t_cr, t_nr, arms = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(blades.shape[2]):
        r = blades[side, RADIUS, j]
        c = u[0] + r * by_radius[0]
        p_c, p_n, arm = blade(c, u[1] + r * by_radius[1], polynomials, centre)
        t_span += blades[side, PRESSURE_ARM, j] * arm * p_n
        p_c *= blades[side, PRESSURE, j]
        p_n *= blades[side, PRESSURE, j]
        t_c += p_c
        t_n += p_n
        t_cr += r * p_c
        t_nr += r * p_n
        arms += blades[side, CIRCULATION_ARM, j] * arm * c
    return (t_c, t_n, t_span, -t_nr, t_cr), rotational_load(u, by_radius, spin, circulation, arms)

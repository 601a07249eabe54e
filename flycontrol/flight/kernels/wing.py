"""One wing as a rigid body on a moving hinge, in its own axes (span s, chord c, normal n), as a right wing.

The left wing is the right wing of the mirrored fly. What the wing asks of its hinge is

    f = m (a_h + w' x r_c + w x (w x r_c)) - F_air,    n = I w' + w x I w + m r_c x a_h - N_air,

with a_h the hinge's acceleration less gravity, w the wing's angular velocity, r_c its centre of mass and I its inertia
about the hinge. The air that it carries along adds A = sum of m22 g g^T, g = (1, -r, x) on (u_n, w_c, w_s), and I_a.
"""

from __future__ import annotations

import numba

from flycontrol.flight.kernels.air import blade_loads
from flycontrol.flight.kernels.sine import sine_cosine
from flycontrol.flight.kernels.vectors import INLINED, add, combined, cross, dot, minus

#: Constants of one wing: mass [kg], centre of mass along span and chord [m], inertia about the hinge [kg m^2], added
#: mass of normal motion [kg], [kg m], [kg m^2], dissipation [N m s], [N m s^2], centre of pressure and three
#: moments of circulation (see `blade_loads`).
CONSTANTS = 20
(
    MASS, CENTRE_S, CENTRE_C, I_SS, I_CC, I_NN, I_SC,
    A_NN, A_NS, A_NC, A_SS, A_SC, A_CC,
    VISCOUS, VISCOUS_SQUARE, AHEAD, QUARTER, CIRCULATION,
) = range(CONSTANTS - 2)  # fmt: skip


@numba.njit(**INLINED)
def wing_constants(wings, side):
    """Constants of one wing in registers: a view of an array would cost a count of its references."""
    return (
        wings[side, 0], wings[side, 1], wings[side, 2], wings[side, 3], wings[side, 4], wings[side, 5],
        wings[side, 6], wings[side, 7], wings[side, 8], wings[side, 9], wings[side, 10], wings[side, 11],
        wings[side, 12], wings[side, 13], wings[side, 14], wings[side, 15], wings[side, 16], wings[side, 17],
        wings[side, 18], wings[side, 19],
    )  # fmt: skip


@numba.njit(**INLINED)
def wing_frame(stroke, deviation, pitch):
    """Axes span, chord, normal in S, and the rates' axes in the wing's frame: w = J (phi', theta', eta').

    Columns of J: phi (sin theta, sin eta cos theta, cos eta cos theta), theta (0, -cos eta, sin eta), eta (1, 0, 0).
    """
    sin_phi, cos_phi = sine_cosine(stroke)
    sin_theta, cos_theta = sine_cosine(deviation)
    sin_eta, cos_eta = sine_cosine(pitch)
    up_x, up_y, up_z = -sin_phi * sin_theta, -cos_phi * sin_theta, -cos_theta
    span = (sin_phi * cos_theta, cos_phi * cos_theta, -sin_theta)
    chord = (cos_eta * cos_phi + sin_eta * up_x, -cos_eta * sin_phi + sin_eta * up_y, sin_eta * up_z)
    normal = (cos_eta * up_x - sin_eta * cos_phi, cos_eta * up_y + sin_eta * sin_phi, cos_eta * up_z)
    by_stroke = (sin_theta, sin_eta * cos_theta, cos_eta * cos_theta)
    by_deviation = (0.0, -cos_eta, sin_eta)
    return (span, chord, normal), by_stroke, by_deviation


@numba.njit(**INLINED)
def in_wing(frame, a):
    """Components along span, chord, normal."""
    return (dot(frame[0], a), dot(frame[1], a), dot(frame[2], a))


@numba.njit(**INLINED)
def out_of_wing(frame, a):
    """Components in S."""
    return combined(a, frame[0], frame[1], frame[2])


@numba.njit(**INLINED)
def relative_rate(by_stroke, by_deviation, rates):
    """J q', in the wing's frame."""
    return (
        by_stroke[0] * rates[0] + rates[2],
        by_stroke[1] * rates[0] + by_deviation[1] * rates[1],
        by_stroke[2] * rates[0] + by_deviation[2] * rates[1],
    )


@numba.njit(**INLINED)
def joint_bias(by_stroke, by_deviation, rates):
    """J' q', components' rates of change in the wing's frame."""
    phi, theta, eta = rates
    sin_theta = by_stroke[0]
    sin_eta, cos_eta = by_deviation[2], -by_deviation[1]
    # cos theta without another root: by_stroke is a unit vector
    cos_theta = sin_eta * by_stroke[1] + cos_eta * by_stroke[2]
    return (
        phi * theta * cos_theta,
        phi * (by_stroke[2] * eta - sin_eta * sin_theta * theta) + theta * sin_eta * eta,
        phi * (-by_stroke[1] * eta - cos_eta * sin_theta * theta) + theta * cos_eta * eta,
    )


@numba.njit(**INLINED)
def carried_air(constants, u_n, w):
    """Impulse P_n and angular impulses L_s, L_c of the air that moves with the wing."""
    s, c = w[0], w[1]
    return (
        constants[A_NN] * u_n + constants[A_NS] * s + constants[A_NC] * c,
        constants[A_NS] * u_n + constants[A_SS] * s + constants[A_SC] * c,
        constants[A_NC] * u_n + constants[A_SC] * s + constants[A_CC] * c,
    )


@numba.njit(**INLINED)
def dissipation(constants, spin):
    """-(mu_1 f + mu_2 |w_s|) w_s pi rho / 16 integral of c^4 dr."""
    return -(constants[VISCOUS] + constants[VISCOUS_SQUARE] * abs(spin)) * spin


@numba.njit(**INLINED)
def rigid(constants, a, dw, w):
    """f and n of the wing's own mass: hinge acceleration less gravity a, angular acceleration dw, rate w."""
    m, s, c = constants[MASS], constants[CENTRE_S], constants[CENTRE_C]
    i_ss, i_cc, i_nn, i_sc = constants[I_SS], constants[I_CC], constants[I_NN], constants[I_SC]
    along = w[0] * s + w[1] * c
    square = dot(w, w)
    f = (
        m * (a[0] - dw[2] * c + w[0] * along - square * s),
        m * (a[1] + dw[2] * s + w[1] * along - square * c),
        m * (a[2] + dw[0] * c - dw[1] * s + w[2] * along),
    )
    momentum = (i_ss * w[0] + i_sc * w[1], i_sc * w[0] + i_cc * w[1], i_nn * w[2])
    gyro = cross(w, momentum)
    n = (
        i_ss * dw[0] + i_sc * dw[1] + gyro[0] + m * c * a[2],
        i_sc * dw[0] + i_cc * dw[1] + gyro[1] - m * s * a[2],
        i_nn * dw[2] + gyro[2] + m * (s * a[1] - c * a[0]),
    )
    return f, n


@numba.njit(**INLINED)
def added_mass(constants, u_n, w, du_n, dw):
    """Force and torque of the carried air on the wing; du_n is the rate of change of the component u_n.

    Steady translation makes no torque here (the Munk moment): the measured centre of pressure already holds it.
    """
    P, _, L_c = carried_air(constants, u_n, w)
    dP, dL_s, dL_c = carried_air(constants, du_n, dw)
    return (0.0, w[0] * P, -dP), (-dL_s, -dL_c, -w[0] * L_c)


@numba.njit(**INLINED)
def quasi_steady(u, w, constants, side, blades, polynomials):
    """`blade_loads` of a wing whose hinge moves with u and which turns with w."""
    centre = (constants[AHEAD], constants[QUARTER])
    circulation = (constants[CIRCULATION], constants[CIRCULATION + 1], constants[CIRCULATION + 2])
    return blade_loads((u[1], u[2]), (w[2], -w[1]), w[0], side, blades, polynomials, centre, circulation)


@numba.njit(**INLINED)
def wing_motion(frame, by_stroke, by_deviation, rates, accelerations, body):
    """u, w, and with a body that does not accelerate w', the rate of u_n, and the hinge's acceleration less gravity.

    `body` holds v_h, w and the gravity g in S; the results are components along span, chord, normal.
    """
    velocity, rotation, gravity = body
    u = in_wing(frame, velocity)
    o = in_wing(frame, rotation)
    relative = relative_rate(by_stroke, by_deviation, rates)
    w = add(o, relative)
    dw = minus(
        add(joint_bias(by_stroke, by_deviation, rates), relative_rate(by_stroke, by_deviation, accelerations)),
        cross(relative, o),
    )
    du_n = u[0] * relative[1] - u[1] * relative[0]  # of u x relative: the components turn with the wing
    return u, w, dw, du_n, minus(cross(o, u), in_wing(frame, gravity))


@numba.njit(**INLINED)
def inertial_bias(constants, u, w, dw, du_n, a):
    """f and n of the wing's mass, the air that it carries along and its dissipative torque."""
    f, n = rigid(constants, a, dw, w)
    F, N = added_mass(constants, u[2], w, du_n, dw)
    return (f[0], f[1] - F[1], f[2] - F[2]), (n[0] - N[0] - dissipation(constants, w[0]), n[1] - N[1], n[2] - N[2])


@numba.njit(**INLINED)
def wing_bias(frame, by_stroke, by_deviation, rates, accelerations, body, constants, side, blades, polynomials):
    """f and n at the hinge, in the wing's frame, when the body does not accelerate and q'' is `accelerations`."""
    u, w, dw, du_n, a = wing_motion(frame, by_stroke, by_deviation, rates, accelerations, body)
    f, n = inertial_bias(constants, u, w, dw, du_n, a)
    steady, rotating = quasi_steady(u, w, constants, side, blades, polynomials)
    f = (f[0], f[1] - steady[0] - rotating[0], f[2] - steady[1] - rotating[1])
    return f, minus(n, (steady[2] + rotating[2], steady[3] + rotating[3], steady[4] + rotating[4]))

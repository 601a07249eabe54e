"""Newton and Euler for a body and two wings: twelve accelerations from forces, or forces from accelerations.

    [M_aa   M_aw   M_aq ] [v']   [f]   [F]
    [M_aw^T M_ww   M_wq ] [w'] + [n] = [N]       v', w': rates of change of the components in S
    [M_aq^T M_wq^T M_qq ] [q'']  [t]   [tau]

Each wing's q'' is eliminated (3 x 3), then v' (3 x 3), then w' is left (3 x 3): mass matrix, bias and solution in one
pass, without an array. With d = m (s_c c - c_c s), e = B_s s + B_c c, l = h x n and a wing's inertia K about its hinge,

    M_aw = d n^T + n (e + A l)^T - m [h]x,
    M_ww = K + n (h x d)^T + (h x d) n^T + e l^T + l e^T + A l l^T + m (h^2 1 - h h^T).
"""

from __future__ import annotations

import numba

from flycontrol.flight.kernels.vectors import (
    INLINED,
    add,
    axial_mirrored,
    combined,
    cross,
    dot,
    less,
    matrix_times,
    minus,
    outer_pair,
    outer_square,
    polar_mirrored,
    scaled,
    sum_of,
    symmetric_inverse,
    symmetric_times,
    transpose_times,
)
from flycontrol.flight.kernels.wing import (
    A_CC,
    A_NC,
    A_NN,
    A_NS,
    A_SC,
    A_SS,
    CENTRE_C,
    CENTRE_S,
    I_CC,
    I_NN,
    I_SC,
    I_SS,
    MASS,
    out_of_wing,
    wing_bias,
    wing_constants,
    wing_frame,
)

#: Constants of the body without wings: mass [kg], inertia xx, xy, xz, yy, yz, zz [kg m^2], right hinge [m].
BODY_CONSTANTS = 10
NOTHING = (0.0, 0.0, 0.0)


@numba.njit(**INLINED)
def _torque_of(J, K):
    """K J, K = (ss, sc, cc, nn)."""
    return (K[0] * J[0] + K[1] * J[1], K[1] * J[0] + K[2] * J[1], K[3] * J[2])


@numba.njit(**INLINED)
def wing_matrices(frame, h, constants):
    """What the wing and its air add to M_aa, M_aw, M_ww; and B_sn, B_cn, B_ns, B_nc, K for its joint."""
    span, chord, normal = frame
    m, s, c = constants[MASS], constants[CENTRE_S], constants[CENTRE_C]
    B = (-m * c, m * s, m * c + constants[A_NS], -m * s + constants[A_NC])
    K = (
        constants[I_SS] + constants[A_SS],
        constants[I_SC] + constants[A_SC],
        constants[I_CC] + constants[A_CC],
        constants[I_NN],
    )
    A = constants[A_NN]
    d = add(scaled(B[0], span), scaled(B[1], chord))
    e = add(scaled(B[2], span), scaled(B[3], chord))
    lever = cross(h, normal)
    hd = cross(h, d)
    to = add(e, scaled(A, lever))
    mh = scaled(m, h)
    M_aa = outer_square(A, normal)
    M_aa = (M_aa[0] + m, M_aa[1], M_aa[2], M_aa[3] + m, M_aa[4], M_aa[5] + m)
    n0, n1, n2 = normal
    M_aw = (
        (d[0] * n0 + n0 * to[0], d[0] * n1 + n0 * to[1] + mh[2], d[0] * n2 + n0 * to[2] - mh[1]),
        (d[1] * n0 + n1 * to[0] - mh[2], d[1] * n1 + n1 * to[1], d[1] * n2 + n1 * to[2] + mh[0]),
        (d[2] * n0 + n2 * to[0] + mh[1], d[2] * n1 + n2 * to[1] - mh[0], d[2] * n2 + n2 * to[2]),
    )
    M_ww = sum_of(outer_square(K[0], span), outer_square(K[2], chord))
    M_ww = sum_of(sum_of(M_ww, outer_pair(scaled(K[1], span), chord)), outer_square(K[3], normal))
    M_ww = sum_of(sum_of(M_ww, outer_pair(normal, hd)), outer_pair(e, lever))
    M_ww = sum_of(M_ww, less(outer_square(A, lever), outer_square(m, h)))
    far = m * dot(h, h)
    M_ww = (M_ww[0] + far, M_ww[1], M_ww[2], M_ww[3] + far, M_ww[4], M_ww[5] + far)
    return M_aa, M_aw, M_ww, B, K


@numba.njit(**INLINED)
def _joint_column(J, frame, h, B, K):
    """Columns of M_aq and M_wq, and K J."""
    along = out_of_wing(frame, (B[0] * J[2], B[1] * J[2], B[2] * J[0] + B[3] * J[1]))
    torque = _torque_of(J, K)
    return along, add(out_of_wing(frame, torque), cross(h, along)), torque


@numba.njit(**INLINED)
def wing_joints(by_stroke, by_deviation, frame, h, B, K):
    """Columns of M_aq, of M_wq, and K J, joint by joint."""
    a0, t0, k0 = _joint_column(by_stroke, frame, h, B, K)
    a1, t1, k1 = _joint_column(by_deviation, frame, h, B, K)
    a2, t2, k2 = _joint_column((1.0, 0.0, 0.0), frame, h, B, K)
    return (a0, a1, a2), (t0, t1, t2), (k0, k1, k2)


@numba.njit(**INLINED)
def _less_rows(M, a, b):
    """M - a b^T."""
    return (minus(M[0], scaled(a[0], b)), minus(M[1], scaled(a[1], b)), minus(M[2], scaled(a[2], b)))


@numba.njit(**INLINED)
def _half_pair(a, b):
    """a b^T, of which the sum over joints is symmetric."""
    return (a[0] * b[0], a[0] * b[1], a[0] * b[2], a[1] * b[1], a[1] * b[2], a[2] * b[2])


@numba.njit(**INLINED)
def wing_share(angles, rates, accelerations, torque, freed, body, h, side, wings, blades, polynomials):
    """Share of one wing, as a right wing, in the body's equations, its free joints eliminated.

    `accelerations` are those of prescribed joints, 0 of free ones; `freed` is 1 for a free joint, else 0. Returns
    M_aa, M_aw, M_ww, f, n about the centre of mass, and x_k, y_k, z_k, q_k of q''_k = q_k - x_k . v' - y_k . w'.
    """
    constants = wing_constants(wings, side)
    frame, by_stroke, by_deviation = wing_frame(angles[0], angles[1], angles[2])
    f, n = wing_bias(frame, by_stroke, by_deviation, rates, accelerations, body, constants, side, blades, polynomials)
    M_aa, M_aw, M_ww, B, K = wing_matrices(frame, h, constants)
    f_S = out_of_wing(frame, f)
    n_S = add(out_of_wing(frame, n), cross(h, f_S))
    x = (NOTHING, NOTHING, NOTHING)
    y = (NOTHING, NOTHING, NOTHING)
    q = NOTHING
    if freed[0] + freed[1] + freed[2] > 0.0:
        (a0, a1, a2), (t0, t1, t2), (k0, k1, k2) = wing_joints(by_stroke, by_deviation, frame, h, B, K)
        p0, p1, p2 = freed
        # a prescribed joint keeps a row of its own: K_ss q'' = 0
        unit = K[0]
        G = symmetric_inverse((
            p0 * dot(by_stroke, k0) + (1.0 - p0) * unit,
            p0 * p1 * dot(by_stroke, k1),
            p0 * p2 * dot(by_stroke, k2),
            p1 * dot(by_deviation, k1) + (1.0 - p1) * unit,
            p1 * p2 * dot(by_deviation, k2),
            p2 * k2[0] + (1.0 - p2) * unit,
        ))  # fmt: skip
        a0, t0 = scaled(p0, a0), scaled(p0, t0)
        a1, t1 = scaled(p1, a1), scaled(p1, t1)
        a2, t2 = scaled(p2, a2), scaled(p2, t2)
        q = symmetric_times(
            G,
            (p0 * (torque[0] - dot(by_stroke, n)), p1 * (torque[1] - dot(by_deviation, n)), p2 * (torque[2] - n[0])),
        )
        g0, g1, g2 = (G[0], G[1], G[2]), (G[1], G[3], G[4]), (G[2], G[4], G[5])
        x = (combined(g0, a0, a1, a2), combined(g1, a0, a1, a2), combined(g2, a0, a1, a2))
        y = (combined(g0, t0, t1, t2), combined(g1, t0, t1, t2), combined(g2, t0, t1, t2))
        M_aa = less(less(less(M_aa, _half_pair(a0, x[0])), _half_pair(a1, x[1])), _half_pair(a2, x[2]))
        M_aw = _less_rows(_less_rows(_less_rows(M_aw, a0, y[0]), a1, y[1]), a2, y[2])
        M_ww = less(less(less(M_ww, _half_pair(t0, y[0])), _half_pair(t1, y[1])), _half_pair(t2, y[2]))
        f_S = add(f_S, combined(q, a0, a1, a2))
        n_S = add(n_S, combined(q, t0, t1, t2))
    return M_aa, M_aw, M_ww, f_S, n_S, x, y, q


@numba.njit(**INLINED)
def with_mirrored(A, B, side):
    """A + B seen in the mirror of `side`, both force to force or torque to torque."""
    return (A[0] + B[0], A[1] + side * B[1], A[2] + B[2], A[3] + B[3], A[4] + side * B[4], A[5] + B[5])


@numba.njit(**INLINED)
def with_mirrored_mixed(A, B, side):
    """A + B seen in the mirror of `side`, from angular acceleration to force."""
    return (
        (A[0][0] + side * B[0][0], A[0][1] + B[0][1], A[0][2] + side * B[0][2]),
        (A[1][0] + B[1][0], A[1][1] + side * B[1][1], A[1][2] + B[1][2]),
        (A[2][0] + side * B[2][0], A[2][1] + B[2][1], A[2][2] + side * B[2][2]),
    )


@numba.njit(**INLINED)
def _held(M, free, unit):
    """Equations of held freedoms replaced by unit * acceleration = 0."""
    a, b, c = free
    return (
        a * M[0] + (1.0 - a) * unit,
        a * b * M[1],
        a * c * M[2],
        b * M[3] + (1.0 - b) * unit,
        b * c * M[4],
        c * M[5] + (1.0 - c) * unit,
    )


@numba.njit(**INLINED)
def solved(M_aa, M_aw, M_ww, force, torque, free_v, free_w):
    """v' and w' of the body from its own equations, held freedoms kept."""
    a, b, c = free_v
    x, y, z = free_w
    M_aa, M_ww = _held(M_aa, free_v, M_aa[0]), _held(M_ww, free_w, M_ww[0])
    M_aw = (
        (a * x * M_aw[0][0], a * y * M_aw[0][1], a * z * M_aw[0][2]),
        (b * x * M_aw[1][0], b * y * M_aw[1][1], b * z * M_aw[1][2]),
        (c * x * M_aw[2][0], c * y * M_aw[2][1], c * z * M_aw[2][2]),
    )
    force = (a * force[0], b * force[1], c * force[2])
    torque = (x * torque[0], y * torque[1], z * torque[2])
    E = symmetric_inverse(M_aa)
    # columns of E M_aw, as rows
    c0 = symmetric_times(E, (M_aw[0][0], M_aw[1][0], M_aw[2][0]))
    c1 = symmetric_times(E, (M_aw[0][1], M_aw[1][1], M_aw[2][1]))
    c2 = symmetric_times(E, (M_aw[0][2], M_aw[1][2], M_aw[2][2]))
    m0, m1, m2 = transpose_times(M_aw, c0), transpose_times(M_aw, c1), transpose_times(M_aw, c2)
    schur = less(M_ww, (m0[0], m0[1], m0[2], m1[1], m1[2], m2[2]))
    dw = symmetric_times(symmetric_inverse(schur), minus(torque, matrix_times((c0, c1, c2), force)))
    dv = minus(symmetric_times(E, force), combined(dw, c0, c1, c2))
    return dv, dw


@numba.njit(**INLINED)
def accelerations(v, w, gravity, left, right, force, torque, free_v, free_w, body, wings, blades, polynomials):
    """v', w', q''_left, q''_right.

    `left` and `right` are (angles, rates, prescribed accelerations, torques, freed), `force` and `torque` what acts on
    the body from outside, all in S; `free_v` and `free_w` are 1 for a free body freedom, 0 for a held one.
    """
    m = body[0]
    inertia = (body[1], body[2], body[3], body[4], body[5], body[6])
    h = (body[7], body[8], body[9])
    M_aa = (m, 0.0, 0.0, m, 0.0, m)
    M_aw = (NOTHING, NOTHING, NOTHING)
    M_ww = inertia
    f = minus(force, scaled(m, minus(cross(w, v), gravity)))
    n = minus(torque, cross(w, symmetric_times(inertia, w)))
    x_left, y_left, q_left, x_right, y_right, q_right = M_aw, M_aw, NOTHING, M_aw, M_aw, NOTHING
    for k in range(2):  # a loop, not two copies: straight-line code must fit the first cache
        side = 2.0 * k - 1.0
        wing = left if k == 0 else right
        v_m, w_m = polar_mirrored(v, side), axial_mirrored(w, side)
        moving = (add(v_m, cross(w_m, h)), w_m, polar_mirrored(gravity, side))
        share = wing_share(
            wing[0], wing[1], wing[2], wing[3], wing[4], moving, h, k, wings, blades, polynomials
        )  # fmt: skip
        M_aa = with_mirrored(M_aa, share[0], side)
        M_aw = with_mirrored_mixed(M_aw, share[1], side)
        M_ww = with_mirrored(M_ww, share[2], side)
        f = minus(f, polar_mirrored(share[3], side))
        n = minus(n, axial_mirrored(share[4], side))
        if k == 0:
            x_left, y_left, q_left = share[5], share[6], share[7]
        else:
            x_right, y_right, q_right = share[5], share[6], share[7]
    dv, dw = solved(M_aa, M_aw, M_ww, f, n, free_v, free_w)
    q_right = minus(q_right, add(matrix_times(x_right, dv), matrix_times(y_right, dw)))
    dv_m, dw_m = polar_mirrored(dv, -1.0), axial_mirrored(dw, -1.0)
    q_left = minus(q_left, add(matrix_times(x_left, dv_m), matrix_times(y_left, dw_m)))
    return dv, dw, add(q_left, left[2]), add(q_right, right[2])

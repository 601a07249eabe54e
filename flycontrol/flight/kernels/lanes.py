"""Sixteen flies side by side, wings prescribed: every operation on all lanes at once.

The mathematics is that of `kernels.march`, piece by piece; between the pieces, what one leaves for the next lies in one
scratch array whose rows are lanes. Offsets into it are constants, so that the compiler sees that rows do not overlap.
"""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.flight.kernels.air import CIRCULATION_ARM, PRESSURE, PRESSURE_ARM, RADIUS, blade, rotational_load
from flycontrol.flight.kernels.dynamics import solved, wing_matrices, with_mirrored, with_mirrored_mixed
from flycontrol.flight.kernels.march import QUATERNION, SPIN, VELOCITY, in_body, turning, world
from flycontrol.flight.kernels.vectors import (
    COMPILED,
    INLINED,
    add,
    axial_mirrored,
    cross,
    minus,
    polar_mirrored,
    scaled,
    symmetric_times,
)
from flycontrol.flight.kernels.wing import (
    AHEAD,
    CIRCULATION,
    CONSTANTS,
    QUARTER,
    inertial_bias,
    out_of_wing,
    wing_frame,
    wing_motion,
)

#: From sixteen on the compiler checks at run time that arrays do not overlap, and goes on in lanes.
LANES = 16
#: Rows of a state in lanes: position in W, quaternion S to W, velocity and angular velocity in S; and of its rates.
BODY_STATES = 13
#: Rows of the drive of one wing: angles, rates, accelerations.
LANE_DRIVE = 9

# rows of the scratch
_AT, _RATE, _END, _GRAVITY = 0, 13, 26, 39
_FRAME, _U, _W, _DW, _DU, _A, _SUMS = 42, 51, 54, 57, 60, 61, 64
_M_AA, _M_AW, _M_WW, _F, _N = 70, 76, 85, 91, 94
SCRATCH = 97


@numba.njit(**INLINED)
def _get(rows, k, lane):
    return (rows[k * LANES + lane], rows[(k + 1) * LANES + lane], rows[(k + 2) * LANES + lane])


@numba.njit(**INLINED)
def _put(rows, k, lane, a):
    rows[k * LANES + lane], rows[(k + 1) * LANES + lane], rows[(k + 2) * LANES + lane] = a


@numba.njit(**INLINED)
def _get_six(rows, k, lane):
    a, b = _get(rows, k, lane), _get(rows, k + 3, lane)
    return (a[0], a[1], a[2], b[0], b[1], b[2])


@numba.njit(**INLINED)
def _put_six(rows, k, lane, a):
    _put(rows, k, lane, (a[0], a[1], a[2]))
    _put(rows, k + 3, lane, (a[3], a[4], a[5]))


@numba.njit(**INLINED)
def _get_nine(rows, k, lane):
    return (_get(rows, k, lane), _get(rows, k + 3, lane), _get(rows, k + 6, lane))


@numba.njit(**INLINED)
def _put_nine(rows, k, lane, a):
    _put(rows, k, lane, a[0])
    _put(rows, k + 3, lane, a[1])
    _put(rows, k + 6, lane, a[2])


@numba.njit(**INLINED)
def _quaternion(rows, k, lane):
    a = _get(rows, k, lane)
    return (a[0], a[1], a[2], rows[(k + 3) * LANES + lane])


@numba.njit(**INLINED)
def _constants(rows, k, lane):
    """The constants of one wing."""
    a, b, c = _get_six(rows, k, lane), _get_six(rows, k + 6, lane), _get_six(rows, k + 12, lane)
    return a + b + c + (rows[(k + 18) * LANES + lane], rows[(k + 19) * LANES + lane])


@numba.njit(**INLINED)
def _begin(s, body, outside, gravity):
    """The body's own share of its equations."""
    for lane in range(LANES):
        v, w = _get(s, _AT + VELOCITY, lane), _get(s, _AT + SPIN, lane)
        g = in_body(_quaternion(s, _AT + QUATERNION, lane), gravity)
        m, inertia = body[lane], _get_six(body, 1, lane)
        _put(s, _GRAVITY, lane, g)
        _put_six(s, _M_AA, lane, (m, 0.0, 0.0, m, 0.0, m))
        _put_nine(s, _M_AW, lane, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
        _put_six(s, _M_WW, lane, inertia)
        _put(s, _F, lane, minus(_get(outside, 0, lane), scaled(m, minus(cross(w, v), g))))
        _put(s, _N, lane, minus(_get(outside, 3, lane), cross(w, symmetric_times(inertia, w))))


@numba.njit(**INLINED)
def _move_wing(s, drive, first, body, side):
    """Axes, velocity and accelerations of one wing; `first` is its first row in the drive."""
    for lane in range(LANES):
        angles = _get(drive, first, lane)
        frame, by_stroke, by_deviation = wing_frame(angles[0], angles[1], angles[2])
        h = _get(body, 7, lane)
        v = polar_mirrored(_get(s, _AT + VELOCITY, lane), side)
        w = axial_mirrored(_get(s, _AT + SPIN, lane), side)
        moving = (add(v, cross(w, h)), w, polar_mirrored(_get(s, _GRAVITY, lane), side))
        u, w, dw, du_n, a = wing_motion(
            frame, by_stroke, by_deviation, _get(drive, first + 3, lane), _get(drive, first + 6, lane), moving
        )
        _put_nine(s, _FRAME, lane, frame)
        _put(s, _U, lane, u)
        _put(s, _W, lane, w)
        _put(s, _DW, lane, dw)
        s[_DU * LANES + lane] = du_n
        _put(s, _A, lane, a)
        _put_six(s, _SUMS, lane, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))


@numba.njit(**INLINED)
def _add_blade(s, blades, first, wings, own, polynomials):
    """Sums over the blades, one blade further; `first` is its first row, `own` that of its wing's constants."""
    for lane in range(LANES):
        r = blades[(first + RADIUS) * LANES + lane]
        u, w = _get(s, _U, lane), _get(s, _W, lane)
        c = u[1] + r * w[2]
        centre = (wings[(own + AHEAD) * LANES + lane], wings[(own + QUARTER) * LANES + lane])
        p_c, p_n, arm = blade(c, u[2] - r * w[1], polynomials, centre)
        pressure = blades[(first + PRESSURE) * LANES + lane]
        t_c, t_n, t_span, t_cr, t_nr, arms = _get_six(s, _SUMS, lane)
        t_span += blades[(first + PRESSURE_ARM) * LANES + lane] * arm * p_n
        arms += blades[(first + CIRCULATION_ARM) * LANES + lane] * arm * c
        p_c *= pressure
        p_n *= pressure
        _put_six(s, _SUMS, lane, (t_c + p_c, t_n + p_n, t_span, t_cr + r * p_c, t_nr + r * p_n, arms))


@numba.njit(**INLINED)
def _add_wing(s, body, wings, own, side):
    """One wing's share of the body's equations."""
    for lane in range(LANES):
        frame = _get_nine(s, _FRAME, lane)
        u, w, dw, h = _get(s, _U, lane), _get(s, _W, lane), _get(s, _DW, lane), _get(body, 7, lane)
        constants = _constants(wings, own, lane)
        f, n = inertial_bias(constants, u, w, dw, s[_DU * LANES + lane], _get(s, _A, lane))
        t_c, t_n, t_span, t_cr, t_nr, arms = _get_six(s, _SUMS, lane)
        circulation = (constants[CIRCULATION], constants[CIRCULATION + 1], constants[CIRCULATION + 2])
        r = rotational_load((u[1], u[2]), (w[2], -w[1]), w[0], circulation, arms)
        f_S = out_of_wing(frame, (f[0], f[1] - t_c - r[0], f[2] - t_n - r[1]))
        n_S = out_of_wing(frame, (n[0] - t_span - r[2], n[1] + t_nr - r[3], n[2] - t_cr - r[4]))
        n_S = add(n_S, cross(h, f_S))
        M_aa, M_aw, M_ww, _, _ = wing_matrices(frame, h, constants)
        _put_six(s, _M_AA, lane, with_mirrored(_get_six(s, _M_AA, lane), M_aa, side))
        _put_nine(s, _M_AW, lane, with_mirrored_mixed(_get_nine(s, _M_AW, lane), M_aw, side))
        _put_six(s, _M_WW, lane, with_mirrored(_get_six(s, _M_WW, lane), M_ww, side))
        _put(s, _F, lane, minus(_get(s, _F, lane), polar_mirrored(f_S, side)))
        _put(s, _N, lane, minus(_get(s, _N, lane), axial_mirrored(n_S, side)))


@numba.njit(**INLINED)
def _finish(s, free):
    """Rates of change of the state."""
    free_v, free_w = (free[0], free[1], free[2]), (free[3], free[4], free[5])
    for lane in range(LANES):
        dv, dw = solved(
            _get_six(s, _M_AA, lane), _get_nine(s, _M_AW, lane), _get_six(s, _M_WW, lane),
            _get(s, _F, lane), _get(s, _N, lane), free_v, free_w,
        )  # fmt: skip
        q, v, w = _quaternion(s, _AT + QUATERNION, lane), _get(s, _AT + VELOCITY, lane), _get(s, _AT + SPIN, lane)
        dq = turning(q, w)
        _put(s, _RATE, lane, world(q, v))
        _put(s, _RATE + QUATERNION, lane, (dq[0], dq[1], dq[2]))
        s[(_RATE + QUATERNION + 3) * LANES + lane] = dq[3]
        _put(s, _RATE + VELOCITY, lane, dv)
        _put(s, _RATE + SPIN, lane, dw)


@numba.njit(**INLINED)
def _advance(s, y, step, last, stage):
    """End and next stage of a Runge-Kutta step; the state after the last stage has a unit quaternion."""
    share = 1.0 / 3.0 if 0 < stage < 3 else 1.0 / 6.0
    part = 1.0 if stage == 2 else 0.5
    for k in range(BODY_STATES):
        for lane in range(LANES):
            rate = step[lane] * s[(_RATE + k) * LANES + lane]
            s[(_END + k) * LANES + lane] += share * rate
            s[(_AT + k) * LANES + lane] = y[k * LANES + lane] + part * rate
    if last:
        for lane in range(LANES):
            a, b, c, d = _quaternion(s, _END + QUATERNION, lane)
            shrink = 1.0 / np.sqrt(a * a + b * b + c * c + d * d)
            _put(s, _END + QUATERNION, lane, (shrink * a, shrink * b, shrink * c))
            s[(_END + QUATERNION + 3) * LANES + lane] = shrink * d
        for k in range(BODY_STATES * LANES):
            y[k] = s[_END * LANES + k]
            s[_AT * LANES + k] = y[k]


@numba.njit(**COMPILED)
def march_lanes(y, drive, step, outside, stride, free, gravity, body, wings, blades, polynomials, samples):
    """Advance sixteen flies in place; store every `stride`-th state and its accelerations.

    Parameters
    ----------
    y : (13 * 16,) states, lanes fastest, as everywhere
    drive : (2 n + 1, 18 * 16) left wing, then right wing, at half steps
    step : (16,) [s]
    outside : (n, 6 * 16) force and torque on the bodies during each step, frame S
    stride : steps between samples
    free : (6,) 1 for a free body freedom, the same for all
    gravity : (3,) in W
    body, wings, blades : (10 * 16,), (2 * 20 * 16,), (2 * nodes * 4 * 16,) constants
    polynomials : the coefficients, the same for all
    samples : (n / stride, 19 * 16) to be filled: states, v', w'
    """
    s = np.empty(SCRATCH * LANES)
    g = (gravity[0], gravity[1], gravity[2])
    nodes = blades.shape[0] // (8 * LANES)
    for k in range(BODY_STATES * LANES):
        s[_AT * LANES + k] = y[k]
    for k in range(outside.shape[0]):
        for i in range(BODY_STATES * LANES):
            s[_END * LANES + i] = y[i]
        for stage in range(4):
            row = drive[2 * k + (stage + 1) // 2]
            _begin(s, body, outside[k], g)
            for wing in range(2):
                side = 2.0 * wing - 1.0
                _move_wing(s, row[wing * LANE_DRIVE * LANES :], 0, body, side)
                for j in range(nodes):
                    _add_blade(
                        s, blades[(wing * nodes + j) * 4 * LANES :], 0, wings[wing * CONSTANTS * LANES :], 0,
                        polynomials,
                    )  # fmt: skip
                _add_wing(s, body, wings[wing * CONSTANTS * LANES :], 0, side)
            _finish(s, free)
            if stage == 0 and k % stride == 0:
                sample = samples[k // stride]
                for i in range(BODY_STATES * LANES):
                    sample[i] = y[i]
                for i in range(6 * LANES):
                    sample[BODY_STATES * LANES + i] = s[(_RATE + VELOCITY) * LANES + i]
            _advance(s, y, step, stage == 3, stage)

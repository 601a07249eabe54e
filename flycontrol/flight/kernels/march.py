"""One fly through a segment of time: classical Runge-Kutta steps of fixed length, quaternion kept at unit length."""

from __future__ import annotations

import numba
import numpy as np

from flycontrol.flight.kernels.dynamics import accelerations
from flycontrol.flight.kernels.vectors import COMPILED, INLINED, add, scaled

#: Columns of a state: position in W, quaternion S to W, velocity and angular velocity in S, wing angles and rates.
POSITION, QUATERNION, VELOCITY, SPIN, LEFT, RIGHT, LEFT_RATE, RIGHT_RATE, STATES = 0, 3, 7, 10, 13, 16, 19, 22, 25
#: Columns that follow a stored state: v', w', q''_left, q''_right.
SAMPLE = STATES + 12
#: Columns of a wing's drive at a half step: angles, rates, accelerations, torques, three joints each.
DRIVE = 12
#: Columns of a joint: 1 if free, stiffness, damping, rest angle.
FREED, STIFFNESS, DAMPING, REST = range(4)
#: Beyond these no fly is flying: 100 m/s, 1e5 rad/s.
FASTEST, FASTEST_SPIN = 1e2, 1e5


@numba.njit(**INLINED)
def three(array, k):
    """Three entries from k on."""
    return (array[k], array[k + 1], array[k + 2])


@numba.njit(**INLINED)
def _joint_state(own, drive, row, side, kind, joints):
    """Angles (kind 0) or rates (kind 3): a free joint's own, a prescribed joint's from the table."""
    return (
        own[0] if joints[side, 0, FREED] > 0.0 else drive[row, side, kind],
        own[1] if joints[side, 1, FREED] > 0.0 else drive[row, side, kind + 1],
        own[2] if joints[side, 2, FREED] > 0.0 else drive[row, side, kind + 2],
    )


@numba.njit(**INLINED)
def _torque(k, angle, rate, drive, row, side, joints):
    """What the table, a spring and a damper exert at a joint."""
    spring = joints[side, k, STIFFNESS] * (angle - joints[side, k, REST]) + joints[side, k, DAMPING] * rate
    return drive[row, side, 9 + k] - spring


@numba.njit(**INLINED)
def _wing(angles, rates, drive, row, side, joints):
    """(angles, rates, prescribed accelerations, torques, freed) of one wing."""
    q = _joint_state(angles, drive, row, side, 0, joints)
    r = _joint_state(rates, drive, row, side, 3, joints)
    torque = (
        _torque(0, q[0], r[0], drive, row, side, joints),
        _torque(1, q[1], r[1], drive, row, side, joints),
        _torque(2, q[2], r[2], drive, row, side, joints),
    )
    given = (drive[row, side, 6], drive[row, side, 7], drive[row, side, 8])
    return q, r, given, torque, (joints[side, 0, FREED], joints[side, 1, FREED], joints[side, 2, FREED])


@numba.njit(**INLINED)
def world(q, a):
    """R(q) a = a + 2 q_0 (u x a) + 2 u x (u x a), u the vector part."""
    w, x, y, z = q
    tx, ty, tz = 2.0 * (y * a[2] - z * a[1]), 2.0 * (z * a[0] - x * a[2]), 2.0 * (x * a[1] - y * a[0])
    return (
        a[0] + w * tx + y * tz - z * ty,
        a[1] + w * ty + z * tx - x * tz,
        a[2] + w * tz + x * ty - y * tx,
    )


@numba.njit(**INLINED)
def in_body(q, a):
    """Components in S of a vector given in W."""
    return world((q[0], -q[1], -q[2], -q[3]), a)


@numba.njit(**INLINED)
def turning(q, w):
    """q' = q (0, w) / 2."""
    return (
        0.5 * (-q[1] * w[0] - q[2] * w[1] - q[3] * w[2]),
        0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]),
        0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]),
        0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]),
    )


@numba.njit(**INLINED)
def rates_of_change(state, drive, row, joints, outside, k, free, gravity, body, wings, blades, polynomials):
    """Rate of change of a state (p, q, v, w, left, right, left rates, right rates); its last entries are q''.

    Also the wings' rates as they are, since prescribed ones come from the drive.
    """
    _, q, v, w, left_angles, right_angles, left_rates, right_rates = state
    left = _wing(left_angles, left_rates, drive, row, 0, joints)
    right = _wing(right_angles, right_rates, drive, row, 1, joints)
    down = in_body(q, gravity)
    dv, dw, left_q, right_q = accelerations(
        v, w, down, left, right, (outside[k, 0], outside[k, 1], outside[k, 2]),
        (outside[k, 3], outside[k, 4], outside[k, 5]), three(free, 0), three(free, 3),
        body, wings, blades, polynomials,
    )  # fmt: skip
    return (world(q, v), turning(q, w), dv, dw, left[1], right[1], left_q, right_q)


@numba.njit(**INLINED)
def _moved(state, h, rate):
    """State + h rate."""
    q, dq = state[1], rate[1]
    return (
        add(state[0], scaled(h, rate[0])),
        (q[0] + h * dq[0], q[1] + h * dq[1], q[2] + h * dq[2], q[3] + h * dq[3]),
        add(state[2], scaled(h, rate[2])),
        add(state[3], scaled(h, rate[3])),
        add(state[4], scaled(h, rate[4])),
        add(state[5], scaled(h, rate[5])),
        add(state[6], scaled(h, rate[6])),
        add(state[7], scaled(h, rate[7])),
    )


@numba.njit(**INLINED)
def _unpacked(y):
    return (
        three(y, POSITION), (y[3], y[4], y[5], y[6]), three(y, VELOCITY), three(y, SPIN),
        three(y, LEFT), three(y, RIGHT), three(y, LEFT_RATE), three(y, RIGHT_RATE),
    )  # fmt: skip


@numba.njit(**INLINED)
def pack_three(y, k, a):
    """Store three entries from k on."""
    y[k], y[k + 1], y[k + 2] = a


@numba.njit(**INLINED)
def _pack(y, state, drive, row, joints):
    """Store a state, prescribed joints as driven."""
    pack_three(y, POSITION, state[0])
    y[3], y[4], y[5], y[6] = state[1]
    pack_three(y, VELOCITY, state[2])
    pack_three(y, SPIN, state[3])
    pack_three(y, LEFT, _joint_state(state[4], drive, row, 0, 0, joints))
    pack_three(y, RIGHT, _joint_state(state[5], drive, row, 1, 0, joints))
    pack_three(y, LEFT_RATE, _joint_state(state[6], drive, row, 0, 3, joints))
    pack_three(y, RIGHT_RATE, _joint_state(state[7], drive, row, 1, 3, joints))


@numba.njit(**INLINED)
def _store(sample, state, rate, drive, row, joints):
    _pack(sample, state, drive, row, joints)
    pack_three(sample, STATES, rate[2])
    pack_three(sample, STATES + 3, rate[3])
    pack_three(sample, STATES + 6, rate[6])
    pack_three(sample, STATES + 9, rate[7])


@numba.njit(**INLINED)
def _flying(state):
    """Whether the state is finite and slower than anything that flies."""
    v, w = state[2], state[3]
    speed = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    spin = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    joints = 0.0
    for k in range(3):
        joints += state[6][k] * state[6][k] + state[7][k] * state[7][k]
    # a NaN fails every comparison
    return speed < FASTEST * FASTEST and spin < FASTEST_SPIN * FASTEST_SPIN and joints < 1e4 * FASTEST_SPIN**2


@numba.njit(**COMPILED)
def march(y, drive, h, outside, stride, joints, free, gravity, body, wings, blades, polynomials, samples):
    """Advance the state y (25,) in place; store every `stride`-th state; return the steps done.

    Parameters
    ----------
    y : (25,) state
    drive : (2 n + 1, 2, 12) left and right wing at half steps
    h : step [s]
    outside : (n, 6) force and torque on the body during each step, frame S
    stride : steps between samples
    joints : (2, 3, 4)
    free : (6,) 1 for free body freedoms
    gravity : (3,) in W
    body, wings, blades, polynomials : constants
    samples : (n / stride, 37) to be filled: states and accelerations at the beginning of every `stride`-th step
    """
    state = _unpacked(y)
    g = three(gravity, 0)
    steps = outside.shape[0]
    for k in range(steps):
        at, end = state, state
        for stage in range(4):  # one copy of the dynamics: straight-line code must fit the first cache
            row = 2 * k + (stage + 1) // 2
            rate = rates_of_change(at, drive, row, joints, outside, k, free, g, body, wings, blades, polynomials)
            if stage == 0 and k % stride == 0:
                _store(samples[k // stride], state, rate, drive, row, joints)
                if not _flying(state):
                    _pack(y, state, drive, row, joints)
                    return k
            at = _moved(state, h if stage == 2 else 0.5 * h, rate)
            end = _moved(end, h / 3.0 if 0 < stage < 3 else h / 6.0, rate)
        q = end[1]
        shrink = 1.0 / np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        q = (shrink * q[0], shrink * q[1], shrink * q[2], shrink * q[3])
        state = (end[0], q, end[2], end[3], end[4], end[5], end[6], end[7])
    _pack(y, state, drive, 2 * steps, joints)
    return steps if _flying(state) else steps - 1


@numba.njit(**COMPILED)
def sample_now(y, drive, outside, joints, free, gravity, body, wings, blades, polynomials, sample):
    """Store a state with its accelerations, at the end of what `drive` and `outside` cover."""
    state = _unpacked(y)
    row, k = drive.shape[0] - 1, outside.shape[0] - 1
    g = three(gravity, 0)
    rate = rates_of_change(state, drive, row, joints, outside, k, free, g, body, wings, blades, polynomials)
    _store(sample, state, rate, drive, row, joints)

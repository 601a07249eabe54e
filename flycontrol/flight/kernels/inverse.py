"""Loads of the air and torques at the hinges along a given motion. The mathematics stands in `kernels.dynamics`."""

from __future__ import annotations

import numba

from flycontrol.flight.kernels.dynamics import wing_joints, wing_matrices
from flycontrol.flight.kernels.march import (
    LEFT,
    LEFT_RATE,
    QUATERNION,
    RIGHT,
    RIGHT_RATE,
    SPIN,
    STATES,
    VELOCITY,
    in_body,
    pack_three,
    three,
)
from flycontrol.flight.kernels.vectors import (
    COMPILED,
    INLINED,
    add,
    axial_mirrored,
    cross,
    dot,
    matrix_times,
    minus,
    polar_mirrored,
    scaled,
    symmetric_times,
    transpose_times,
)
from flycontrol.flight.kernels.wing import (
    added_mass,
    dissipation,
    in_wing,
    joint_bias,
    out_of_wing,
    quasi_steady,
    relative_rate,
    wing_bias,
    wing_constants,
    wing_frame,
)

_ANGLES, _RATES, _ACCELERATIONS = (LEFT, RIGHT), (LEFT_RATE, RIGHT_RATE), (STATES + 6, STATES + 9)


@numba.njit(**INLINED)
def _seen(sample, side, h):
    """v, w, v', w' as a right wing's fly sees them."""
    v, w = three(sample, VELOCITY), three(sample, SPIN)
    dv, dw = three(sample, STATES), three(sample, STATES + 3)
    mirror = 2.0 * side - 1.0
    v, w, dv, dw = (
        polar_mirrored(v, mirror), axial_mirrored(w, mirror), polar_mirrored(dv, mirror), axial_mirrored(dw, mirror),
    )  # fmt: skip
    return add(v, cross(w, h)), w, add(dv, cross(dw, h)), dw


@numba.njit(**INLINED)
def _store_load(load, force, torque, frame, h, side):
    """Force and torque about the centre of mass in S, from the wing's frame."""
    f = out_of_wing(frame, force)
    n = add(out_of_wing(frame, torque), cross(h, f))
    pack_three(load, 0, polar_mirrored(f, 2.0 * side - 1.0))
    pack_three(load, 3, axial_mirrored(n, 2.0 * side - 1.0))


@numba.njit(**COMPILED)
def wing_loads(samples, body, wings, blades, polynomials, loads):
    """Fill `loads` (N, 2, 4, 6): left and right, translational, rotational, added mass, dissipative; F and N in S."""
    h = three(body, 7)
    for k in range(samples.shape[0]):
        for side in range(2):
            constants = wing_constants(wings, side)
            velocity, rotation, hinge_acceleration, turning = _seen(samples[k], side, h)
            angles, rates = three(samples[k], _ANGLES[side]), three(samples[k], _RATES[side])
            accelerations = three(samples[k], _ACCELERATIONS[side])
            frame, by_stroke, by_deviation = wing_frame(angles[0], angles[1], angles[2])
            u, o = in_wing(frame, velocity), in_wing(frame, rotation)
            relative = relative_rate(by_stroke, by_deviation, rates)
            w = add(o, relative)
            dw = add(joint_bias(by_stroke, by_deviation, rates), relative_rate(by_stroke, by_deviation, accelerations))
            dw = add(minus(dw, cross(relative, o)), in_wing(frame, turning))
            du = add(cross(u, relative), in_wing(frame, hinge_acceleration))
            t, r = quasi_steady(u, w, constants, side, blades, polynomials)
            force, torque = added_mass(constants, u[2], w, du[2], dw)
            load = loads[k, side]
            _store_load(load[0], (0.0, t[0], t[1]), (t[2], t[3], t[4]), frame, h, side)
            _store_load(load[1], (0.0, r[0], r[1]), (r[2], r[3], r[4]), frame, h, side)
            _store_load(load[2], force, torque, frame, h, side)
            _store_load(load[3], (0.0, 0.0, 0.0), (dissipation(constants, w[0]), 0.0, 0.0), frame, h, side)


@numba.njit(**COMPILED)
def generalised_forces(samples, gravity, body, wings, blades, polynomials, forces):
    """Fill `forces` (N, 12): force and torque on the body in S, torques at the left and at the right hinge."""
    m, inertia, h = body[0], (body[1], body[2], body[3], body[4], body[5], body[6]), three(body, 7)
    for k in range(samples.shape[0]):
        sample = samples[k]
        q = (sample[QUATERNION], sample[QUATERNION + 1], sample[QUATERNION + 2], sample[QUATERNION + 3])
        g = in_body(q, three(gravity, 0))
        v, w = three(sample, VELOCITY), three(sample, SPIN)
        dv, dw = three(sample, STATES), three(sample, STATES + 3)
        force = scaled(m, add(dv, minus(cross(w, v), g)))
        torque = add(symmetric_times(inertia, dw), cross(w, symmetric_times(inertia, w)))
        for side in range(2):
            velocity, rotation, _, turning = _seen(sample, side, h)
            constants = wing_constants(wings, side)
            mirror = 2.0 * side - 1.0
            linear = polar_mirrored(dv, mirror)
            frame, by_stroke, by_deviation = wing_frame(
                sample[_ANGLES[side]], sample[_ANGLES[side] + 1], sample[_ANGLES[side] + 2]
            )
            f, n = wing_bias(
                frame, by_stroke, by_deviation, three(sample, _RATES[side]), three(sample, _ACCELERATIONS[side]),
                (velocity, rotation, polar_mirrored(g, mirror)), constants, side, blades, polynomials,
            )  # fmt: skip
            M_aa, M_aw, M_ww, B, K = wing_matrices(frame, h, constants)
            a, t, _ = wing_joints(by_stroke, by_deviation, frame, h, B, K)
            for joint in range(3):
                along = (by_stroke, by_deviation, (1.0, 0.0, 0.0))[joint]
                forces[k, 6 + 3 * side + joint] = dot(along, n) + dot(a[joint], linear) + dot(t[joint], turning)
            f_S = out_of_wing(frame, f)
            n_S = add(out_of_wing(frame, n), cross(h, f_S))
            f_S = add(f_S, add(symmetric_times(M_aa, linear), matrix_times(M_aw, turning)))
            n_S = add(n_S, add(transpose_times(M_aw, linear), symmetric_times(M_ww, turning)))
            force = add(force, polar_mirrored(f_S, mirror))
            torque = add(torque, axial_mirrored(n_S, mirror))
        pack_three(forces[k], 0, force)
        pack_three(forces[k], 3, torque)

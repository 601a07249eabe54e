"""Three-vectors and symmetric 3 x 3 matrices as tuples: straight-line code, no arrays, all in registers.

A symmetric matrix is (xx, xy, xz, yy, yz, zz); a general one is its three rows.
"""

from __future__ import annotations

import numba

#: Sums may be regrouped and contracted; NaN and infinity keep their meaning, since a diverging run is found by them.
COMPILED = {"cache": True, "error_model": "numpy", "fastmath": {"reassoc", "contract", "nsz", "arcp"}}
#: Pieces become part of what calls them: a call would count references to its arrays.
INLINED = {**COMPILED, "forceinline": True}


@numba.njit(**INLINED)
def add(a, b):
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@numba.njit(**INLINED)
def minus(a, b):
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@numba.njit(**INLINED)
def scaled(k, a):
    """k a."""
    return (k * a[0], k * a[1], k * a[2])


@numba.njit(**INLINED)
def dot(a, b):
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@numba.njit(**INLINED)
def cross(a, b):
    """a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@numba.njit(**INLINED)
def combined(coefficients, a, b, c):
    """x a + y b + z c for coefficients (x, y, z)."""
    x, y, z = coefficients
    return (
        x * a[0] + y * b[0] + z * c[0],
        x * a[1] + y * b[1] + z * c[1],
        x * a[2] + y * b[2] + z * c[2],
    )


@numba.njit(**INLINED)
def polar_mirrored(a, side):
    """A velocity, an arm or a force; for side -1 its mirror image in the plane y = 0."""
    return (a[0], side * a[1], a[2])


@numba.njit(**INLINED)
def axial_mirrored(a, side):
    """An angular velocity or a torque; for side -1 its mirror image in the plane y = 0."""
    return (side * a[0], a[1], side * a[2])


@numba.njit(**INLINED)
def symmetric_times(M, a):
    """M a, M symmetric."""
    xx, xy, xz, yy, yz, zz = M
    return (
        xx * a[0] + xy * a[1] + xz * a[2],
        xy * a[0] + yy * a[1] + yz * a[2],
        xz * a[0] + yz * a[1] + zz * a[2],
    )


@numba.njit(**INLINED)
def matrix_times(M, a):
    """M a."""
    return (dot(M[0], a), dot(M[1], a), dot(M[2], a))


@numba.njit(**INLINED)
def transpose_times(M, a):
    """M^T a."""
    return combined(a, M[0], M[1], M[2])


@numba.njit(**INLINED)
def symmetric_inverse(M):
    """Inverse by cofactors of a symmetric, positive definite matrix of one unit throughout."""
    xx, xy, xz, yy, yz, zz = M
    a = yy * zz - yz * yz
    b = xz * yz - xy * zz
    c = xy * yz - xz * yy
    k = 1.0 / (xx * a + xy * b + xz * c)
    return (k * a, k * b, k * c, k * (xx * zz - xz * xz), k * (xy * xz - xx * yz), k * (xx * yy - xy * xy))


@numba.njit(**INLINED)
def outer_pair(a, b):
    """a b^T + b a^T, symmetric."""
    return (
        2.0 * a[0] * b[0],
        a[0] * b[1] + a[1] * b[0],
        a[0] * b[2] + a[2] * b[0],
        2.0 * a[1] * b[1],
        a[1] * b[2] + a[2] * b[1],
        2.0 * a[2] * b[2],
    )


@numba.njit(**INLINED)
def outer_square(k, a):
    """k a a^T."""
    x, y, z = k * a[0], k * a[1], k * a[2]
    return (x * a[0], x * a[1], x * a[2], y * a[1], y * a[2], z * a[2])


@numba.njit(**INLINED)
def sum_of(A, B):
    """Sum of two symmetric matrices."""
    return (A[0] + B[0], A[1] + B[1], A[2] + B[2], A[3] + B[3], A[4] + B[4], A[5] + B[5])


@numba.njit(**INLINED)
def less(A, B):
    """Difference of two symmetric matrices."""
    return (A[0] - B[0], A[1] - B[1], A[2] - B[2], A[3] - B[3], A[4] - B[4], A[5] - B[5])

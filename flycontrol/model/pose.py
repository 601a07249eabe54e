"""Where a fly's body and wings are: the 18 coordinates of Hull Reconstruction Motion Tracking, and their rotations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from flycontrol.errors import InvalidParameterError
from flycontrol.model.morphology import Morphology, pitch_rotation
from flycontrol.model.recording import WingAngles
from flycontrol.model.stroke import Side, wing_axes
from flycontrol.model.trajectory import Trajectory, rotation_matrices, wing_angles

FloatArray = NDArray[np.float64]

#: Names of the columns of `Pose.coordinates`, lengths in [m] and angles in [rad].
COORDINATES = (
    "x", "y", "z", "yaw", "pitch", "roll",
    "left_stroke", "left_deviation", "left_pitch", "right_stroke", "right_deviation", "right_pitch",
    "left_base_x", "left_base_y", "left_base_z", "right_base_x", "right_base_y", "right_base_z",
)  # fmt: skip

POSITION, ATTITUDE = slice(0, 3), slice(3, 6)
ANGLES: dict[Side, slice] = {"left": slice(6, 9), "right": slice(9, 12)}
BASE: dict[Side, slice] = {"left": slice(12, 15), "right": slice(15, 18)}

#: World with z up from the same world with z down: half a turn about x.
_Z_UP = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pose:
    """R_WB = diag(1, -1, -1) Rz(yaw) Ry(pitch) Rx(roll): N instants of a fly, world z up, body forward-right-down.

    Yaw > 0 turns right from the world's x, pitch > 0 lifts the nose, roll > 0 lowers the right side. The wings' angles
    are those of `flycontrol.model.stroke`, in the stroke-plane frame v_S = Ry(stroke_plane_angle) v_B. The position is
    that of the body's centre; the wings' bases are seen from there, along body axes.
    """

    coordinates: FloatArray  #: (N, 18), columns as in COORDINATES [m, rad]
    stroke_plane_angle: float  #: [rad]

    def __post_init__(self) -> None:
        X = np.array(self.coordinates, dtype=np.float64)
        if X.ndim != 2 or X.shape[1] != len(COORDINATES):
            raise InvalidParameterError(f"Pose.coordinates must have the shape (N, 18), got {X.shape}.")
        if not np.isfinite(self.stroke_plane_angle):
            raise InvalidParameterError(f"Pose.stroke_plane_angle must be finite, got {self.stroke_plane_angle!r} rad.")
        X.setflags(write=False)
        object.__setattr__(self, "coordinates", X)

    def __len__(self) -> int:
        return len(self.coordinates)

    def __getitem__(self, index: int | slice | NDArray[np.int_] | NDArray[np.bool_]) -> Pose:
        rows = slice(index, index + 1 or None) if isinstance(index, int) else index
        return Pose(coordinates=self.coordinates[rows], stroke_plane_angle=self.stroke_plane_angle)

    @property
    def position_W(self) -> FloatArray:
        """(N, 3) the body's centre [m]."""
        return self.coordinates[:, POSITION]

    @property
    def yaw(self) -> FloatArray:
        """(N,) > 0 to the right [rad]."""
        return self.coordinates[:, 3]

    @property
    def pitch(self) -> FloatArray:
        """(N,) > 0 nose up [rad]."""
        return self.coordinates[:, 4]

    @property
    def roll(self) -> FloatArray:
        """(N,) > 0 right side down [rad]."""
        return self.coordinates[:, 5]

    @property
    def body_axes_W(self) -> FloatArray:
        """R_WB, (N, 3, 3): columns are forward, right, down of the body in the world."""
        return np.asarray(_Z_UP @ Rotation.from_euler("ZYX", self.coordinates[:, ATTITUDE]).as_matrix())

    @property
    def q_WB(self) -> FloatArray:
        """(N, 4) body to world, scalar first."""
        return Rotation.from_matrix(self.body_axes_W).as_quat(scalar_first=True)

    def wing(self, side: Side) -> WingAngles:
        """Stroke, deviation and pitch of one wing, (N,) each [rad]."""
        stroke, deviation, pitch = self.coordinates[:, ANGLES[side]].T
        return WingAngles(stroke=stroke, deviation=deviation, pitch=pitch)

    def base_B(self, side: Side) -> FloatArray:
        """(N, 3) base of one wing from the body's centre, body axes [m]."""
        return self.coordinates[:, BASE[side]]

    def base_W(self, side: Side) -> FloatArray:
        """(N, 3) base of one wing in the world [m]."""
        return self.position_W + np.einsum("nij,nj->ni", self.body_axes_W, self.base_B(side))

    def wing_axes_W(self, side: Side) -> FloatArray:
        """(N, 3, 3): columns are span, chord and normal of one wing in the world.

        Span runs from hinge to tip, the chord from the trailing to the leading edge. The left wing is the mirror image
        of the right one: its axes are left-handed, det = -1.
        """
        axes = wing_axes(self.wing(side), side)
        in_S = np.stack([axes.span, axes.chord, axes.normal], axis=-1)
        return np.asarray(self.body_axes_W @ pitch_rotation(self.stroke_plane_angle).T @ in_S)


def attitude_angles(body_axes_W: ArrayLike) -> FloatArray:
    """(N, 3) yaw, pitch, roll [rad] of R_WB (N, 3, 3); at pitch = +-90 deg roll is 0 and yaw takes the turn."""
    R = _Z_UP @ np.asarray(body_axes_W, dtype=np.float64)
    yaw, roll = np.arctan2(R[:, 1, 0], R[:, 0, 0]), np.arctan2(R[:, 2, 1], R[:, 2, 2])
    pitch = np.arctan2(-R[:, 2, 0], np.hypot(R[:, 0, 0], R[:, 1, 0]))
    upright = np.hypot(R[:, 0, 0], R[:, 1, 0]) < 1e-9
    yaw = np.where(upright, np.arctan2(-R[:, 0, 1], R[:, 1, 1]), yaw)
    return np.stack([yaw, pitch, np.where(upright, 0.0, roll)], axis=1)


def wing_angles_of(wing_axes_W: ArrayLike, body_axes_W: ArrayLike, side: Side, stroke_plane_angle: float) -> FloatArray:
    """(N, 3) stroke, deviation, pitch [rad] of a wing's axes: inverse of `Pose.wing_axes_W`.

    Parameters
    ----------
    wing_axes_W : (N, 3, 3) or (N, 3, 2), columns span, chord (and normal, which is not used), world
    body_axes_W : R_WB, (N, 3, 3)
    side : which wing
    stroke_plane_angle : v_S = Ry(angle) v_B [rad]
    """
    W, R = np.asarray(wing_axes_W, dtype=np.float64), np.asarray(body_axes_W, dtype=np.float64)
    in_S = pitch_rotation(stroke_plane_angle) @ np.swapaxes(R, 1, 2) @ W
    mirror = 1.0 if side == "right" else -1.0
    span, chord = in_S[:, :, 0], in_S[:, :, 1]
    stroke = np.arctan2(span[:, 0], mirror * span[:, 1])
    deviation = np.arctan2(-span[:, 2], np.hypot(span[:, 0], span[:, 1]))
    zero = np.zeros_like(stroke)
    at_zero = wing_axes(WingAngles(stroke=stroke, deviation=deviation, pitch=zero), side)
    pitch = np.arctan2(np.sum(chord * at_zero.upward, axis=1), np.sum(chord * at_zero.forward, axis=1))
    return np.stack([stroke, deviation, pitch], axis=1)


def pose_of_axes(
    position_W: ArrayLike,
    body_axes_W: ArrayLike,
    wings_W: tuple[ArrayLike, ArrayLike],
    bases_B: tuple[ArrayLike, ArrayLike],
    stroke_plane_angle: float,
) -> Pose:
    """Pose of a position (N, 3) [m], R_WB (N, 3, 3), axes of left and right wing (N, 3, 3) and their bases (N, 3)."""
    x = np.asarray(position_W, dtype=np.float64)
    left, right = (
        wing_angles_of(axes, body_axes_W, side, stroke_plane_angle) for axes, side in zip(wings_W, _SIDES, strict=True)
    )
    bases = [np.broadcast_to(np.asarray(base, dtype=np.float64), x.shape) for base in bases_B]
    columns = np.hstack([x, attitude_angles(body_axes_W), left, right, *bases])
    return Pose(coordinates=columns, stroke_plane_angle=stroke_plane_angle)


def pose_of_trajectory(trajectory: Trajectory, morphology: Morphology) -> Pose:
    """Pose at every instant of a simulated flight; the body's centre is its centre of mass."""
    R_WB = rotation_matrices(trajectory.q_WS) @ pitch_rotation(morphology.stroke_plane_angle)
    right_B = pitch_rotation(morphology.stroke_plane_angle).T @ np.array(morphology.right_hinge)
    hinges = np.concatenate([right_B * [1.0, -1.0, 1.0], right_B])
    columns = np.hstack([
        trajectory.position_W, attitude_angles(R_WB), wing_angles(trajectory.left), wing_angles(trajectory.right),
        np.tile(hinges, (len(trajectory.time), 1)),
    ])  # fmt: skip
    return Pose(coordinates=columns, stroke_plane_angle=morphology.stroke_plane_angle)


def mirrored(pose: Pose) -> Pose:
    """Mirror image in the world's plane y = 0: yaw and roll change sign, left and right change places."""
    X = pose.coordinates.copy()
    X[:, [1, 3, 5]] *= -1
    order: Sequence[int] = [0, 1, 2, 3, 4, 5, 9, 10, 11, 6, 7, 8, 15, 16, 17, 12, 13, 14]
    X = X[:, order]
    X[:, [13, 16]] *= -1
    return Pose(coordinates=X, stroke_plane_angle=pose.stroke_plane_angle)


_SIDES: tuple[Side, Side] = ("left", "right")

"""One instant of a fly by its axes, where a small step is a small turn whatever the angles are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from flycontrol.model.pose import Pose, pose_of_axes
from flycontrol.model.stroke import Side

FloatArray = NDArray[np.float64]

SIDES: tuple[Side, Side] = ("left", "right")
#: Columns of a step: position in the world [m], turns along body axes [rad], places of the bases in body axes [m].
MOVE, TURN = slice(0, 3), slice(3, 6)
WING_TURN, BASE_MOVE = (slice(6, 9), slice(9, 12)), (slice(12, 15), slice(15, 18))
STEPS = 18

_SMALL_TURN, _SMALL_MOVE = 1e-5, 1e-8  #: for differences [rad], [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stance:
    """Where the parts of a fly are."""

    position_W: FloatArray  #: (3,) [m]
    body_axes_W: FloatArray  #: R_WB, (3, 3): columns forward, right, down
    wings_B: FloatArray  #: (2, 3, 3): left and right; columns span, chord, normal in body axes; det -1 and +1
    bases_B: FloatArray  #: (2, 3) [m]

    def wing_axes_W(self, side: int) -> FloatArray:
        """(3, 3) span, chord, normal of the left (0) or right (1) wing in the world."""
        return self.body_axes_W @ self.wings_B[side]

    def base_W(self, side: int) -> FloatArray:
        """(3,) base of the left (0) or right (1) wing in the world [m]."""
        return self.position_W + self.body_axes_W @ self.bases_B[side]


def stances_of(pose: Pose) -> list[Stance]:
    """The instants of a pose, one by one."""
    R = pose.body_axes_W
    wings = np.stack([np.swapaxes(R, 1, 2) @ pose.wing_axes_W(side) for side in SIDES], axis=1)
    bases = np.stack([pose.base_B(side) for side in SIDES], axis=1)
    return [
        Stance(position_W=pose.position_W[k].copy(), body_axes_W=R[k], wings_B=wings[k], bases_B=bases[k])
        for k in range(len(pose))
    ]


def pose_of(stances: list[Stance], stroke_plane_angle: float) -> Pose:
    """The pose of N instants; v_S = Ry(stroke_plane_angle) v_B [rad]."""
    R = np.array([stance.body_axes_W for stance in stances])
    wings = [R @ np.array([stance.wings_B[side] for stance in stances]) for side in (0, 1)]
    bases = [np.array([stance.bases_B[side] for stance in stances]) for side in (0, 1)]
    positions = np.array([stance.position_W for stance in stances])
    return pose_of_axes(positions, R, (wings[0], wings[1]), (bases[0], bases[1]), stroke_plane_angle)


def stepped(stance: Stance, step: FloatArray) -> Stance:
    """x + dx, R exp[w], exp[w_k] A_k, b_k + db_k: a stance after a step (18,) [m, rad]."""
    turn = Rotation.from_rotvec(np.stack([step[TURN], step[WING_TURN[0]], step[WING_TURN[1]]])).as_matrix()
    return Stance(
        position_W=stance.position_W + step[MOVE],
        body_axes_W=stance.body_axes_W @ turn[0],
        wings_B=turn[1:] @ stance.wings_B,
        bases_B=stance.bases_B + step[BASE_MOVE[0].start :].reshape(2, 3),
    )


def step_between(start: Stance, end: Stance) -> FloatArray:
    """(18,) the step that leads from one stance to another [m, rad]."""
    turns = np.stack([
        start.body_axes_W.T @ end.body_axes_W,
        *(end.wings_B[side] @ start.wings_B[side].T for side in (0, 1)),
    ])  # fmt: skip
    vectors = cast(FloatArray, Rotation.from_matrix(turns).as_rotvec())
    moved = (end.bases_B - start.bases_B).ravel()
    return np.concatenate([end.position_W - start.position_W, vectors.ravel(), moved])


def coordinate_covariance(stance: Stance, covariance: FloatArray, stroke_plane_angle: float) -> FloatArray:
    """J C J^T, (18, 18), in the coordinates of `Pose`, of the covariance (18, 18) of steps from a stance."""
    size = np.full(STEPS, _SMALL_MOVE)
    size[TURN.start : BASE_MOVE[0].start] = _SMALL_TURN
    around = [stepped(stance, sign * h * row) for h, row in zip(size, np.eye(STEPS), strict=True) for sign in (1, -1)]
    X = pose_of(around, stroke_plane_angle).coordinates.reshape(STEPS, 2, STEPS)
    change = X[:, 0] - X[:, 1]
    angles = slice(3, 12)
    change[:, angles] = (change[:, angles] + np.pi) % (2 * np.pi) - np.pi
    J = (change / (2 * size[:, None])).T
    return J @ covariance @ J.T

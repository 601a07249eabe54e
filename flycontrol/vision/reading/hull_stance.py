"""Body and wings from a dissected hull by its principal axes: what Hull Reconstruction Motion Tracking reads off it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.morphology import pitch_rotation
from flycontrol.units import deg
from flycontrol.vision.dissection import BODY, LEFT, RIGHT, Dissection, dissect
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.hull import VisualHull
from flycontrol.vision.reading.axes import across, cross
from flycontrol.vision.reading.hull_roll import roll_by_spans
from flycontrol.vision.reading.hull_wing import HullWing, wings_of_voxels
from flycontrol.vision.stance import BASE_MOVE, MOVE, STEPS, TURN, WING_TURN, Stance

FloatArray = NDArray[np.float64]
#: Which of some stances fits best that differ in the left (0) or right (1) wing only.
Choice = Callable[[Sequence[Stance], int], int]

_ROUNDS = 3  #: of parting voxels and reading axes; the last gives about one voxel in a hundred to another part
#: Of hull coordinates, by comparison with simulated flights (C): lengths in voxels, turns in radians.
_SPREAD_MOVE, _SPREAD_TURN, _SPREAD_ROLL = 1.5, 3 * deg, 7 * deg
_SPREAD_SPAN, _SPREAD_PITCH, _SPREAD_BASE = 7 * deg, 18 * deg, 4.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HullStance:
    """What a hull says of a fly."""

    stance: Stance
    covariance: FloatArray  #: (18, 18) of steps from the stance [m, rad]; as large as a turn for parts not found
    dissection: Dissection


def stance_of_hull(
    hull: VisualHull, seed: Stance, shape: FlyShape, stroke_plane_angle: float, best_wing: Choice
) -> HullStance:
    """Long axes are principal axes, chords diagonals of sections; roll puts the wings' bases on the lines of the spans.

    Parts that were not found stay where the seed has them. A leading edge is above its trailing edge, over the stroke
    plane: wings pitch between 0 and 180 deg. Where a section has two diagonals, the silhouettes choose.

    Parameters
    ----------
    hull : its voxels
    seed : the stance expected; it tells left from right and head from tail
    shape : sizes of the fly
    stroke_plane_angle : v_S = Ry(angle) v_B [rad]
    best_wing : which stance the silhouettes choose
    """
    stance, parts = seed, dissect(hull, seed, shape)
    up_B = pitch_rotation(stroke_plane_angle).T @ np.array([0.0, 0.0, -1.0])
    for _ in range(_ROUNDS):
        if not parts.found[0]:
            break
        stance = _read(parts, stance, shape, up_B, best_wing)
        again = dissect(hull, stance, shape)
        settled = np.array_equal(again.labels, parts.labels)
        parts = again
        if settled:
            break
    return HullStance(stance=stance, covariance=_covariance(parts, stance), dissection=parts)


def _read(parts: Dissection, seed: Stance, shape: FlyShape, up_B: FloatArray, best_wing: Choice) -> Stance:
    body, R_seed = parts.moments(BODY), seed.body_axes_W
    centre, forward = body.middle, body.long_axis
    forward = forward if forward @ R_seed[:, 0] >= 0 else -forward
    right = across(forward, R_seed[:, 1])
    R = np.stack([forward, right, cross(forward, right)], axis=1)
    wings = [HullWing(axes=seed.wing_axes_W(k), base=centre + R_seed @ seed.bases_B[k]) for k in (0, 1)]

    def as_fly(wings: Sequence[HullWing], R: FloatArray) -> Stance:
        wings_B, bases = np.stack([R.T @ wing.axes for wing in wings]), np.stack([w.base - centre for w in wings])
        return replace(seed, position_W=centre, body_axes_W=R, wings_B=wings_B, bases_B=bases @ R)

    for k, label in enumerate((LEFT, RIGHT)):
        if parts.found[label - 1]:
            ways = wings_of_voxels(parts, label, wings[k], shape, R_seed @ up_B)
            tried = [[way, wings[1]] if k == 0 else [wings[0], way] for way in ways]
            # how the body is rolled cannot be seen
            wings = tried[best_wing([as_fly(each, R) for each in tried], k) if len(tried) > 1 else 0]
    upright = as_fly(wings, R)
    roll = roll_by_spans(upright.wings_B[:, :, 0], upright.bases_B, shape, (parts.found[1], parts.found[2]))
    return as_fly(wings, R @ roll)


def _covariance(parts: Dissection, stance: Stance) -> FloatArray:
    size = parts.hull.size
    spread = np.empty(STEPS)
    spread[MOVE] = _SPREAD_MOVE * size if parts.found[0] else 1e-3
    spread[TURN] = [_SPREAD_ROLL, _SPREAD_TURN, _SPREAD_TURN]
    covariance = np.zeros((STEPS, STEPS))
    for k in (0, 1):
        span = stance.wings_B[k][:, 0]
        along, across = np.outer(span, span), np.eye(3) - np.outer(span, span)
        turn = _SPREAD_PITCH**2 * along + _SPREAD_SPAN**2 * across
        covariance[WING_TURN[k], WING_TURN[k]] = turn if parts.found[k + 1] else np.eye(3) * (60 * deg) ** 2
        spread[BASE_MOVE[k]] = _SPREAD_BASE * size
    for columns in (MOVE, TURN, *BASE_MOVE):
        covariance[columns, columns] = np.diag(spread[columns] ** 2)
    return covariance

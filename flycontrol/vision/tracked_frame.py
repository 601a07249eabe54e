"""What a tracker says of one frame, and of all of them together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.pose import Pose
from flycontrol.vision.search.belief import NO_DOUBTS, Doubts
from flycontrol.vision.silhouette_fit import Agreement
from flycontrol.vision.stance import Stance, coordinate_covariance, pose_of

FloatArray = NDArray[np.float64]
#: tracked: all parts seen and believed; partial: the body is, but a wing is not, or a silhouette reaches the border of
#: its image, or another animal is in view; bridged: not believed, expected from the frames before; lost: bridged for
#: too long, no coordinates.
Status = Literal["tracked", "partial", "bridged", "lost"]
STATUSES: tuple[Status, ...] = get_args(Status)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrackedFrame:
    """One frame."""

    stance: Stance | None  #: None where lost
    covariance: FloatArray  #: (18, 18) of steps from the stance [m, rad]
    status: Status
    reason: str  #: why it is not tracked, or empty
    agreement: Agreement | None  #: None where nothing could be compared
    doubts: Doubts = NO_DOUBTS  #: why body, left, right wing are not believed; such a wing is expected, not seen


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Track:
    """N frames seen by C cameras."""

    pose: Pose  #: NaN where lost
    uncertainty: FloatArray  #: (N, 18) standard deviations of the pose's coordinates [m, rad]; NaN where lost
    status: tuple[Status, ...]
    reasons: tuple[str, ...]
    overlap: FloatArray  #: (N, C) intersection over union of fly and silhouette; NaN where not compared
    precision: FloatArray  #: (N, C) share of the fly's pixels that lie on the silhouette
    doubts: tuple[Doubts, ...] = ()  #: N times why body, left, right wing are not believed; empty if nobody asked

    def __len__(self) -> int:
        return len(self.status)

    @property
    def believed(self) -> NDArray[np.bool_]:
        """(N,) where the fly was seen."""
        return np.array([status in ("tracked", "partial") for status in self.status])


def gathered(frames: Iterable[TrackedFrame], stroke_plane_angle: float, cameras: int) -> Track:
    """The frames of a tracker as arrays; v_S = Ry(stroke_plane_angle) v_B [rad]."""
    X, spread, status, reasons, views, doubts = [], [], [], [], [], []
    for frame in frames:
        X.append(_row(frame, stroke_plane_angle))
        spread.append(_spread(frame, stroke_plane_angle))
        status.append(frame.status)
        reasons.append(frame.reason)
        doubts.append(tuple(frame.doubts))
        seen = frame.agreement
        views.append(np.full((2, cameras), np.nan) if seen is None else np.stack([seen.overlap, seen.precision]))
    both = np.array(views).reshape(-1, 2, cameras)
    return Track(
        pose=Pose(coordinates=np.array(X).reshape(-1, 18), stroke_plane_angle=stroke_plane_angle),
        uncertainty=np.array(spread).reshape(-1, 18),
        status=tuple(status),
        reasons=tuple(reasons),
        overlap=both[:, 0],
        precision=both[:, 1],
        doubts=tuple(doubts),
    )


def _row(frame: TrackedFrame, stroke_plane_angle: float) -> FloatArray:
    if frame.stance is None:
        return np.full(18, np.nan)
    return pose_of([frame.stance], stroke_plane_angle).coordinates[0]


def _spread(frame: TrackedFrame, stroke_plane_angle: float) -> FloatArray:
    if frame.stance is None:
        return np.full(18, np.nan)
    return np.sqrt(np.diag(coordinate_covariance(frame.stance, frame.covariance, stroke_plane_angle)))

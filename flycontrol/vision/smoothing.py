"""A track smoothed over time, with its derivatives, and the standard deviations of all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.pose import ANGLES, ATTITUDE, BASE, COORDINATES, POSITION, Pose
from flycontrol.model.stroke import Side
from flycontrol.units import deg
from flycontrol.vision.smooth.attitude_motion import attitude_motion
from flycontrol.vision.smooth.sight import FEWEST, Sight, seen_together, sight_of
from flycontrol.vision.smooth.smooth_curve import SmoothCurve, smooth_curve, smooth_curves
from flycontrol.vision.smooth.smooth_turn import SmoothTurn, smooth_turn, turn_spread
from flycontrol.vision.smooth.wing_in_body import by_body_turns, variance_from_body, wing_in_body
from flycontrol.vision.smoothed_pose import SmoothedPose
from flycontrol.vision.tracked_frame import Track

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

LONGEST_GAP = 40  #: frames that are bridged
#: Shares of the body's stated variance that neighbouring frames have in common, such as legs make them, and that no
#: smoothing takes away: of its position and of turns about forward, right, down, from simulated flights (C).
_COMMON, _COMMON_TURN = 0.5, np.array([0.5, 1.5, 1.5])
_LASTING = 0.5  #: share of the stated spread of positions that lasts for some frames (C)
#: Stroke, deviation and pitch are given within 180 deg of these.
_MIDDLE = np.array([0.0, 0.0, 90 * deg])
_SIDES: tuple[Side, Side] = ("left", "right")


def smoothed(track: Track, frame_rate: float, *, longest_gap: int = LONGEST_GAP) -> SmoothedPose:
    """The 18 coordinates as quintic smoothing splines; see `noisy_spline` for the model and `smooth_curve` for its fit.

    The body comes first: its position along the world's axes, its attitude as rotations. The wings are then read in
    the smoothed body, from where the track puts them in the world: silhouettes show a wing well in the world, and what
    the track misses of the body's roll it adds to the strokes and takes from them in turn. Their uncertainties
    are those of the wings in the body with those of the body.

    Only what was seen counts, body and each wing for itself; what a tracker expects of the rest is no observation.
    Frames between two of them are bridged with bands that grow; a gap that is too long stays NaN, and so do the ends
    before the first and after the last frame seen. Yaw is continuous and may leave +-180 deg; a wing's pitch is between
    -90 and 270 deg.

    Parameters
    ----------
    track : N frames, uncertainties finite and > 0 where the fly was seen
    frame_rate : [1/s]
    longest_gap : frames [1]

    Raises
    ------
    InvalidParameterError
        If the frame rate is not positive or the longest gap is negative.
    """
    if not (np.isfinite(frame_rate) and frame_rate > 0):
        raise InvalidParameterError(f"The frame rate must be > 0 1/s, got {frame_rate!r}.")
    if longest_gap < 0:
        raise InvalidParameterError(f"The longest gap to bridge must be >= 0 frames, got {longest_gap!r}.")
    sight = sight_of(track, frame_rate, longest_gap)
    columns = _Columns.of(len(sight.frames))
    if sight.runs:
        turn = _fill_body(columns, sight)
        for side in _SIDES:
            if sight.wing_runs[side]:
                _fill_wing(columns, sight, turn, side)
    return _placed(columns, sight.frames, track.pose)


def too_few_to_smooth(track: Track, longest_gap: int = LONGEST_GAP) -> str:
    """Why `smoothed` finds nothing in a track, one sentence; empty where it finds something."""
    seen = seen_together(track, longest_gap)
    if seen >= FEWEST:
        return ""
    gap = f", no more than {longest_gap} frames apart," if len(track) > longest_gap else ""
    return (
        f"Nothing could be smoothed: at least {FEWEST} frames in which the fly is seen{gap} are needed, and there "
        f"{'is' if seen == 1 else 'are'} {seen or 'none'}."
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Columns:
    """N frames; the last index is the derivative."""

    value: FloatArray  #: (N, 18, 3)
    variance: FloatArray  #: (N, 18, 3)
    omega: FloatArray  #: (N, 3) angular velocity
    omega_spread: FloatArray  #: (N, 3)
    set_aside: BoolArray  #: (N, 18)

    @classmethod
    def of(cls, frames: int) -> _Columns:
        """Nothing known."""
        value, variance = np.full((2, frames, len(COORDINATES), 3), np.nan)
        omega, omega_spread = np.full((2, frames, 3), np.nan)
        set_aside = np.zeros((frames, len(COORDINATES)), dtype=np.bool_)
        return cls(value=value, variance=variance, omega=omega, omega_spread=omega_spread, set_aside=set_aside)

    def put(self, column: int, curve: SmoothCurve) -> None:
        """One smooth coordinate."""
        self.value[:, column] = curve.value
        self.variance[:, column] = np.diagonal(curve.covariance, axis1=1, axis2=2)
        self.set_aside[:, column] = curve.set_aside


def _fill_body(columns: _Columns, sight: Sight) -> SmoothTurn:
    runs, rate = sight.runs, sight.frame_rate
    x, spread = sight.pose.position_W, sight.spread[:, POSITION]
    common = _COMMON * sight.bridged(spread**2)
    position = smooth_curves(sight.among_all(x), sight.among_all(spread), runs, rate, lasting=_LASTING)
    for k, curve in enumerate(position):
        columns.put(k, curve.with_common(common[:, k]))
    spread_B = turn_spread(sight.pose.coordinates[:, ATTITUDE], sight.spread[:, ATTITUDE])
    R = sight.among_all(sight.pose.body_axes_W)
    turn = smooth_turn(R, sight.among_all(spread_B), runs, rate).with_common(_COMMON_TURN * sight.bridged(spread_B**2))
    motion = attitude_motion(turn, rate)
    columns.value[:, ATTITUDE], columns.variance[:, ATTITUDE] = motion.angles, motion.spread**2
    columns.omega[:], columns.omega_spread[:] = motion.angular_velocity_B, motion.angular_velocity_spread
    columns.set_aside[:, ATTITUDE] = turn.set_aside[:, None]
    return turn


def _fill_wing(columns: _Columns, sight: Sight, turn: SmoothTurn, side: Side) -> None:
    position_W, R = columns.value[:, POSITION, 0], turn.body_axes_W
    wing = wing_in_body(sight.pose, side, position_W[sight.seen], R[sight.seen])
    # no wing turns right round: unwrapped, one wrong frame would lead all that follow astray
    wing[:, :3] = (wing[:, :3] - _MIDDLE + np.pi) % (2 * np.pi) - np.pi + _MIDDLE
    wing[~sight.wing_seen[side]] = np.nan
    places, runs = np.r_[ANGLES[side], BASE[side]], sight.wing_runs[side]
    for k, values in zip(places, wing.T, strict=True):
        y, sigma = sight.among_all(values), sight.among_all(sight.spread[:, k])
        columns.put(k, smooth_curve(y, sigma, runs, sight.frame_rate, lasting=None))
    variance = columns.variance[:, places]
    now = Pose(coordinates=columns.value[:, :, 0], stroke_plane_angle=sight.pose.stroke_plane_angle)
    by_turns = by_body_turns(now, side)
    for run in runs:
        variance[run] += variance_from_body(by_turns[run], turn.covariance[run], sight.frame_rate)
    variance[:, 3:] += np.einsum("nij,nik->njk", R**2, columns.variance[:, POSITION])
    variance[:, :, 0] = np.maximum(variance[:, :, 0], _COMMON * sight.bridged(sight.spread[:, places] ** 2))
    columns.variance[:, places] = variance


def _placed(columns: _Columns, kept: NDArray[np.int_], pose: Pose) -> SmoothedPose:
    """Columns of the frames kept, among all frames of a pose."""
    whole = _Columns.of(len(pose))
    for name in ("value", "variance", "omega", "omega_spread", "set_aside"):
        getattr(whole, name)[kept] = getattr(columns, name)
    value, spread = whole.value, np.sqrt(whole.variance)
    value[kept, 3, 0] = np.unwrap(value[kept, 3, 0])
    return SmoothedPose(
        pose=Pose(coordinates=value[:, :, 0], stroke_plane_angle=pose.stroke_plane_angle),
        uncertainty=spread[:, :, 0],
        rate=value[:, :, 1],
        rate_uncertainty=spread[:, :, 1],
        acceleration=value[:, :, 2],
        acceleration_uncertainty=spread[:, :, 2],
        angular_velocity_B=whole.omega,
        angular_velocity_uncertainty=whole.omega_spread,
        set_aside=whole.set_aside,
    )

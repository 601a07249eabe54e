"""What a report keeps of a flight while it passes in pieces: never more than a few thousand instants of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.aerodynamics import FlightLoads
from flycontrol.flight.experiments import PlannedFlight
from flycontrol.flight.multibody.inverse import inverse_dynamics
from flycontrol.flight.wing_loads import loads_along
from flycontrol.flight.wingbeat_means import WingbeatMeans, wingbeat_means
from flycontrol.flight.worst_wingbeat import step_errors, worst
from flycontrol.model.stroke import WingMotion
from flycontrol.model.trajectory import QuadratureError, StepError, Trajectory, rotation_matrices, wing_rates

FloatArray = NDArray[np.float64]

_MOST_INSTANTS = 4000  #: of the body's motion
_MOST_BEATS = 2000  #: whose means are kept
_UPRIGHT = 0.5  #: cosine of the stroke plane's tilt, up to which a heading means something
_FILMED, _FRAMES = 14, 10  #: wingbeats at most, and frames of each at most
_BEFORE, _CLOSE = 1, 4  #: wingbeats before the first pulse, and in all, that are kept as they were sampled


@dataclass(frozen=True, slots=True, kw_only=True)
class Closely:
    """A few wingbeats as they were sampled."""

    flight: Trajectory
    loads: FlightLoads
    power: FloatArray  #: (N,) of both wings' hinges [W]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightRecord:
    """A flight as a report shows it."""

    planned: PlannedFlight
    status: str  #: "complete", or a sentence
    wingbeats: int  #: flown
    step_error: StepError | None  #: of the worst wingbeat among the first, the last, pulses and ramps
    step_error_wingbeat: int  #: which one it is, from 0
    step_error_wingbeats: tuple[int, ...]  #: those that were repeated with half the steps
    quadrature_error: QuadratureError | None  #: None: not one wingbeat was flown
    body: Trajectory  #: every instant, or the first of wingbeats that are evenly apart
    beats: WingbeatMeans  #: of wingbeats that are evenly apart
    mean: WingbeatMeans | None  #: over all wingbeats, a single row
    closely: Closely | None  #: around the first pulse, or the first wingbeats
    film: Trajectory  #: instants for an animation, around the first pulse
    peak_yaw: float  #: farthest from the heading at the beginning while tilted by less than 60 deg, with its sign [rad]
    peak_yaw_time: float  #: [s]

    @property
    def complete(self) -> bool:
        """Whether it flew as many wingbeats as it was asked to."""
        return self.status == "complete"


class FlightRecorder:
    """Takes a flight in pieces, each beginning where the one before it ended."""

    def __init__(self, planned: PlannedFlight) -> None:
        self._planned = planned
        self._per_beat = planned.settings.samples
        self._of_body = _Sieve(0, math.inf, _body_stride(planned))
        first = min((pulse.start for pulse in planned.plan.pulses), default=0.0) * planned.frequency
        close = max(0, min(math.floor(first) - _BEFORE, planned.experiment.wingbeats - _CLOSE))
        self._close = _Sieve(close * self._per_beat, (close + _CLOSE) * self._per_beat, 1)
        filmed = max(0, min(math.floor(first) - _BEFORE, planned.experiment.wingbeats - _FILMED))
        apart = next(
            k for k in range(1, self._per_beat + 1) if self._per_beat % k == 0 and self._per_beat / k <= _FRAMES
        )
        self._film = _Sieve(filmed * self._per_beat, (filmed + _FILMED) * self._per_beat, apart)
        self._beats = _Beats(math.ceil(planned.experiment.wingbeats / _MOST_BEATS))
        self._last: Trajectory | None = None
        self._yaw, self._flat = 0.0, True
        self._peak = (0.0, 0.0)
        self._quadrature: QuadratureError | None = None
        self._step_errors: dict[int, StepError] = {}

    def add(self, piece: Trajectory) -> None:
        """Look at a piece."""
        self._follow_yaw(piece)
        start = round(float(piece.phase[0]) * self._per_beat) if len(piece.phase) else 0
        again = self._last is not None
        for sieve in (self._of_body, self._close, self._film):
            sieve.add(piece, start, again=again)
        if self._last is None:
            self._step_errors |= {} if piece.step_error is None else {0: piece.step_error}
            self._quadrature = piece.quadrature_error
        if len(piece.phase) > 1 and self._planned.settings.estimate_error:
            self._step_errors |= step_errors(self._planned, piece)
        self._beats.add(wingbeat_means(self._planned.plan.fly, piece))
        self._last = piece

    def finish(self) -> FlightRecord:
        """What was kept."""
        assert self._last is not None, "a flight has at least one piece"
        fly, empty = self._planned.plan.fly, taken(self._last, np.arange(0))
        near, found = self._close.found(empty), worst(self._step_errors)
        return FlightRecord(
            planned=self._planned,
            status=self._last.status,
            wingbeats=self._last.wingbeats,
            step_error=None if found is None else found[1],
            step_error_wingbeat=0 if found is None else found[0],
            step_error_wingbeats=tuple(sorted(self._step_errors)),
            quadrature_error=self._quadrature,
            body=self._of_body.found(empty),
            beats=self._beats.kept(),
            mean=self._beats.mean(),
            closely=None if not len(near.time) else Closely(
                flight=near, loads=loads_along(fly, near), power=hinge_power(self._planned, near)
            ),
            film=self._film.found(empty),
            peak_yaw=self._peak[0],
            peak_yaw_time=self._peak[1],
        )  # fmt: skip

    def _follow_yaw(self, piece: Trajectory) -> None:
        """Note the farthest heading, as long as the stroke plane lies flat enough to have one."""
        if not len(piece.time):
            return
        yaw = np.unwrap([self._yaw, *piece.yaw])[1:]
        self._yaw = float(yaw[-1])
        upright = -rotation_matrices(piece.q_WS)[:, 2, 2] > _UPRIGHT
        flat = len(upright) if upright.all() else int(np.argmin(upright))
        if self._flat and flat:
            farthest = int(np.argmax(np.abs(yaw[:flat])))
            if abs(yaw[farthest]) > abs(self._peak[0]):
                self._peak = (float(yaw[farthest]), float(piece.time[farthest]))
        self._flat &= bool(upright.all())


def hinge_power(planned: PlannedFlight, flight: Trajectory) -> FloatArray:
    """P = sum of tau_k q'_k over the joints of both wings, (N,) [W]: what hinges and muscles give to the wings."""
    needed = inverse_dynamics(planned.plan.fly, flight)
    power = needed.left_hinge * wing_rates(flight.left) + needed.right_hinge * wing_rates(flight.right)
    return power.sum(axis=1)


def taken(flight: Trajectory, index: NDArray[np.int64]) -> Trajectory:
    """Some instants of a flight."""
    arrays = {name: getattr(flight, name)[index] for name in _ARRAYS}
    wings = {
        side: WingMotion(**{name: getattr(flight.wing(side), name)[index] for name in WingMotion.__slots__})
        for side in ("left", "right")
    }
    return replace(flight, **arrays, left=wings["left"], right=wings["right"])


_ARRAYS = (
    "time", "phase", "position_W", "q_WS", "velocity_S", "angular_velocity_S", "acceleration_S",
    "angular_acceleration_S", "left_acceleration", "right_acceleration",
)  # fmt: skip


def one_after_another(pieces: Sequence[Trajectory]) -> Trajectory:
    """Pieces that share no instants, as one."""
    arrays = {name: np.concatenate([getattr(piece, name) for piece in pieces]) for name in _ARRAYS}
    wings = {
        side: WingMotion(**{
            name: np.concatenate([getattr(piece.wing(side), name) for piece in pieces])
            for name in WingMotion.__slots__
        })
        for side in ("left", "right")
    }  # fmt: skip
    return replace(pieces[-1], **arrays, left=wings["left"], right=wings["right"])


def _body_stride(planned: PlannedFlight) -> int:
    """Between instants that are kept: 1, or whole wingbeats, so that the wingbeat itself does not beat with them."""
    beats, per_beat = planned.experiment.wingbeats, planned.settings.samples
    return 1 if beats * per_beat <= _MOST_INSTANTS else per_beat * math.ceil(beats / _MOST_INSTANTS)


class _Sieve:
    """Keeps every so manyth instant from one to another."""

    def __init__(self, first: int, last: float, apart: int) -> None:
        self._first, self._until, self._apart = first, last, apart
        self._pieces: list[Trajectory] = []

    def add(self, piece: Trajectory, start: int, *, again: bool) -> None:
        """Look at a piece whose first instant is number `start` of the flight, and seen before if `again`."""
        number = start + np.arange(len(piece.time))
        wanted = (number >= self._first) & (number <= self._until) & ((number - self._first) % self._apart == 0)
        wanted[:1] &= not again
        self._pieces.append(taken(piece, np.flatnonzero(wanted)))

    def found(self, empty: Trajectory) -> Trajectory:
        return one_after_another([empty, *self._pieces])


class _Beats:
    """Means of every so manyth wingbeat, and the mean of all."""

    def __init__(self, apart: int) -> None:
        self._apart, self._seen = apart, 0
        self._kept: list[WingbeatMeans] = []
        self._sum: WingbeatMeans | None = None

    def add(self, means: WingbeatMeans) -> None:
        number = self._seen + np.arange(len(means))
        self._kept.append(means.rows(number % self._apart == 0))
        self._sum = means.total() if self._sum is None else self._sum + means.total()
        self._seen += len(means)

    def kept(self) -> WingbeatMeans:
        return WingbeatMeans.joined(self._kept)

    def mean(self) -> WingbeatMeans | None:
        return None if self._sum is None or not self._seen else self._sum.over(self._seen)

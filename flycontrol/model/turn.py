"""Turns: when they happen, and by how much Eq. 3 says that paddling should have turned the fly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.wingbeats import Wingbeats
from flycontrol.units import deg

FloatArray = NDArray[np.float64]

SMALLEST_TURN = 5 * deg  #: about three times the scatter of a tracked heading [rad]
LOW_RATE = 0.2  #: a turn begins and ends where the yaw rate is below this share of its peak


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnInterval:
    """Wingbeats first..last, both included, during which the yaw rate keeps its sign."""

    first: int
    last: int
    complete: bool  #: the yaw rate is low on both sides; otherwise the recording cuts the turn


def find_turns(yaw_rate: FloatArray, beats: Wingbeats) -> list[TurnInterval]:
    """Excursions of the yaw rate that start and end below a fifth of their peak and turn by at least 5 deg.

    Parameters
    ----------
    yaw_rate : (n,) mean over each wingbeat [rad/s]
    beats : the n wingbeats
    """
    edges = np.flatnonzero(np.diff(np.sign(yaw_rate)) != 0) + 1
    turns: list[TurnInterval] = []
    for run in np.split(np.arange(len(yaw_rate)), edges):
        turns += _excursions(run, np.abs(yaw_rate))
    angle = yaw_rate * beats.durations
    return [t for t in turns if abs(float(angle[t.first : t.last + 1].sum())) >= SMALLEST_TURN]


def _excursions(run: NDArray[np.intp], rate: FloatArray) -> list[TurnInterval]:
    """Take the largest peak of a run of one sign, then look in what is left on either side of it."""
    if run.size == 0:
        return []
    peak = run[np.argmax(rate[run])]
    low = LOW_RATE * rate[peak]
    before, after = run[(run < peak) & (rate[run] < low)], run[(run > peak) & (rate[run] < low)]
    first = before[-1] + 1 if before.size else run[0]
    last = after[0] - 1 if after.size else run[-1]
    complete = bool(first > 0 and last < len(rate) - 1)
    rest = [run[run < first], run[run > last]]
    here = TurnInterval(first=int(first), last=int(last), complete=complete)
    return [*_excursions(rest[0], rate), here, *_excursions(rest[1], rate)]


@dataclass(frozen=True, slots=True, kw_only=True)
class PaddlingTurn:
    """One turn: what the fly did, and what Eq. 4 and 5 make of its paddling."""

    start: float  #: [s]
    end: float  #: [s]
    wingbeats: int
    complete: bool  #: begins and ends at low yaw rate inside the recording
    angle: float  #: Delta psi, integral of the measured yaw rate about the stroke-plane normal [rad]
    rate_change: float  #: Delta psi' [rad/s]
    paddling_integral: float  #: integral of d_alpha [rad s]
    trimmed_integral: float  #: integral of d_alpha less the flight's median d_alpha [rad s]
    by_wing_speed: float  #: omega * integral of d_alpha, Eq. 5's right side [rad]
    by_wing_speed_trimmed: float  #: the same of d_alpha less its median [rad]
    by_plant: float  #: gamma/beta * integral of d_alpha, Eq. 5 [rad]; NaN where beta <= 0
    by_plant_with_offset: float  #: (gamma * integral of d_alpha + I c * duration) / beta [rad]
    rate_change_correction: float  #: -(I / beta) Delta psi' of Eq. 4, to be added to the two above [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnModel:
    """What Eq. 4 and 5 need: psi'' = -b psi' + g d_alpha + c, and omega."""

    damping: float  #: b = beta / I [1/s]
    paddling: float  #: g = gamma / I [1/s^2 per rad]
    offset: float  #: c [rad/s^2]
    wing_speed: float  #: omega, mean |phi'| [rad/s]


def paddling_turn(
    interval: TurnInterval,
    beats: Wingbeats,
    yaw_rate_at_reversals: FloatArray,
    d_alpha: FloatArray,
    angle: FloatArray,
    model: TurnModel,
) -> PaddlingTurn:
    """Delta psi = (gamma/beta) int d_alpha dt - (I/beta) Delta psi'.  Review, Eq. 4; Eq. 5 without the last term.

    Parameters
    ----------
    interval : the turn's wingbeats
    beats : all n wingbeats
    yaw_rate_at_reversals : (n + 1,) [rad/s]
    d_alpha : (n,) mean over each wingbeat [rad]
    angle : (n,) integral of the yaw rate over each wingbeat [rad]
    """
    inside = slice(interval.first, interval.last + 1)
    durations = beats.durations[inside]
    integral = float(np.sum(d_alpha[inside] * durations))
    trimmed = integral - float(np.median(d_alpha)) * float(durations.sum())
    change = float(yaw_rate_at_reversals[interval.last + 1] - yaw_rate_at_reversals[interval.first])
    time_constant = 1.0 / model.damping if model.damping > 0 else np.nan
    return PaddlingTurn(
        start=float(beats.reversals[interval.first]),
        end=float(beats.reversals[interval.last + 1]),
        wingbeats=interval.last - interval.first + 1,
        complete=interval.complete,
        angle=float(angle[inside].sum()),
        rate_change=change,
        paddling_integral=integral,
        trimmed_integral=trimmed,
        by_wing_speed=model.wing_speed * integral,
        by_wing_speed_trimmed=model.wing_speed * trimmed,
        by_plant=model.paddling * time_constant * integral,
        by_plant_with_offset=time_constant * (model.paddling * integral + model.offset * float(durations.sum())),
        rate_change_correction=-time_constant * change,
    )

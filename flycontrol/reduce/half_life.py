"""How long a yaw rate lasts after a kick: the flight of the whole model against I r' = -beta r.

    half-life = ln 2 I / beta

A kick is a torque about the stroke plane's normal, so short that the wings do not move. Within a wingbeat the rate
falls fast at mid-stroke and hardly at reversal; half-lives take it from one wingbeat to the next. Wings on springs need
a wingbeat or two until their pitch has followed: then the late half-life is that of the turning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.multibody.freedoms import FREE, YAW_ONLY
from flycontrol.flight.pulses import BodyPulse
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState

FloatArray = NDArray[np.float64]
Freedom = Literal["yaw", "all"]

PHASES = tuple(k / 8 for k in range(8))  #: of the wingbeat at which the fly is kicked
_SETTINGS = MarchSettings(steps=400, samples=400, estimate_error=False)
_KICK = 0.01  # of a wingbeat: four steps
_BEFORE, _AFTER = 1, 4  # wingbeats


@dataclass(frozen=True, slots=True, kw_only=True)
class YawDecay:
    """What is left of a yaw rate after kicks at n phases of the wingbeat."""

    freedom: Freedom  #: the body turns about its yaw axis alone, as on a magnetic tether, or flies freely
    frequency: float  #: wingbeats a second [1/s]
    phases: FloatArray  #: (n,) of the kicks [wingbeats]
    rates: FloatArray  #: (n, 5) yaw rate right after the kick and 1 to 4 wingbeats later [rad/s]
    first_halves: FloatArray  #: (n,) until the rate is half of that right after the kick for the first time [s]

    @property
    def decay(self) -> FloatArray:
        """(n,) the rate a wingbeat later over the rate right after the kick [1]."""
        return self.rates[:, 1] / self.rates[:, 0]

    @property
    def half_life(self) -> float:
        """ln 2 / (-f ln decay), mean over the phases: what wingbeat-averaged yaw takes to halve [s]."""
        return self._half_life(self.decay)

    @property
    def late_half_life(self) -> float:
        """The same from the third to the fourth wingbeat after the kick [s]; NaN if the rate has changed its sign."""
        return self._half_life(self.rates[:, 4] / self.rates[:, 3])

    @property
    def in_wingbeats(self) -> float:
        """The half-life [wingbeats]."""
        return self.half_life * self.frequency

    def _half_life(self, decay: FloatArray) -> float:
        if np.any(decay <= 0):
            return float("nan")
        return float(np.log(2) / (-self.frequency * np.log(decay).mean()))


def yaw_decay(
    fly: FlappingFly,
    kinematics: StrokeKinematics,
    start: FlightState | None = None,
    *,
    freedom: Freedom = "yaw",
    rate: float = 1.0,
    phases: Sequence[float] = PHASES,
) -> YawDecay:
    """Kick the fly at each phase and follow its yaw rate.

    Parameters
    ----------
    fly
        Its body freedoms do not count.
    kinematics
        A stroke that both wings share, so that the fly does not turn by itself.
    start
        State at phase 0, that of a hover trim or of wings on springs that have settled; without it the body starts
        level and at rest.
    freedom
        What the body may do: "yaw" alone or "all".
    rate
        Yaw rate that the kick would give the rigid body if it could only yaw, > 0 to the right, not 0 [rad/s].
    phases
        When to kick [wingbeats].

    Raises
    ------
    InvalidParameterError
        The wings differ, the freedom is not known, there is no phase, the kick is none, or the rate does not halve
        within four wingbeats.
    """
    if kinematics.left != kinematics.right or fly.left != fly.right:
        raise InvalidParameterError(
            "A half-life of yaw needs a stroke and hinges that both wings share; symmetrise them first."
        )
    if freedom not in ("yaw", "all"):
        raise InvalidParameterError(f"yaw_decay needs the freedom 'yaw' or 'all', got {freedom!r}.")
    if np.ndim(phases) != 1 or not len(phases):
        raise InvalidParameterError(
            f"yaw_decay needs a list of at least one phase, got {phases!r}; write phases=[0.25] for a single one."
        )
    if not (np.isfinite(rate) and rate != 0):
        raise InvalidParameterError(
            f"yaw_decay needs a kick: a finite rate other than 0 rad/s, got {rate!r}; > 0 kicks to the right."
        )
    body = YAW_ONLY if freedom == "yaw" else FREE
    kicked = [_kicked(replace(fly, body=body), kinematics, start, rate, phase) for phase in phases]
    return YawDecay(
        freedom=freedom,
        frequency=kinematics.frequency,
        phases=np.array(phases, dtype=np.float64),
        rates=np.stack([rates for rates, _ in kicked]),
        first_halves=np.array([half for _, half in kicked]),
    )


def _kicked(
    fly: FlappingFly, kinematics: StrokeKinematics, start: FlightState | None, rate: float, phase: float
) -> tuple[FloatArray, float]:
    """(5,) yaw rate right after the kick and at wingbeats after it [rad/s]; the time to half of the first [s]."""
    if not 0 <= phase < 1:
        raise InvalidParameterError(f"A kick's phase must lie in 0..1 wingbeats, 1 not included, got {phase!r}.")
    f, n = kinematics.frequency, _SETTINGS.samples
    torque = fly.morphology.yaw_inertia * rate * f / _KICK
    pulse = BodyPulse(start=(_BEFORE + phase) / f, duration=_KICK / f, torque_S=(0.0, 0.0, torque))
    flown = simulate_flight(fly, kinematics, _BEFORE + 1 + _AFTER, start=start, pulses=[pulse], settings=_SETTINGS)
    yaw_rate = flown.angular_velocity_S[round((_BEFORE + phase + _KICK) * n) :, 2]
    kept = np.sign(rate) * yaw_rate  # of the kick's own direction
    below = np.flatnonzero(kept <= kept[0] / 2)
    if not below.size:
        raise InvalidParameterError(
            f"The yaw rate of {fly.morphology.species} did not halve within {_AFTER} wingbeats of the kick; check its "
            "wings and its air."
        )
    k = int(below[0])
    into = (kept[k - 1] - kept[0] / 2) / (kept[k - 1] - kept[k])
    return yaw_rate[: _AFTER * n + 1 : n], float((k - 1 + into) / (n * f))

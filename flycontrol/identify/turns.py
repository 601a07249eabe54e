"""Eq. 3-5 on a measured flight: does paddling against damping explain how it turned?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from flycontrol.errors import InvalidInputError
from flycontrol.identify.motion import angular_velocity, required_torque
from flycontrol.identify.yaw_plant import STEADIEST, YawHistory, YawPlantFit, fit_yaw_plant
from flycontrol.model.morphology import Morphology
from flycontrol.model.paddling import Paddling, paddling
from flycontrol.model.recording import Recording
from flycontrol.model.stroke import derivative
from flycontrol.model.turn import PaddlingTurn, TurnModel, find_turns, paddling_turn
from flycontrol.model.wingbeats import Wingbeats, segment_wingbeats, wingbeat_mean
from flycontrol.units import deg

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnIdentification:
    """The minimal model on one flight. Arrays of shape (n,) hold one value a wingbeat."""

    name: str
    status: str  #: a sentence: what was found, or why nothing could be
    time: FloatArray  #: (n,) middle of each wingbeat [s]
    reversals: FloatArray  #: (n + 1,) [s]
    yaw_rate: FloatArray  #: (n,) wingbeat mean about the stroke-plane normal [rad/s]
    yaw_rate_at_reversals: FloatArray  #: (n + 1,) [rad/s]
    d_alpha: FloatArray  #: (n,) [rad]
    coupling: FloatArray  #: (n,) (I w' + w x I w)_z / I_zz - psi'' [rad/s^2]
    plant: YawPlantFit | None  #: Eq. 3 as it stands; None where the status says why
    plant_with_coupling: YawPlantFit | None  #: beside it: with products of inertia and gyroscopic torque
    turns: tuple[PaddlingTurn, ...]  #: by `plant`
    d_alpha_noise: float  #: standard deviation from wingbeat to wingbeat, by second differences [rad]
    d_alpha_reliability: (
        float  #: share of d_alpha's variance that is not that noise; scales gamma down; NaN: no variance
    )
    d_alpha_largest_share: float  #: share of d_alpha's variance that one wingbeat holds; NaN: no variance


def identify_turns(
    recording: Recording, morphology: Morphology, beats: Wingbeats | None = None, paddled: Paddling | None = None
) -> TurnIdentification:
    """I psi'' = -beta psi' + gamma d_alpha.  Review, Eq. 3-5; psi' is a wingbeat mean about the stroke-plane normal.

    Raises
    ------
    InvalidInputError
        Wing angles or angular velocity are missing, or there are fewer than three wingbeats.
    """
    beats = beats or segment_wingbeats(recording)
    paddled = paddled or paddling(recording, beats)
    rates = angular_velocity(recording)[:, 2]
    if np.ptp(rates) == 0:
        raise InvalidInputError(
            f"{recording.name}: the yaw rate is {rates[0]:g} rad/s in every sample, so no turn can be studied; check "
            "the mapping of angular velocity."
        )
    at_reversals = CubicSpline(recording.time, rates)(beats.reversals)
    mean_rate = wingbeat_mean(rates, recording.time, beats)
    coupling = _coupling(recording, morphology, beats)
    histories = [(at_reversals, paddled.d_alpha, beats.durations, u) for u in (np.zeros_like(coupling), coupling)]
    plant, coupled, failure = _fits(histories)
    noise, reliability, largest = _scatter(paddled.d_alpha)
    return TurnIdentification(
        name=recording.name,
        status=failure or _status(plant),
        time=beats.middles,
        reversals=beats.reversals,
        yaw_rate=mean_rate,
        yaw_rate_at_reversals=at_reversals,
        d_alpha=paddled.d_alpha,
        coupling=coupling,
        plant=plant,
        plant_with_coupling=coupled,
        turns=_turns(beats, mean_rate, at_reversals, paddled, plant),
        d_alpha_noise=noise,
        d_alpha_reliability=reliability,
        d_alpha_largest_share=largest,
    )


def _scatter(d_alpha: FloatArray) -> tuple[float, float, float]:
    """Scatter from wingbeat to wingbeat [rad], the share of the variance that is none, the share of one wingbeat."""
    noise = float(np.sqrt(np.mean(np.diff(d_alpha, 2) ** 2) / 6.0))
    if np.ptp(d_alpha) <= STEADIEST:
        return noise, np.nan, np.nan
    squares = (d_alpha - d_alpha.mean()) ** 2
    return noise, float(max(0.0, 1.0 - noise**2 / squares.mean())), float(squares.max() / squares.sum())


def coupling_free_acceleration(recording: Recording, morphology: Morphology, beats: Wingbeats) -> FloatArray:
    """(I w' + w x I w)_z / I_zz over each wingbeat: the yaw torque needed, over the inertia, (n,) [rad/s^2]."""
    torque = wingbeat_mean(required_torque(recording, morphology), recording.time, beats)
    return torque[:, 2] / morphology.yaw_inertia


def _coupling(recording: Recording, morphology: Morphology, beats: Wingbeats) -> FloatArray:
    yaw_acceleration = derivative(angular_velocity(recording)[:, 2], recording.rate)
    return coupling_free_acceleration(recording, morphology, beats) - wingbeat_mean(
        yaw_acceleration, recording.time, beats
    )


def _fits(
    histories: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]],
) -> tuple[YawPlantFit | None, YawPlantFit | None, str]:
    """Both readings, or the sentence that says why there are none."""
    try:
        plant, coupled = (
            fit_yaw_plant(YawHistory(yaw_rate=r, d_alpha=d, durations=t, coupling=u)) for r, d, t, u in histories
        )
    except InvalidInputError as error:
        return None, None, str(error)
    return plant, coupled, ""


def _turns(
    beats: Wingbeats, mean_rate: FloatArray, at_reversals: FloatArray, paddled: Paddling, plant: YawPlantFit | None
) -> tuple[PaddlingTurn, ...]:
    nan = float("nan")
    model = TurnModel(
        damping=plant.damping.value if plant else nan,
        paddling=plant.paddling.value if plant and plant.paddling else nan,
        offset=plant.intercept if plant else nan,
        wing_speed=paddled.mean_wing_speed,
    )
    angle = mean_rate * beats.durations
    return tuple(
        paddling_turn(interval, beats, at_reversals, paddled.d_alpha, angle, model)
        for interval in find_turns(mean_rate, beats)
    )


def _status(plant: YawPlantFit | None) -> str:
    assert plant is not None
    if plant.paddling is None:
        return _status_without_paddling(plant)
    signs = {
        (True, True): "damping and paddling both come out with the sign of Eq. 3",
        (True, False): "damping has the sign of Eq. 3, paddling cannot be told from none",
        (False, True): "paddling has the sign of Eq. 3, damping cannot be told from none",
        (False, False): "neither damping nor paddling can be told from none",
    }
    opposite = [name for name, e in (("damping", plant.damping), ("paddling", plant.paddling)) if e.high < 0]
    found = signs[(plant.damping.low > 0, plant.paddling.low > 0)]
    if opposite:
        found = f"{' and '.join(opposite)} came out with the sign opposite to Eq. 3"
    return (
        f"Eq. 3 can explain at most {plant.r2_acceleration_best:.0%} of the variance of the yaw acceleration; at the "
        f"estimates it explains {plant.r2_acceleration:.0%}, and {plant.r2_simulated:.0%} of the yaw rate when "
        f"simulated from the paddling alone (negative: worse than the mean); {found}."
    )


def _status_without_paddling(plant: YawPlantFit) -> str:
    known = "has the sign of Eq. 3" if plant.damping.low > 0 else "cannot be told from none"
    known = "came out with the sign opposite to Eq. 3" if plant.damping.high < 0 else known
    return (
        "There is no paddling in this recording (d_alpha is the same in every wingbeat), so gamma cannot be "
        f"identified; damping alone explains {plant.r2_acceleration:.0%} of the variance of the yaw acceleration and "
        f"{known}."
    )


def turn_sentence(turn: PaddlingTurn) -> str:
    """One turn in words."""
    by_plant = (
        "the plant does not say"
        if not np.isfinite(turn.by_plant)
        else f"gamma/beta * integral {turn.by_plant / deg:.0f} deg, Eq. 4's correction "
        f"{turn.rate_change_correction / deg:+.0f} deg"
    )
    whole = "" if turn.complete else ", cut by the recording's edge"
    return (
        f"Turn at {turn.start * 1e3:.0f}-{turn.end * 1e3:.0f} ms ({turn.wingbeats} wingbeats{whole}): measured "
        f"{turn.angle / deg:.0f} deg; omega * integral of d_alpha {turn.by_wing_speed / deg:.0f} deg, "
        f"{turn.by_wing_speed_trimmed / deg:.0f} deg with the flight's median d_alpha taken as zero; {by_plant}."
    )

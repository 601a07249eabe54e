"""Hover trim: the symmetric stroke whose wingbeat-averaged force and pitch torque balance the weight.

    body held:  <F_x> = 0,  <F_z> = 0,  <N_y> = 0    (air, weight and the wings' inertia, body at rest)
    body free:  v(T) = v(0),  q(T) = q(0),  theta(T) = theta(0),  x(T) = x(0),  <theta> = body_pitch

The second is a periodic orbit that stays in place: its mean loads vanish while the body bobs and nods with its wings.
The first is a tethered fly's balance, and where the search for the second begins.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.body_coordinates import COORDINATES, LONGITUDINAL, PITCH, state_at
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import unpacked
from flycontrol.flight.trim_balance import Balance, free_beat, held_balance
from flycontrol.flight.trim_parameters import FREQUENCY, FlownStroke, Limits, TrimParameters
from flycontrol.model.morphology import GRAVITY
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState

FloatArray = NDArray[np.float64]

BALANCED = 1e-7  #: the largest residual of a trim [weights, weights times wing lengths, wing lengths, rad]
_DIFFERENCE = 1e-3  #: of scaled unknowns
_TOLERANCE = 1e-14
_MOST_EVALUATIONS = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class HoverTrim:
    """A stroke that keeps a fly in place; a built-in stroke that is trimmed so has certainty C."""

    kinematics: StrokeKinematics
    start: FlightState  #: at phase 0: on the periodic orbit where the body is free, at rest where it is held
    body: Literal["free", "held"]
    values: Mapping[str, float]  #: what the trim moved [rad, 1/s]
    held_values: Mapping[str, float]  #: the same for the held body, the first stage [rad, 1/s]
    body_pitch: float  #: mean angle of the stroke plane above the horizon, > 0 nose up [rad]
    balance: Balance  #: what is left of it
    iterations: int  #: of both stages
    status: str  #: a sentence


def hover_trim(
    fly: FlappingFly,
    kinematics: StrokeKinematics,
    moves: tuple[str, str, str] = (FREQUENCY, "stroke_offset", "pitch_offset"),
    *,
    body_pitch: float = 0.0,
    limits: Limits | None = None,
    settings: MarchSettings | None = None,
) -> HoverTrim:
    """Move three parameters of a symmetric stroke until the flying fly hovers on a periodic orbit.

    Parameters
    ----------
    fly
        With prescribed wings, gravity along -z of W; its body freedoms do not count.
    kinematics
        Where the search begins, the same periodic stroke for both wings: built-in, Fourier series or samples.
    moves
        Three of `frequency`, `body_pitch` and what `trim_parameters.LIMITS` names: parameters of a `BermanWangStroke`,
        or changes of any stroke as a `Modulation` makes them.
    body_pitch
        Mean angle of the stroke plane above the horizon, > 0 nose up; where the search begins if `moves` names it
        [rad].
    limits
        Least and largest values by name [rad, 1/s], before those of `trim_parameters.LIMITS`.
    settings
        Steps a wingbeat.

    Raises
    ------
    InvalidParameterError
        No stroke within the limits balances the weight, or what is given cannot be trimmed.
    """
    parameters = _parameters(fly, kinematics, moves, body_pitch, limits)
    settings = settings or MarchSettings()
    return _free_trim(fly, parameters, settings, _held_trim(fly, parameters, settings))


def tethered_trim(
    fly: FlappingFly,
    kinematics: StrokeKinematics,
    moves: tuple[str, str, str] = (FREQUENCY, "stroke_offset", "pitch_offset"),
    *,
    body_pitch: float = 0.0,
    limits: Limits | None = None,
    settings: MarchSettings | None = None,
) -> HoverTrim:
    """`hover_trim` of a body that is held at rest: only the mean loads balance. It is the other one's first stage."""
    parameters = _parameters(fly, kinematics, moves, body_pitch, limits)
    return _held_trim(fly, parameters, settings or MarchSettings())


def _parameters(
    fly: FlappingFly,
    kinematics: StrokeKinematics,
    moves: tuple[str, str, str],
    body_pitch: float,
    limits: Limits | None,
) -> TrimParameters:
    x, y, z = fly.gravity_W
    if not (x == y == 0.0 and z == -GRAVITY):
        raise InvalidParameterError(
            f"Hover is trimmed against gravity of {GRAVITY} m/s^2 straight down, got {fly.gravity_W!r} m/s^2."
        )
    start = FlownStroke(kinematics=kinematics, body_pitch=body_pitch)
    return TrimParameters(names=moves, start=start, limits=limits or {})


def _held_trim(fly: FlappingFly, parameters: TrimParameters, settings: MarchSettings) -> HoverTrim:
    def balance(scaled: FloatArray) -> Balance:
        return held_balance(fly, parameters.at(scaled), settings)

    def residuals(scaled: FloatArray) -> FloatArray:
        left = balance(scaled)
        return np.array([left.forward, left.down, left.pitch])

    found = _least_squares(residuals, parameters.guess, parameters.bounds)
    left = balance(found.at)
    _refuse_imbalance(fly, parameters, found, left, "held at rest")
    flown = parameters.at(found.at)
    rest = np.zeros(len(COORDINATES))
    rest[PITCH] = flown.body_pitch
    return HoverTrim(
        kinematics=flown.kinematics,
        start=unpacked(state_at(flown.kinematics, rest)),
        body="held",
        values=parameters.values(found.at),
        held_values=parameters.values(found.at),
        body_pitch=flown.body_pitch,
        balance=left,
        iterations=found.iterations,
        status=_status("held", left, found.iterations),
    )


def _free_trim(fly: FlappingFly, parameters: TrimParameters, settings: MarchSettings, held: HoverTrim) -> HoverTrim:
    def residuals(unknowns: FloatArray) -> FloatArray:
        return free_beat(fly, parameters.at(unknowns[:3]), unknowns[3:], settings).residuals

    guess = np.array([*parameters.scaled(held.values), 0.0, 0.0, 0.0, held.body_pitch])
    anywhere = np.full((2, len(LONGITUDINAL)), [[-np.inf], [np.inf]])
    found = _least_squares(residuals, guess, np.hstack([parameters.bounds, anywhere]))
    flown = parameters.at(found.at[:3])
    beat = free_beat(fly, flown, found.at[3:], settings)
    _refuse_imbalance(fly, parameters, found, beat.balance, "free to bob and nod")
    iterations = held.iterations + found.iterations
    return replace(
        held,
        kinematics=flown.kinematics,
        start=unpacked(beat.begin),
        body="free",
        values=parameters.values(found.at[:3]),
        body_pitch=flown.body_pitch,
        balance=beat.balance,
        iterations=iterations,
        status=_status("free", beat.balance, iterations),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Found:
    at: FloatArray
    largest: float  #: residual that is left
    iterations: int


def _least_squares(residuals: Callable[[FloatArray], FloatArray], guess: FloatArray, bounds: FloatArray) -> _Found:
    def jacobian(x: FloatArray) -> FloatArray:
        """Central differences; loads are kinked at reversals, so that a smaller step would see single kinks."""
        sides = [
            (residuals(x + step) - residuals(x - step)) / (2 * _DIFFERENCE) for step in _DIFFERENCE * np.eye(len(x))
        ]
        return np.stack(sides, axis=1)

    found = least_squares(
        residuals,
        guess,
        jac=jacobian,  # pyright: ignore[reportArgumentType]
        bounds=(bounds[0], bounds[1]),
        xtol=_TOLERANCE,
        ftol=_TOLERANCE,
        gtol=_TOLERANCE,
        max_nfev=_MOST_EVALUATIONS,
    )
    return _Found(at=found.x, largest=float(np.max(np.abs(found.fun))), iterations=int(found.njev))


def _status(body: str, left: Balance, iterations: int) -> str:
    what = (
        "Mean loads on the held body"
        if body == "held"
        else "A wingbeat of the free body ends where it began; net loads"
    )
    return f"{what} balance to {left.largest_load:.1g} of the weight after {iterations} iterations."


def _refuse_imbalance(fly: FlappingFly, parameters: TrimParameters, found: _Found, left: Balance, body: str) -> None:
    if found.largest < BALANCED:
        return
    values = parameters.values(found.at[:3])
    at = ", ".join(f"{name} = {value:.4g}" for name, value in values.items())
    ends = [name for name, value in values.items() if np.any(np.isclose(value, parameters.limit(name), rtol=1e-6))]
    end = f", {' and '.join(ends)} at the limit," if ends else ""
    raise InvalidParameterError(
        f"{fly.morphology.species} finds no hover with its body {body}: at best, with {at} (rad, 1/s){end} there "
        f"remain a net force of {left.forward:+.2g} weights forward and {-left.down:+.2g} upward and a pitch torque "
        f"of {left.pitch:+.2g} weights times wing lengths (largest residual {found.largest:.1g}). Widen the limits, "
        "move other parameters, or check mass and wings."
    )

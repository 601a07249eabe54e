"""What gamma/beta is made of: from Eq. 5's omega to the measured slope, factor by factor.

    gamma / beta = omega * C_D'/(2 C_D) * waveform * pitch * deviation * hinge to the side * hinge ahead * ...

Each factor is what gamma/beta changes by when one more part of the real wing is let in, in this order: the wing at one
attack angle with its hinge on the axis first, then its own pitch, its deviation, the hinge's place, and the terms of
the air beyond steady translation. The product is the measured ratio by construction; what a factor would be if its part
came last stands beside it, and where the two differ the parts interact. Review, Eq. 2-5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.coefficients import COEFFICIENTS, CoefficientName
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.quasi_steady import Term
from flycontrol.model.stroke import attack_angle
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import WingStroke
from flycontrol.reduce.idealised_strokes import LevelStroke, SquareStroke
from flycontrol.reduce.yaw_torque import YawExperiment, yaw_slopes

FloatArray = NDArray[np.float64]

_ANGLE = 1e-3  # [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class WingSpeeds:
    """Angular speeds that one may mean by omega; of one stroke, both wings alike [rad/s]."""

    mean: float  #: <|phi'|>, twice the stroke amplitude a wingbeat: the omega of this package
    rms: float  #: sqrt <phi'^2>
    by_drag: float  #: <phi'^2> / <|phi'|>: with it a stroke of any waveform obeys Eq. 5
    largest: float  #: max |phi'|


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnGainFactor:
    """One part of the wing and what it does to gamma/beta."""

    name: str
    factor: float  #: when it comes after the factors before it
    alone: float  #: when it comes last: all else is there already


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnGain:
    """gamma/beta of a stroke and its factors."""

    ratio: float  #: gamma / beta, measured [1/s]
    speeds: WingSpeeds
    attack: float  #: alpha_0, mean attack angle weighted with phi'^2 [rad]
    drag_slope: float  #: C_D'(alpha_0) / (2 C_D(alpha_0)) [1/rad]
    factors: tuple[TurnGainFactor, ...]

    @property
    def ideal(self) -> float:
        """omega C_D' / (2 C_D): Eq. 5 before anything of the real wing is let in [1/s]."""
        return self.speeds.mean * self.drag_slope

    @property
    def product(self) -> float:
        """omega C_D' / (2 C_D) times all factors [1/s]."""
        return self.ideal * float(np.prod([one.factor for one in self.factors]))

    @property
    def over_wing_speed(self) -> float:
        """gamma / (beta omega), 1 in Eq. 5 [1]."""
        return self.ratio / self.speeds.mean

    def __getitem__(self, name: str) -> TurnGainFactor:
        """A factor by its name; InvalidParameterError, a KeyError's sentence, if there is none."""
        for one in self.factors:
            if one.name == name:
                return one
        raise InvalidParameterError(
            f"No factor is named {name!r}; there are {', '.join(one.name for one in self.factors)}."
        )


def turn_gain(experiment: YawExperiment) -> TurnGain:
    """Measure gamma/beta and decompose it; the right wing's stroke stands for both where omega is taken.

    Raises
    ------
    InvalidParameterError
        The fly's air lacks the translational term, without which no factor has a beginning.
    """
    if "translational" not in experiment.fly.air.terms:
        raise InvalidParameterError(
            "gamma/beta is taken apart from steady translation on, and the fly's air lacks the translational term; got "
            f"{', '.join(experiment.fly.air.terms) or 'no air'}."
        )
    parts = _parts(experiment)
    ratios = [_ratio(experiment, parts[: count + 1]) for count in range(len(parts))]
    speeds, attack = _speeds(experiment), mean_attack(experiment.kinematics, experiment.instants)
    slope = drag_slope(experiment.fly.air.coefficients, attack)
    steps = np.array([speeds.mean * slope, *ratios])
    whole = ratios[-1]
    alone = [
        steps[1] / steps[0],
        *(whole / _ratio(experiment, parts[:k] + parts[k + 1 :]) for k in range(1, len(parts))),
    ]
    return TurnGain(
        ratio=whole,
        speeds=speeds,
        attack=attack,
        drag_slope=slope,
        factors=tuple(
            TurnGainFactor(name=name, factor=float(steps[k + 1] / steps[k]), alone=float(alone[k]))
            for k, name in enumerate(parts)
        ),
    )


def mean_attack(kinematics: StrokeKinematics, instants: int) -> float:
    """alpha_0 = <phi'^2 alpha> / <phi'^2> of the right wing [rad]."""
    motion, _ = kinematics.motion((np.arange(instants) + 0.5) / instants, "right")
    return float(np.average(attack_angle(motion.pitch, motion.stroke_rate), weights=motion.stroke_rate**2))


def drag_slope(coefficients: CoefficientName, attack: float) -> float:
    """C_D' / (2 C_D) at an attack angle [1/rad]; 1 at 45 deg where C_D ~ sin^2."""
    low, here, high = COEFFICIENTS[coefficients](attack + _ANGLE * np.array([-1.0, 0.0, 1.0])).drag
    return float((high - low) / (2 * _ANGLE) / (2 * here))


def _speeds(experiment: YawExperiment) -> WingSpeeds:
    motion, _ = experiment.kinematics.motion((np.arange(experiment.instants) + 0.5) / experiment.instants, "right")
    speed = np.abs(motion.stroke_rate)
    square = float(np.mean(speed**2))
    mean = float(speed.mean())
    return WingSpeeds(mean=mean, rms=float(np.sqrt(square)), by_drag=square / mean, largest=float(speed.max()))


_TERM_OF: dict[str, Term] = {
    "rotational force": "rotational",
    "added mass": "added_mass",
    "dissipative torque": "dissipative",
}


def _parts(experiment: YawExperiment) -> list[str]:
    """What the real wing has, in the order that it is let in; the first stands for the ideal wing itself."""
    always = ["waveform", "pitch", "deviation", "hinge to the side", "hinge ahead"]
    return [*always, *(name for name, term in _TERM_OF.items() if term in experiment.fly.air.terms)]


def _ratio(experiment: YawExperiment, parts: Sequence[str]) -> float:
    """gamma/beta of the wing with these parts alone [1/s]."""
    return yaw_slopes(
        replace(experiment, fly=_fly(experiment.fly, parts), kinematics=_kinematics(experiment, parts))
    ).turn_gain


def _fly(fly: FlappingFly, parts: Sequence[str]) -> FlappingFly:
    ahead, side, below = fly.morphology.right_hinge
    hinge = (ahead * ("hinge ahead" in parts), side * ("hinge to the side" in parts), below)
    terms: list[Term] = ["translational", *(term for name, term in _TERM_OF.items() if name in parts)]
    return replace(
        fly,
        morphology=replace(fly.morphology, right_hinge=hinge),
        air=replace(fly.air, terms=tuple(terms)),
    )


def _kinematics(experiment: YawExperiment, parts: Sequence[str]) -> StrokeKinematics:
    attack = mean_attack(experiment.kinematics, experiment.instants)

    def idealised(stroke: WingStroke) -> WingStroke:
        level = stroke if "deviation" in parts else LevelStroke(stroke=stroke)
        return level if "pitch" in parts else SquareStroke(stroke=level, attack=attack)

    return replace(
        experiment.kinematics,
        left=idealised(experiment.kinematics.left),
        right=idealised(experiment.kinematics.right),
    )

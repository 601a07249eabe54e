"""The spring whose passive pitching comes closest to a measured one.

min over kappa, C, eta_0 of  <(eta_passive - eta_measured)^2> over the wingbeat, the pitch axis given
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, least_squares

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.hinge_motion import EVERY_STEP, PassiveWingbeat, passive_wingbeat, sprung
from flycontrol.flight.settings import MarchSettings
from flycontrol.model.hinge import DampedSpring
from flycontrol.model.stroke_kinematics import StrokeKinematics

FloatArray = NDArray[np.float64]

#: Unknowns of the order of 1: m g c kappa', m g c C' / f, eta_0.
_LARGEST = (10.0, 10.0, np.pi)
_STARTS = (0.2, 1.0)
_LOST = 1.5  # residual where the wing tumbles: a quarter of a turn everywhere
_DIFFERENCE = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class HingeFit:
    """A spring, and how well it pitches a wing as it was seen to."""

    spring: DampedSpring
    pitch_axis: float  #: x0 [chords from the leading edge]
    rms: float  #: of passive less measured pitch over the wingbeat [rad]
    largest: float  #: of the same [rad]
    relative_spread: tuple[float, float, float]  #: see `fitted_spring`; kappa and C relative, eta_0 [rad]
    at_limit: bool  #: whether a parameter ended at the end of what was searched
    passive: PassiveWingbeat


def fitted_spring(
    fly: FlappingFly, stroke: StrokeKinematics, pitch_axis: float | None = None, settings: MarchSettings | None = None
) -> HingeFit:
    """Kappa, C and eta_0 of both hinges for the pitch that the stroke itself has.

    Parameters
    ----------
    fly
        Morphology and air; body held, wings alike.
    stroke
        A measured wingbeat, periodic: stroke and deviation drive the wings, the right one's pitch is matched.
    pitch_axis
        x0 in place of the morphology's [chords from the leading edge].
    settings
        Steps and samples a wingbeat; residuals are taken at the samples.

    Returns
    -------
    HingeFit
        `relative_spread` is how far each parameter can go, the others following, before the rms rises by 1 % of itself:
        sqrt(0.02 F (J^T J)^-1_ii), F the sum of squares, J the Jacobian. Residuals are model error, not noise, so this
        measures how sharp the minimum is and is no standard error.
    """
    fly = at_pitch_axis(fly, fly.morphology.pitch_axis if pitch_axis is None else pitch_axis)
    settings = settings or EVERY_STEP
    phase = np.arange(settings.samples) / settings.samples
    measured, scale = stroke.right(phase).angles[:, 2], _scale(fly, stroke)

    def residuals(unknowns: FloatArray) -> FloatArray:
        try:
            beat = passive_wingbeat(sprung(fly, _spring(unknowns, scale)), stroke, settings)
        except InvalidParameterError:
            return np.full(len(phase), _LOST)
        return beat.trajectory.right.pitch - measured

    found = min((_least_squares(residuals, start) for start in _STARTS), key=lambda one: float(one.cost))
    spring = _spring(found.x, scale)
    return HingeFit(
        spring=spring,
        pitch_axis=fly.morphology.pitch_axis,
        rms=float(np.sqrt(np.mean(found.fun**2))),
        largest=float(np.max(np.abs(found.fun))),
        relative_spread=_spread(found),
        at_limit=bool(np.any(found.active_mask)),
        passive=passive_wingbeat(sprung(fly, spring), stroke, settings),
    )


def pitch_axis_profile(
    fly: FlappingFly, stroke: StrokeKinematics, pitch_axes: Sequence[float], settings: MarchSettings | None = None
) -> tuple[HingeFit, ...]:
    """`fitted_spring` at each pitch axis: what the wingbeat says of it, and what the spring then has to be."""
    return tuple(fitted_spring(fly, stroke, x0, settings) for x0 in pitch_axes)


def at_pitch_axis(fly: FlappingFly, pitch_axis: float) -> FlappingFly:
    """The fly with its pitch axis elsewhere; a wing without a given mass distribution stays an even plate."""
    return replace(fly, morphology=replace(fly.morphology, pitch_axis=pitch_axis))


def _scale(fly: FlappingFly, stroke: StrokeKinematics) -> tuple[float, float]:
    """m g c [N m], what the air's torque on a wing is of the order of, and m g c / f [N m s]."""
    torque = fly.morphology.weight * fly.morphology.mean_chord
    return torque, torque / stroke.frequency


def _spring(unknowns: FloatArray, scale: tuple[float, float]) -> DampedSpring:
    kappa, damping, rest = (float(value) for value in unknowns)
    return DampedSpring(stiffness=kappa * scale[0], damping=damping * scale[1], rest_angle=rest)


def _least_squares(residuals: object, start: float) -> OptimizeResult:
    return least_squares(
        residuals,  # pyright: ignore[reportArgumentType]
        [start, 0.05, np.pi / 2],
        bounds=((0.0, 0.0, 0.0), _LARGEST),
        diff_step=_DIFFERENCE,
        xtol=1e-10,
        ftol=1e-10,
        max_nfev=60,
    )


def _spread(found: OptimizeResult) -> tuple[float, float, float]:
    covariance = np.linalg.pinv(found.jac.T @ found.jac)
    spread = np.sqrt(0.02 * 2 * found.cost * np.diag(covariance))
    kappa, damping, rest = (float(value) for value in spread / np.array([found.x[0], found.x[1], 1.0]))
    return kappa, damping, rest

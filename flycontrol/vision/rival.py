"""A wing that fits nearly as well turned about its span: how much less is known of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from flycontrol.units import deg
from flycontrol.vision.second_look import SecondLook, with_wing
from flycontrol.vision.silhouette_fit import SilhouetteFit, fit_silhouettes
from flycontrol.vision.stance import WING_TURN, step_between

_TWISTS = np.array([-120, -80, -40, 40, 80, 120]) * deg
_APART = 25 * deg  #: nearer to each other two fits are one
#: Share of its cost by which a right fit may be worse than a wrong one, by legs and by a shape not quite the fly's (C)
_UNDECIDED = 0.05
_WORTH = 1.4  #: times the cost of a fit: twists that cost more at a glance are not fitted (C)


def with_rivals(fit: SilhouetteFit, look: SecondLook) -> SilhouetteFit:
    """C + p d d^T for each wing, p = w / (1 + w), w = exp(-(J' - J) / (0.05 J)): the mixture of a fit and its rival.

    J is a fit's cost, J' that of the best fit with the wing turned about its span, d the turn between the two. Where
    the rival costs less, it takes the fit's place.
    """
    for side in (0, 1):
        rival = _rival(fit, look, side, look.cost(fit.stance) * _WORTH)
        if rival is None or not _is_another(fit, rival, side):
            continue
        fit, other = sorted((fit, rival), key=lambda each: each.agreement.cost)
        d = step_between(fit.stance, other.stance)[WING_TURN[side]]
        w = np.exp(-(other.agreement.cost / fit.agreement.cost - 1) / _UNDECIDED)
        covariance = fit.covariance.copy()
        covariance[WING_TURN[side], WING_TURN[side]] += w / (1 + w) * np.outer(d, d)
        fit = replace(fit, covariance=covariance)
    return fit


def _is_another(fit: SilhouetteFit, rival: SilhouetteFit, side: int) -> bool:
    return float(np.linalg.norm(step_between(fit.stance, rival.stance)[WING_TURN[side]])) > _APART


def _rival(fit: SilhouetteFit, look: SecondLook, side: int, worth: float) -> SilhouetteFit | None:
    """The best fit from a wing twisted, or None where no twist is worth one."""
    span, axes = fit.stance.wings_B[side][:, 0], fit.stance.wings_B[side]
    twisted = [
        with_wing(fit.stance, side, Rotation.from_rotvec(angle * span).as_matrix() @ axes) for angle in _TWISTS
    ]  # fmt: skip
    cost, k = min((look.cost(stance), k) for k, stance in enumerate(twisted))
    if cost > worth:
        return None
    return fit_silhouettes(look.border, look.shape, twisted[k], expected=look.expected, softness=(1.0,))

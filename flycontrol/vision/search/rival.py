"""A wing that fits nearly as well turned about its span: how much less is known of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.special import expit

from flycontrol.units import deg
from flycontrol.vision.search.second_look import SecondLook, with_wing
from flycontrol.vision.silhouette_fit import SilhouetteFit, fit_silhouettes
from flycontrol.vision.stance import WING_TURN, Stance, step_between

_TWISTS = np.array([-120, -80, -40, 40, 80, 120]) * deg
_APART = 25 * deg  #: nearer to each other two fits are one
#: Share of its cost by which a right fit may be worse than a wrong one, by legs and by a shape not quite the fly's (C)
_UNDECIDED = 0.05
_SURPRISE = 30 * deg  #: of a wing's turn from where it is expected: lower costs do not speak for every leap (C)
#: Times the cost of a fit: twists that cost more at a glance are not fitted. Those of 95 in 100 right fits cost more
#: than 1.6 times as much, those of wings settled 20 to 60 deg off, where they cost little more, 1.3 to 1.9 times (C)
WORTH = 1.8


def with_rivals(fit: SilhouetteFit, look: SecondLook, worth: float = WORTH, *, expecting: bool = True) -> SilhouetteFit:
    """C + p d d^T for each wing, p = w / (1 + w), w = exp((J - J') / (0.05 J)) (1 + e^2 / s^2) / (1 + e'^2 / s^2).

    The mixture of a fit and its rival, the best fit with the wing turned about its span: d is the turn between the two,
    J and J' are their costs, e and e' the wing's turns from where it is expected, s = 30 deg. Where the rival is the
    likelier one it takes the fit's place.

    Parameters
    ----------
    fit : that may be another's rival
    look : at the frame
    worth : twists that cost so many times as much, at a glance, are not fitted; inf where the fit is in question
    expecting : whether wings are expected anywhere; otherwise e = e' = 0
    """
    for side in (0, 1):
        rival = _rival(fit, look, side, look.cost(fit.stance) * worth)
        if rival is None:
            continue
        odds = _log_odds(fit, rival, look.expected if expecting else None, side)
        if not _is_another(fit, rival, side):
            fit = rival if odds > 0 else fit
            continue
        fit, other = (rival, fit) if odds > 0 else (fit, rival)
        d = step_between(fit.stance, other.stance)[WING_TURN[side]]
        covariance = fit.covariance.copy()
        covariance[WING_TURN[side], WING_TURN[side]] += expit(-abs(odds)) * np.outer(d, d)
        fit = replace(fit, covariance=covariance)
    return fit


def _log_odds(fit: SilhouetteFit, rival: SilhouetteFit, expected: Stance | None, side: int) -> float:
    """log w"""
    J, J_rival = fit.agreement.cost, rival.agreement.cost
    odds = (J - J_rival) / (_UNDECIDED * min(J, J_rival))
    if expected is not None:
        e, e_rival = (step_between(expected, each.stance)[WING_TURN[side]] for each in (fit, rival))
        odds += np.log1p(e @ e / _SURPRISE**2) - np.log1p(e_rival @ e_rival / _SURPRISE**2)
    return float(odds)


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

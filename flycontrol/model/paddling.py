"""Paddling: by how much the right wing's attack angle exceeds the left one's on the forward stroke."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.recording import Recording
from flycontrol.model.stroke import attack_angle, both_wings, wing_motion
from flycontrol.model.wingbeats import Wingbeats, wingbeat_mean

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Paddling:
    """Attack angles of both wings and their difference, over time and wingbeat by wingbeat.

    An average over a wingbeat is weighted by the square of the wings' stroke rate, phi'^2: drag goes with it, and at
    reversal, where it is zero, an attack angle means nothing.
    """

    series: FloatArray  #: (N,) d_alpha(t) = (eta_R - eta_L) / 2 [rad]
    attack_left: FloatArray  #: (N,) attack angle of the left wing [rad]
    attack_right: FloatArray  #: (N,) attack angle of the right wing [rad]
    weight: FloatArray  #: (N,) phi'^2, mean of both wings [rad^2/s^2]
    d_alpha: FloatArray  #: (n,) of each wingbeat [rad]
    mean_attack_left: FloatArray  #: (n, 2) of each forward and backward stroke [rad]
    mean_attack_right: FloatArray  #: (n, 2) of each forward and backward stroke [rad]
    mean_wing_speed: float  #: omega, mean |phi'| of both wings over all wingbeats [rad/s]


def paddling(recording: Recording, beats: Wingbeats) -> Paddling:
    """d_alpha = <phi'^2 (eta_R - eta_L)> / (2 <phi'^2>) over each wingbeat.

    Forward, alpha = eta and d_alpha = (alpha_R - alpha_L) / 2; backward, alpha = 180 deg - eta and
    d_alpha = (alpha_L - alpha_R) / 2: both are (eta_R - eta_L) / 2. Fig. 7d of the review plots twice that.
    """
    left_angles, right_angles = both_wings(recording)
    left, right = wing_motion(left_angles, recording.rate), wing_motion(right_angles, recording.rate)
    weight = 0.5 * (left.stroke_rate**2 + right.stroke_rate**2)
    series = 0.5 * (right.pitch - left.pitch)
    time = recording.time
    attack_left = attack_angle(left.pitch, left.stroke_rate)
    attack_right = attack_angle(right.pitch, right.stroke_rate)
    speed = 0.5 * (np.abs(left.stroke_rate) + np.abs(right.stroke_rate))
    inside = (time >= beats.reversals[0]) & (time <= beats.reversals[-1])
    return Paddling(
        series=series,
        attack_left=attack_left,
        attack_right=attack_right,
        weight=weight,
        d_alpha=wingbeat_mean(weight * series, time, beats) / wingbeat_mean(weight, time, beats),
        mean_attack_left=_half_strokes(attack_left, left.stroke_rate, time, beats),
        mean_attack_right=_half_strokes(attack_right, right.stroke_rate, time, beats),
        mean_wing_speed=float(speed[inside].mean()),
    )


def _half_strokes(attack: FloatArray, stroke_rate: FloatArray, time: FloatArray, beats: Wingbeats) -> FloatArray:
    """Return <phi'^2 alpha> / <phi'^2> over the forward and over the backward stroke of each wingbeat, (n, 2) [rad]."""
    beat = np.searchsorted(beats.reversals, time, side="right") - 1
    means = np.full((beats.count, 2), np.nan)
    for column, half in enumerate((stroke_rate > 0, stroke_rate < 0)):
        use = half & (beat >= 0) & (beat < beats.count)
        weight = np.bincount(beat[use], stroke_rate[use] ** 2, beats.count)
        means[:, column] = np.bincount(beat[use], (stroke_rate**2 * attack)[use], beats.count) / weight
    return means

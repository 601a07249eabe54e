"""d_alpha over time: from a channel of it, of twice it, or from the angles of both wings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flycontrol.io.experiment import PaddlingMapping
from flycontrol.io.places import Channel
from flycontrol.io.samples import read_samples
from flycontrol.io.table_files import Table

FloatArray = NDArray[np.float64]

LARGEST_PADDLING = np.pi  #: what no attack angle differs by [rad]
_TURN = 2 * np.pi  #: what no wing turns by [rad]


def read_paddling(table: Table, mapping: PaddlingMapping | None, time: FloatArray) -> FloatArray | None:
    """d_alpha, (n,) [rad]: right wing alpha0 + d_alpha, left wing alpha0 - d_alpha on the forward stroke.

    "right minus left, forward stroke" is Fig. 7d of the review, twice d_alpha. Of attack angles, right minus left is
    twice d_alpha on the forward stroke and minus twice d_alpha on the backward one. The wing pitch eta is the attack
    angle forward and 180 deg minus it backward, so that (eta_R - eta_L) / 2 is d_alpha on both.

    Raises
    ------
    InvalidInputError
        If a number is unusable, or too large for an angle in radians.
    """
    if mapping is None:
        return None
    if mapping.convention == "d_alpha":
        return _angle(table, mapping.difference)
    if mapping.convention == "right minus left, forward stroke":
        return 0.5 * _angle(table, mapping.difference)
    half_difference = 0.5 * (_angle(table, mapping.right, _TURN) - _angle(table, mapping.left, _TURN))
    if mapping.convention != "attack angle":
        return half_difference
    return half_difference * _forward(_angle(table, mapping.stroke, _TURN), time)


def _angle(table: Table, channel: Channel | None, limit: float = LARGEST_PADDLING) -> FloatArray:
    if channel is None:  # the mapping was read with a channel for every convention
        return np.full(len(table.numbers[0]), np.nan)
    samples = read_samples(table, channel, missing=True)
    beyond = np.flatnonzero(np.abs(samples.values) > limit)
    if beyond.size:
        sample = int(beyond[0])
        raise samples.refusal(sample, f"is {samples.values[sample]:.4g} rad; are the numbers degrees?")
    return samples.values


def _forward(stroke: FloatArray, time: FloatArray) -> FloatArray:
    """1 on the forward stroke, -1 on the backward one, NaN where the stroke is missing or stands still."""
    with np.errstate(over="ignore", invalid="ignore"):  # two times may lie as close as numbers can
        rate = np.gradient(stroke, time)
    return np.where(rate == 0, np.nan, np.sign(rate))

"""Blocked cross-validation within one recording: every fifth block of samples is predicted from all other blocks.

The blocks are longer than the noise is correlated, so that no sample is predicted by its neighbour's noise. All
unknowns are fitted to the blocks that remain, the recording's own ones too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.identify.gains.least_squares import WeightedProblem, minimise
from flycontrol.identify.gains.noise import Noise
from flycontrol.identify.gains.problem import Channel, FitProblem
from flycontrol.identify.gains.result import FitResult

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """How well what was left out is predicted."""

    scores: FloatArray  #: whitened sum of squares of each recording, or fold of blocks, left out
    error: float  #: root mean square [rad]


def blocks_left_out(found: FitResult, noise: Sequence[Sequence[Noise]], block: float, folds: int) -> Held:
    """Leave every block of a recording out once, `folds` blocks apart at a time.

    Parameters
    ----------
    found
        The fit to the whole recording, where each refit starts.
    noise
        By recording, by channel, to weigh and to count errors by.
    block
        Length of a block [s].

    Raises
    ------
    InvalidInputError
        If the recording has fewer blocks than folds.
    """
    problem = found.problem
    times = [channel.times for part in problem.parts for channel in part.channels]
    start, length = min(t[0] for t in times), max(t[-1] for t in times) - min(t[0] for t in times)
    if length < block * folds:
        raise InvalidInputError(
            f"{problem.trials[0].name}: {length:.3g} s are fewer than {folds} blocks of {block:.3g} s; "
            "choose shorter blocks or fewer folds."
        )
    scores, squares, samples = np.zeros(folds), 0.0, 0
    for fold in range(folds):
        rest, left = (_part_of(problem, start, block, folds, fold, inside) for inside in (False, True))
        fitted = minimise(WeightedProblem(rest, noise, found.weighted.loss), found.minimum.x, scale=1.0)
        rows = WeightedProblem(left, noise, found.weighted.loss).rows(fitted.x, False)
        scores[fold] = sum(float(r[0] @ r[0]) for channels in rows for r in channels)
        for part in left.parts:
            missed = part.channels[0].values - part.predicted(fitted.x, False)[0][0]
            squares, samples = squares + float(missed @ missed), samples + len(missed)
    return Held(scores, float(np.sqrt(squares / samples)))


def _part_of(problem: FitProblem, start: float, block: float, folds: int, fold: int, inside: bool) -> FitProblem:
    """The same problem with the samples of one fold, or with all others."""

    def kept(channel: Channel) -> Channel:
        mine = np.floor((channel.times - start) / block).astype(np.int64) % folds == fold
        return _selected(channel, mine if inside else ~mine)

    return replace(
        problem,
        parts=tuple(replace(part, channels=tuple(kept(c) for c in part.channels)) for part in problem.parts),
    )


def _selected(channel: Channel, keep: BoolArray) -> Channel:
    """Some samples of a channel; where one was left out before, noise begins anew."""
    stretch = np.zeros(len(keep), dtype=np.int64)
    stretch[channel.firsts] = 1
    stretch[1:] += keep[1:] != keep[:-1]
    number = np.cumsum(stretch)[keep]
    firsts = np.flatnonzero(np.diff(number, prepend=-1))
    return Channel(channel.kind, channel.times[keep], channel.values[keep], firsts.astype(np.int64))

"""Should something that was held at zero have been estimated? Rao's score test, without another fit.

    s = h^T V^-1 r,   var s = h^T V^-1 h - h^T V^-1 J C J^T V^-1 h,   s^2 / var s against Fisher's F(1, n - k),

h the derivative of the prediction with respect to what was held, J with respect to the unknowns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.special
from numpy.typing import NDArray

from flycontrol.identify.gains.least_squares import Minimum, WeightedProblem
from flycontrol.identify.gains.noise import Noise, whitened
from flycontrol.identify.gains.problem import TrialPart
from flycontrol.identify.gains.response import NAMES, UNITS
from flycontrol.identify.gains.uncertainty import LocalUncertainty

FloatArray = NDArray[np.float64]
HELD = ("initial_yaw", "initial_rate", "onset_shift")
_COLLINEAR = 1e-9  #: share of var s left, below which the unknowns already explain what was held
_MEANING = {
    "initial_yaw": "the fly was off its heading at the start",
    "initial_rate": "the fly was already turning at the start",
    "onset_shift": "the perturbation came at another time than recorded",
}
_WHAT = {"initial_yaw": "the yaw at the start", "initial_rate": "the yaw rate at the start", "onset_shift": "the onset"}


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreTest:
    """Of one parameter of one trial that was held."""

    kind: str
    trial: str
    p: float
    expected: float  #: one step's estimate of what it is, in `unit`
    unit: str

    @property
    def what(self) -> str:
        """What may be wrong, as a noun."""
        return _WHAT[self.kind]

    @property
    def sentence(self) -> str:
        """What the test means if p is small."""
        return f"{self.trial}: {_MEANING[self.kind]} (score test, p = {self.p:.2g}); estimate {self.kind}."


def score_tests(weighted: WeightedProblem, minimum: Minimum, uncertainty: LocalUncertainty) -> list[ScoreTest]:
    """Test of every initial yaw, initial rate and onset that was held, the most significant first."""
    problem, found = weighted.problem, list[ScoreTest]()
    C = np.where(np.isfinite(uncertainty.covariance), uncertainty.covariance, 0.0)
    freedom = max(problem.samples - len(problem.names), 1)
    for part, noises in zip(problem.parts, weighted.noise, strict=True):
        kinds = _held(part)
        square = _products(part, noises, minimum.x, [NAMES.index(kind) for kind in kinds])
        inner = C[part.grid]
        for row, kind in enumerate(kinds, 1 + len(part.active)):
            cross, whole, score = square[1 : 1 + len(part.active), row], float(square[row, row]), float(square[0, row])
            variance = whole - float(cross @ inner @ cross)
            if variance <= _COLLINEAR * whole:
                continue
            p = 1.0 - scipy.special.fdtr(1, freedom, score**2 / variance)
            found.append(
                ScoreTest(kind=kind, trial=part.trial.name, p=float(p), expected=score / variance, unit=UNITS[kind])
            )
    return sorted(found, key=lambda test: test.p)


def _held(part: TrialPart) -> list[str]:
    kinds = [kind for kind in HELD if NAMES.index(kind) not in part.active]
    return [kind for kind in kinds if kind != "onset_shift" or part.trial.perturbation is not None]


def _products(part: TrialPart, noises: Sequence[Noise], x: FloatArray, held: Sequence[int]) -> FloatArray:
    """Products of whitened residuals, J's columns and those of what is held, (1 + m + h, 1 + m + h)."""
    extra = np.arange(len(held))
    wider = replace(
        part, active=np.append(part.active, held).astype(np.int64), places=np.append(part.places, len(x) + extra)
    )
    extended = np.append(x, part.resting[list(held)])
    square = np.zeros((1 + len(wider.active),) * 2)
    for rows, channel, noise in zip(wider.predicted(extended), part.channels, noises, strict=True):
        rows[0] = channel.values - rows[0]
        W = whitened(rows, channel.firsts, noise)
        square += W @ W.T
    return square

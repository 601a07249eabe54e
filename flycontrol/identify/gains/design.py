"""What another experiment would have told: expected covariances from exact derivatives at the estimate.

    C = (sum over trials of J^T V^-1 J)^-1

with J at other sampling times, with a recording more, or with an unknown less; noise as estimated, fly as estimated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from flycontrol.identify.gains.noise import Noise, whitened
from flycontrol.identify.gains.problem import TrialPart
from flycontrol.identify.gains.response import evaluate, span_of
from flycontrol.identify.gains.result import FitResult
from flycontrol.units import ms

FloatArray = NDArray[np.float64]
_LONGER, _EARLIER = 30 * ms, 10 * ms
_MORE = "a second recording like each"
_STRONG = 0.5  #: correlation from which two unknowns are said to trade off
_SAME = 0.02  #: of correlations that are as good as equal
_LOCAL = ("impulse", "heading", "initial_yaw", "initial_rate")


@dataclass(frozen=True, slots=True, kw_only=True)
class Remedy:
    """What another experiment would do to two unknowns that trade off."""

    what: str  #: "30 ms more of recording"
    correlation: float  #: then
    errors: tuple[float, float]  #: standard errors then, over those now


@dataclass(frozen=True, slots=True, kw_only=True)
class TradeOff:
    """Two unknowns that make up for each other."""

    first: str
    second: str
    correlation: float
    remedies: tuple[Remedy, ...]  #: the most helpful first

    @property
    def sentence(self) -> str:
        """The trade-off and what would help most."""
        text = f"{self.first} and {self.second} trade off, correlation {self.correlation:+.2f}"
        if not self.remedies:
            return text + "."
        best = self.remedies[0]
        if abs(best.correlation - self.correlation) < _SAME:
            narrower = max(best.errors)
            return (
                f"{text}; {best.what} would not part them, but narrow both to {narrower:.0%} of their standard errors."
            )
        return (
            f"{text}; {best.what} would change it to {best.correlation:+.2f} and their standard errors to "
            f"{best.errors[0]:.0%} and {best.errors[1]:.0%} of what they are."
        )


def trade_offs(found: FitResult) -> tuple[TradeOff, ...]:
    """Pairs of shared unknowns that trade off, the strongest first, each with what would help."""
    names, now = found.problem.names, found.covariance
    kinds = found.problem.kinds
    shared = [i for i, kind in enumerate(kinds) if kind not in _LOCAL and np.isfinite(now[i, i])]
    others = [(what, C) for what, make in _designs(found) if (C := make()) is not None]
    pairs = [(i, j, _correlation(now, i, j)) for i, j in combinations(shared, 2)]
    strong = sorted((pair for pair in pairs if abs(pair[2]) > _STRONG), key=lambda pair: -abs(pair[2]))
    return tuple(
        TradeOff(first=names[i], second=names[j], correlation=r, remedies=_remedies(now, others, i, j))
        for i, j, r in strong
    )


def said_together(found: Sequence[TradeOff]) -> list[str]:
    """Sentences on trade-offs: those that only more recordings would narrow share one."""
    alike = [each for each in found if each.remedies and each.remedies[0].what == _MORE]
    rest = [each.sentence for each in found if each not in alike]
    if not alike:
        return rest
    pairs = ", ".join(f"{each.first} and {each.second} ({each.correlation:+.2f})" for each in alike)
    errors = max(max(each.remedies[0].errors) for each in alike)
    return [
        *rest,
        f"Correlated are {pairs}; of the experiments compared, more recordings help most: {_MORE} would narrow all of "
        f"these to {errors:.0%} of their errors and leave the correlations.",
    ]


def expected_covariance(
    found: FitResult, *, before: float = 0.0, after: float = 0.0, copies: int = 1, known: str | None = None
) -> FloatArray:
    """Covariance (k, k) that a fit of another experiment on the same fly is expected to have.

    Parameters
    ----------
    before, after
        More of each recording at its ends, sampled at its rate [s].
    copies
        How often each recording is repeated, each time with its own impulse, heading and initial motion.
    known
        Kind of an unknown that is measured otherwise: its rows and columns become zero.
    """
    problem, x = found.problem, found.minimum.x
    own = np.array([kind in _LOCAL or kind == "onset_shift" for kind in problem.kinds])
    matrix = np.zeros((len(x), len(x)))
    for part, noises in zip(problem.parts, found.noise, strict=True):
        matrix[part.grid] += _information(part, noises, x, before, after)
    for i, prior in problem.priors:
        matrix[i, i] += prior.deviation**-2 / (1 if own[i] else copies)
    free = np.array([kind != known for kind in problem.kinds]) & ~found.minimum.held
    C = np.zeros_like(matrix)
    size = np.sqrt(np.maximum(np.diag(matrix), 1e-300))[free]
    scaled = matrix[free][:, free] / (size * size[:, None])
    rows = np.flatnonzero(free)
    C[rows[:, None], rows] = np.linalg.pinv(scaled, hermitian=True) / (size * size[:, None])
    shared = ~own  # repeated recordings say as much of their own unknowns as one, of the shared ones in proportion
    rows = np.flatnonzero(shared)
    C[rows[:, None], rows] /= copies
    return C


def _designs(found: FitResult) -> list[tuple[str, Callable[[], FloatArray | None]]]:
    shared = set(found.problem.kinds)
    rest = found.problem.model.known
    at_rest = rest.get("initial_yaw") == 0.0 and rest.get("initial_rate") == 0.0
    return [
        (f"{_LONGER / ms:g} ms more of recording", lambda: expected_covariance(found, after=_LONGER)),
        (f"{_EARLIER / ms:g} ms more before the perturbation",
         lambda: None if at_rest else expected_covariance(found, before=_EARLIER)),
        (_MORE, lambda: expected_covariance(found, copies=2)),
        ("damping known from elsewhere",
         lambda: expected_covariance(found, known="damping") if "damping" in shared else None),
    ]  # fmt: skip


def _remedies(now: FloatArray, others: list[tuple[str, FloatArray]], i: int, j: int) -> tuple[Remedy, ...]:
    """Those that leave both unknowns unknown, sorted by the product of the errors that they leave."""
    found = [
        Remedy(
            what=what, correlation=_correlation(C, i, j),
            errors=(float(np.sqrt(C[i, i] / now[i, i])), float(np.sqrt(C[j, j] / now[j, j]))),
        )
        for what, C in others if C[i, i] > 0 and C[j, j] > 0
    ]  # fmt: skip
    return tuple(sorted(found, key=lambda remedy: remedy.errors[0] * remedy.errors[1]))


def _information(part: TrialPart, noises: tuple[Noise, ...], x: FloatArray, before: float, after: float) -> FloatArray:
    """J^T V^-1 J (m, m) of one trial, its recording lengthened."""
    yaw = part.channels[0]
    step = 1.0 / part.trial.rate
    first, last = yaw.times[0], yaw.times[-1]
    earlier = first - step * np.arange(int(np.rint(before / step)), 0, -1)
    later = last + step * np.arange(1, int(np.rint(after / step)) + 1)
    times = np.concatenate([earlier, yaw.times, later])
    firsts = np.concatenate([yaw.firsts[:1], yaw.firsts[1:] + len(earlier)])
    rows, _ = evaluate(part.parameters(x), part.active, part.drive, span_of(times, part.drive), times, False)
    W = whitened(rows[1:], firsts, noises[0])
    square = W @ W.T
    for rows_, channel, noise in list(zip(part.predicted(x), part.channels, noises, strict=True))[1:]:
        V = whitened(rows_[1:], channel.firsts, noise)
        square = square + V @ V.T
    return square


def _correlation(C: FloatArray, i: int, j: int) -> float:
    return float(C[i, j] / np.sqrt(C[i, i] * C[j, j]))

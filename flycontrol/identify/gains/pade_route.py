"""The same fit with a Pade approximant in place of the delay: an option, a cross-check, and its bias.

>>> from flycontrol.identify.gains.pade_route import fit_gains_with_pade
>>> fit_gains_with_pade([trial], order=4).bias_in_standard_errors  # doctest: +SKIP

Both fits weigh the samples with the noise that the exact fit found, so that they differ by the approximant alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.delay.pade import pade_matrices
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.least_squares import Loss, Minimum, WeightedProblem, minimise
from flycontrol.identify.gains.model import GainModel
from flycontrol.identify.gains.problem import FitProblem
from flycontrol.identify.gains.result import FitResult
from flycontrol.identify.gains.shooting import PadeShooting
from flycontrol.identify.gains.starts import starting_points
from flycontrol.identify.gains.uncertainty import local_uncertainty
from flycontrol.model.trial import Trial

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PadeFit:
    """A fit with the delay approximated, beside the exact one."""

    exact: FitResult
    order: int
    minimum: Minimum  #: least-squares values with the approximant
    covariance: FloatArray  #: (k, k) in the order of `names`

    @property
    def route(self) -> str:
        """What stands for the delay."""
        return f"Padé [{self.order}/{self.order}]"

    @property
    def names(self) -> tuple[str, ...]:
        """Of the unknowns, as in the exact fit."""
        return self.exact.problem.names

    @property
    def values(self) -> dict[str, float]:
        """Least-squares values with the approximant, in the units of `response.UNITS`."""
        return dict(zip(self.names, self.minimum.x.tolist(), strict=True))

    @property
    def bias(self) -> dict[str, float]:
        """What the approximant adds to the exact least-squares values."""
        return dict(zip(self.names, (self.minimum.x - self.exact.minimum.x).tolist(), strict=True))

    @property
    def bias_in_standard_errors(self) -> dict[str, float]:
        """The same in standard errors of the exact fit; zero where those are infinite."""
        return {name: shift / self.exact[name].standard_error for name, shift in self.bias.items()}

    @property
    def status(self) -> str:
        """A sentence: how the search ended and which unknown the approximant moves most."""
        if not self.minimum.converged:
            return f"{self.route}: not converged: the search stopped after {self.minimum.steps} steps."
        shifts = self.bias_in_standard_errors
        worst = max(shifts, key=lambda name: abs(shifts[name]))
        return (
            f"{self.route}: converged; against the exact delay {worst} moves by {shifts[worst]:+.2g} standard errors."
        )


def fit_gains_with_pade(
    trials: Sequence[Trial],
    model: GainModel | None = None,
    *,
    order: int = 4,
    noise: str | int = "auto",
    loss: Loss = "linear",
) -> PadeFit:
    """Fit trials with the exact delay, then with its [order/order] Pade approximant.

    Raises
    ------
    InvalidInputError
        As `fit_gains`, or if onset_shift is to be estimated.
    InvalidParameterError
        As `fit_gains`, or if the order is not an integer >= 1.
    """
    pade_matrices(order)  # refuses a bad order before any search
    return pade_fit(fit_gains(trials, model, noise=noise, loss=loss), order)


def pade_fit(exact: FitResult, order: int = 4) -> PadeFit:
    """Repeat a fit with the [order/order] Pade approximant of its delay, at the noise that it found.

    The search begins at the exact minimum and where the data themselves suggest; the lower end counts.
    """
    weighted = WeightedProblem(with_pade(exact.problem, order), exact.weighted.noise, exact.weighted.loss)
    starts = [exact.minimum.x, next(starting_points(exact.problem)).x]
    found = min((minimise(weighted, x) for x in starts), key=lambda it: (not it.converged, it.at.cost))
    return PadeFit(exact, order, found, local_uncertainty(weighted, found, bias=False).covariance)


def with_pade(problem: FitProblem, order: int) -> FitProblem:
    """The problem, each trial answered with the [order/order] Pade approximant of the delay."""
    return replace(problem, parts=tuple(replace(part, respond=PadeShooting(order)) for part in problem.parts))

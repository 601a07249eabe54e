"""A smooth curve seen through errors of which a part lasts: its likelihood and its posterior, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import factorial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from statsmodels.tsa.statespace.kalman_smoother import KalmanSmoother

FloatArray = NDArray[np.float64]

ORDER = 3  #: value, rate and acceleration
_STATES = ORDER + 2  #: and the lasting error with its rate

#: One frame on: f, f', f'' of the curve, and the covariance that white noise of density 1 in the third derivative adds.
_STEP = np.array([[1 / factorial(j - i) if j >= i else 0.0 for j in range(ORDER)] for i in range(ORDER)])
_WANDER = np.array([
    [1 / ((5 - i - j) * factorial(2 - i) * factorial(2 - j)) for j in range(ORDER)] for i in range(ORDER)
])  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Roughness:
    """The three numbers of a noisy spline, in its unit of length and in frames."""

    wander: float  #: q, density of the third derivative
    white: float  #: s
    lasting: float  #: a


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Posterior:
    """N frames of the states f, f', f'', c, c' given all observations; in frames, not seconds."""

    state: FloatArray  #: (N, 5)
    covariance: FloatArray  #: (N, 5, 5)

    @classmethod
    def unknown(cls, frames: int) -> Posterior:
        """NaN throughout."""
        state, covariance = np.full((frames, _STATES), np.nan), np.full((frames, _STATES, _STATES), np.nan)
        return cls(state=state, covariance=covariance)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NoisySpline:
    """y_n = f(n) + sigma_n (a c_n + s e_n),  E[c_n c_k] = (1 + kappa |n - k|) exp(-kappa |n - k|).

    The third derivative of f is white noise of density q, and so is e, of variance 1. The start of f is diffuse: the
    likelihood is the restricted one, and f given y is a quintic smoothing spline (wahba1978). The Kalman filter and
    smoother are those of statsmodels, with its exact diffuse start.
    """

    y: FloatArray  #: (N,) NaN where not seen
    sigma: FloatArray  #: (N,) > 0
    kappa: float  #: [1/frame]
    model: KalmanSmoother = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "model", _model(self.y, self.kappa))

    def log_likelihood(self, roughness: Roughness) -> float:
        """Of y, restricted."""
        self._roughen(roughness)
        return float(self.model.loglike())

    def posterior(self, roughness: Roughness) -> Posterior:
        """Of the states given y."""
        self._roughen(roughness)
        smoothed: Any = self.model.smooth()
        covariance = np.moveaxis(np.asarray(smoothed.smoothed_state_cov), -1, 0)
        return Posterior(state=np.asarray(smoothed.smoothed_state).T, covariance=covariance)

    def _roughen(self, roughness: Roughness) -> None:
        self.model["state_cov", :ORDER, :ORDER] = roughness.wander * _WANDER
        self.model["design", 0, ORDER] = roughness.lasting * self.sigma
        self.model["obs_cov", 0, 0] = (roughness.white * self.sigma) ** 2


def _model(y: FloatArray, kappa: float) -> KalmanSmoother:
    from statsmodels.tsa.statespace.initialization import Initialization  # a second or two
    from statsmodels.tsa.statespace.kalman_smoother import SMOOTHER_STATE, SMOOTHER_STATE_COV, KalmanSmoother

    model = KalmanSmoother(
        k_endog=1,
        k_states=_STATES,
        k_posdef=_STATES,
        selection=np.eye(_STATES),
        smoother_output=SMOOTHER_STATE | SMOOTHER_STATE_COV,
    )
    model.bind(np.asfortranarray(y[None]))
    # c'' + 2 kappa c' + kappa^2 c is white noise such that c has the variance 1
    step = np.exp(-kappa) * np.array([[1 + kappa, 1.0], [-(kappa**2), 1 - kappa]])
    stationary = np.diag([1.0, kappa**2])
    model["design"], model["obs_cov"] = np.zeros((1, _STATES, len(y))), np.zeros((1, 1, len(y)))
    model["design", 0, 0] = 1.0
    model["transition", :ORDER, :ORDER] = _STEP
    model["transition", ORDER:, ORDER:] = step
    model["state_cov", ORDER:, ORDER:] = stationary - step @ stationary @ step.T
    start = Initialization(_STATES)
    start.set((0, ORDER), "diffuse")
    start.set((ORDER, _STATES), "known", constant=np.zeros(2), stationary_cov=stationary)
    model.initialize(start)
    return model

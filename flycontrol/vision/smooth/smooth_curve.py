"""One coordinate of a track as a smooth function of time, wrong frames set aside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.optimize import minimize

from flycontrol.vision.smooth.noisy_spline import ORDER, NoisySpline, Posterior, Roughness

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

#: Of lasting errors [1/s]. In simulated flights at 8,000 frames a second those of the fitted fly agree by 0.85 to 0.98
#: from one frame to the next, by 0.4 to 0.67 after four; this gives 0.95 and 0.59 (C).
_KAPPA = 2800.0
_DRIFT = 100.0  #: of what neighbouring frames share [1/s]: it changes within a few wingbeats (C)
_FAR = 5.0  #: standard deviations from where the other frames expect a frame (C)
_NEAR = 3  #: frames to each side
_ROUNDS = 6  #: at most, of setting frames aside
_WRONG = 0.2  #: share of frames above which the stated spread is wrong, not the frames (C)
_PIECE, _PIECES = 400, 4  #: frames of a piece, and pieces, from which the likelihood is taken
_LOWEST, _HIGHEST = np.array([-30.0, -6.0]), np.array([8.0, 2.0])  #: of (ln q, ln s)
_SIMPLEX = np.array([[-6.0, -1.5], [-2.0, -1.5], [-6.0, -2.5]])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SmoothCurve:
    """N frames of one coordinate in a unit u; NaN outside the runs."""

    value: FloatArray  #: (N, 3) f, f', f'' [u, u/s, u/s^2]
    covariance: FloatArray  #: (N, 3, 3) of the three
    set_aside: BoolArray  #: (N,) seen, but too far from where the other frames expect it

    def with_common(self, variance: FloatArray) -> SmoothCurve:
        """The same curve, known less well by errors of a variance (N,) [u^2] that neighbouring frames share."""
        covariance = self.covariance.copy()
        for order in range(ORDER):
            covariance[:, order, order] += variance * _DRIFT ** (2 * order)
        return replace(self, covariance=covariance)


def smooth_curve(
    values: FloatArray, spread: FloatArray, runs: Sequence[slice], frame_rate: float, *, lasting: float | None
) -> SmoothCurve:
    """The curve behind the noisy values (N,) of one coordinate with its spread (N,); see `smooth_curves`."""
    return smooth_curves(values[:, None], spread[:, None], runs, frame_rate, lasting=lasting)[0]


def smooth_curves(
    values: FloatArray, spread: FloatArray, runs: Sequence[slice], frame_rate: float, *, lasting: float | None
) -> list[SmoothCurve]:
    """The curves behind noisy values: posteriors of `NoisySpline`, their roughness by restricted maximum likelihood.

    The error of a tracker lasts: what its model of the fly lacks is the same for many frames and averages out slowly.
    Frames further from the others' expectation than that and their own spread allow are set aside.

    Parameters
    ----------
    values : (N, K) [u], coordinates of one kind, which share their roughness; NaN where not seen
    spread : (N, K) [u], finite and > 0 where seen
    runs : frames that belong together
    frame_rate : [1/s]
    lasting : a, share of the stated spread that lasts; None: as large as the white one that the likelihood finds
        (a = s), the spread tells only its course
    """
    unit, middle = float(np.nanmedian(spread)), np.nanmedian(values, axis=0)
    y, sigma = (values - middle) / unit, np.where(np.isfinite(values), spread / unit, 1.0)
    aside = np.zeros(len(y), dtype=np.bool_)
    found, far = _fitted(y, sigma, runs, _KAPPA / frame_rate, lasting=lasting)
    for _ in range(_ROUNDS):
        if not far.any() or np.sum(aside | far) > _WRONG * np.sum(np.isfinite(y[:, 0])):
            break
        aside |= far
        kept = np.where(aside[:, None], np.nan, y)
        found, far = _fitted(kept, sigma, runs, _KAPPA / frame_rate, lasting=lasting)
    scale = np.array([unit * frame_rate**order for order in range(ORDER)])
    return [_in_units(one, aside, scale, offset) for one, offset in zip(found, middle, strict=True)]


def followed_curve(values: FloatArray, runs: Sequence[slice], frame_rate: float, corner: float) -> FloatArray:
    """(N, 3) f, f', f'' of the spline that follows what is slower than `corner` [rad/s]; (N,) values, NaN not seen."""
    # a smoothing spline of this order passes 1 / (1 + w^6 / q)
    roughness = Roughness(wander=(corner / frame_rate) ** 6, white=1.0, lasting=0.0)
    found = np.full((len(values), ORDER), np.nan)
    for run in runs:
        spline = NoisySpline(y=values[run], sigma=np.ones(run.stop - run.start), kappa=1.0)
        found[run] = spline.posterior(roughness).state[:, :ORDER]
    return np.asarray(found * frame_rate ** np.arange(ORDER), dtype=np.float64)


def _fitted(
    y: FloatArray, sigma: FloatArray, runs: Sequence[slice], kappa: float, *, lasting: float | None
) -> tuple[list[Posterior], BoolArray]:
    """K posteriors of all frames, and (N,) those that are far from any of them."""
    pieces = _some_pieces(np.isfinite(y[:, 0]), runs)
    roughness = _likeliest([spline for piece in pieces for spline in _splines(y, sigma, piece, kappa)], lasting=lasting)
    found, far = [Posterior.unknown(len(y)) for _ in y.T], np.zeros(len(y), dtype=np.bool_)
    for run in runs:
        for spline, whole in zip(_splines(y, sigma, run, kappa), found, strict=True):
            part = spline.posterior(roughness)
            whole.state[run], whole.covariance[run] = part.state, part.covariance
            far[run] |= _far(spline, part, roughness)
    return found, far


def _splines(y: FloatArray, sigma: FloatArray, frames: slice, kappa: float) -> list[NoisySpline]:
    return [NoisySpline(y=v[frames], sigma=s[frames], kappa=kappa) for v, s in zip(y.T, sigma.T, strict=True)]


def _some_pieces(seen: BoolArray, runs: Sequence[slice]) -> list[slice]:
    """Pieces of runs, of at most `_PIECE` frames and well seen, spread over the flight."""
    cut = [slice(k, min(k + _PIECE, run.stop)) for run in runs for k in range(run.start, run.stop, _PIECE)]
    content = np.array([np.sum(seen[piece]) for piece in cut])
    rich = np.flatnonzero(content >= 0.5 * content.max())
    chosen = np.unique(np.linspace(0, len(rich) - 1, _PIECES).round().astype(int))
    return [cut[rich[k]] for k in chosen]


def _in_units(found: Posterior, aside: BoolArray, scale: FloatArray, offset: float) -> SmoothCurve:
    value = found.state[:, :ORDER] * scale
    value[:, 0] += offset
    covariance = found.covariance[:, :ORDER, :ORDER] * np.outer(scale, scale)
    return SmoothCurve(value=value, covariance=covariance, set_aside=aside)


def _likeliest(splines: Sequence[NoisySpline], *, lasting: float | None) -> Roughness:
    def unlikelihood(x: FloatArray) -> float:
        inside = np.clip(x, _LOWEST, _HIGHEST)
        outside = float(np.sum((x - inside) ** 2))
        return outside - sum(spline.log_likelihood(_roughness(inside, lasting=lasting)) for spline in splines)

    options = {"initial_simplex": _SIMPLEX, "xatol": 0.1, "fatol": 0.1, "maxfev": 80}
    found = minimize(unlikelihood, _SIMPLEX[0], method="Nelder-Mead", options=options)
    return _roughness(np.clip(found.x, _LOWEST, _HIGHEST), lasting=lasting)


def _roughness(x: FloatArray, *, lasting: float | None) -> Roughness:
    white = float(np.exp(x[1]))
    return Roughness(wander=float(np.exp(x[0])), white=white, lasting=white if lasting is None else lasting)


def _far(spline: NoisySpline, found: Posterior, roughness: Roughness) -> BoolArray:
    """Where |y - E[y | other frames]| is beyond `_FAR` times its spread, and the most among the frames near.

    h is the weight of a frame in its own posterior.
    """
    load = np.stack([np.ones_like(spline.sigma), roughness.lasting * spline.sigma], axis=1)
    at = [0, ORDER]
    own = (roughness.white * spline.sigma) ** 2
    h = np.einsum("ni,nij,nj->n", load, found.covariance[:, at][:, :, at], load) / own
    h = np.minimum(h, 1 - 1e-6)
    away = (spline.y - np.sum(load * found.state[:, at], axis=1)) / (1 - h)
    far = np.nan_to_num(np.abs(away) / np.sqrt(own / (1 - h) + spline.sigma**2))
    # one wrong frame makes those beside it look wrong: the worst goes first
    return np.asarray((far > _FAR) & (far == maximum_filter1d(far, 2 * _NEAR + 1)))

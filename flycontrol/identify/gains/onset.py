"""When did an unknown pulse hit? A search over onsets by the regression that starts a fit.

For every onset of a grid and every delay the integrated equation of the loop is solved with a pulse there; the onset
whose residual is least is where the fit begins to search. Its length is taken as given: it hardly matters as long as it
is short against the reaction delay.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.problem import fit_problem
from flycontrol.identify.gains.regression import Regression, columns_of, displacement, regressions_of
from flycontrol.identify.gains.response import pulse_drive
from flycontrol.model.trial import Pulse, Trial

FloatArray = NDArray[np.float64]
_ONSETS = 120  #: tried in a trial
_LAGS = 12  #: delays tried with each [count]
_EARLIEST, _LATEST = 0.02, 0.9  #: of the trial's length: there must be something before and after


def with_located_pulses(trials: Sequence[Trial], duration: float = 4.5e-3) -> tuple[Trial, ...]:
    """Give every trial of unknown perturbation the pulse that explains its yaw best; others stay as they are.

    The onset is a starting value: estimate `onset_shift` beside the impulse, as `gain_model(estimate=["onset_shift"])`
    does. Whether there was a pulse at all is for the fit to say, by the impulse's interval.

    Parameters
    ----------
    duration
        Of the pulse [s].
    """
    if not (duration > 0 and np.isfinite(duration)):
        raise InvalidParameterError(f"The duration of a pulse must be > 0 s, got {duration!r}.")
    return tuple(
        trial if trial.perturbation is not None else replace(trial, perturbation=locate_pulse(trial, duration))
        for trial in trials
    )


def locate_pulse(trial: Trial, duration: float = 4.5e-3) -> Pulse:
    """The pulse of a duration [s] whose onset leaves the least residual in the integrated equation of the loop."""
    problem = fit_problem([replace(trial, perturbation=None)], gain_model(fixed={"initial_yaw": 0.0}))
    regression = regressions_of(problem)[0]
    n, start = len(regression.integrals[0]), float(problem.parts[0].channels[0].times[0])
    times = start + regression.step * np.arange(n, dtype=np.float64)
    onsets = np.linspace(
        times[0] + _EARLIEST * (times[-1] - times[0]), times[0] + _LATEST * (times[-1] - times[0]), _ONSETS
    )
    best = _residuals(regression, onsets, duration, start)
    return Pulse(onset=float(onsets[np.argmin(best)]), duration=duration)


def _residuals(regression: Regression, onsets: FloatArray, duration: float, start: float) -> FloatArray:
    """Least residual over the delays for each onset."""
    n, basis = regression.integrals.shape[1], regression.basis
    lags = np.unique(np.rint(np.geomspace(2e-3, 40e-3, _LAGS) / regression.step).astype(np.int64))
    lags = lags[(lags > 0) & (lags < n // 2)]
    columns = np.array([columns_of(regression, int(lag), ("damping", "kp", "kd"), {}) for lag in lags])
    columns /= np.maximum(np.sqrt(np.sum(columns**2, axis=2, keepdims=True)), 1e-300)
    rest = columns - (columns @ basis.T) @ basis
    pulses = [pulse_drive(Pulse(onset=float(t), duration=duration)) for t in onsets]
    push = np.array([displacement(pulse, start, regression.step, n) for pulse in pulses])
    push -= (push @ basis.T) @ basis
    push /= np.maximum(np.sqrt(np.sum(push**2, axis=1, keepdims=True)), 1e-300)
    along = np.einsum("on,lcn->olc", push, rest)
    left = rest @ np.swapaxes(rest, 1, 2) - along[..., :, None] * along[..., None, :]
    G, c = left[..., :3, :3] + 1e-9 * np.eye(3), left[..., :3, 3]
    gains = np.linalg.solve(G, c[..., None])[..., 0]
    return (left[..., 3, 3] - np.einsum("olc,olc->ol", gains, c)).min(axis=1)
